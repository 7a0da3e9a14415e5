//! Which published poses do not belong to the rest: after a jump of the frame, under another clock, on a course of their own.
//!
//! Poses are cut into segments where they jump and where they pause. Of an adjustment with all of them, the mean errors on both sides of a cut
//! say whether the frame is the same, and windows within it whether their course is the IMU's.

use crate::adjust::Adjusted;
use crate::align::PartOf;
use crate::config::TruthConfig;
use crate::problem::Problem;
use dpn_core::geometry::so3;
use dpn_core::signal::stats::median;
use dpn_core::trajectory::StampedPose;
use nalgebra::Vector3;
use std::ops::Range;

/// A jump of less is noise \[m\].
const LEAST_JUMP_M: f64 = 0.03;
/// The same of a rotation \[rad\].
const LEAST_JUMP_RAD: f64 = 0.05;
/// A jump is so many times the usual unevenness.
const JUMP: f64 = 12.0;
/// Next to a cut is within this \[s\].
const NEAR_S: f64 = 0.3;
/// Windows are looked at by this \[s\].
const WINDOW_S: f64 = 1.0;
/// A window disagrees when its error is so many times the usual one
const DISAGREE: f64 = 8.0;
/// and at least this \[m\]
const LEAST_ERROR_M: f64 = 0.015;
/// or this \[rad\].
const LEAST_ERROR_RAD: f64 = 0.03;

/// Poses that are taken in or left out together.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Segment {
    /// Their places.
    pub(crate) poses: Range<usize>,
    /// Why they are left out.
    pub(crate) why: &'static str,
}

/// Cuts the poses where they jump or pause.
pub(crate) fn segments(poses: &[StampedPose], config: &TruthConfig) -> Vec<Segment> {
    let step = |i: usize| {
        let (a, b) = (&poses[i], &poses[i + 1]);
        let seconds = b.t.seconds_since(a.t);
        let rise = b.world_from_body.translation.vector - a.world_from_body.translation.vector;
        let turn = so3::log(&(a.world_from_body.rotation.inverse() * b.world_from_body.rotation));
        (seconds, rise / seconds, turn / seconds)
    };
    // How much a step differs from those beside it.
    let uneven: Vec<(f64, f64)> = (0..poses.len() - 1)
        .map(|i| {
            let (seconds, rise, turn) = step(i);
            let beside: Vec<_> = [i.checked_sub(1), (i + 2 < poses.len()).then_some(i + 1)]
                .into_iter()
                .flatten()
                .map(step)
                .collect();
            let n = beside.len() as f64;
            let (mean_rise, mean_turn) = (
                beside.iter().map(|s| s.1).sum::<Vector3<f64>>() / n,
                beside.iter().map(|s| s.2).sum::<Vector3<f64>>() / n,
            );
            ((rise - mean_rise).norm() * seconds, (turn - mean_turn).norm() * seconds)
        })
        .collect();
    let usual = |part: fn(&(f64, f64)) -> f64| median(&uneven.iter().map(part).collect::<Vec<_>>());
    let far_m = LEAST_JUMP_M.max(JUMP * usual(|u| u.0));
    let far_rad = LEAST_JUMP_RAD.max(JUMP * usual(|u| u.1));
    // A jump shows in the steps beside it too, by half: the largest of three is it.
    let jumps = |i: usize| {
        let near = uneven[i.saturating_sub(1)..(i + 2).min(uneven.len())].iter();
        let top = near.fold((0.0_f64, 0.0_f64), |top, u| (top.0.max(u.0), top.1.max(u.1)));
        let (m, rad) = uneven[i];
        (m > far_m && m >= top.0) || (rad > far_rad && rad >= top.1)
    };
    let cut = |i: &usize| jumps(*i) || step(*i).0 > config.longest_gap_s;
    let mut from = 0;
    let mut out = Vec::new();
    for i in (0..poses.len() - 1).filter(cut) {
        out.push(Segment { poses: from..i + 1, why: "" });
        from = i + 1;
    }
    out.push(Segment { poses: from..poses.len(), why: "" });
    out
}

/// Segments, or windows of them, that do not belong to the rest; they are taken out of `segments`.
pub(crate) fn disagreeing(
    problem: &Problem<'_>,
    adjusted: &Adjusted,
    segments: &mut Vec<Segment>,
) -> Vec<Segment> {
    let errors = errors(problem, adjusted);
    let mean = |range: &Range<usize>, part: PartOf| {
        errors[range.clone()].iter().map(part).sum::<Vector3<f64>>() / range.len() as f64
    };
    // A frame that jumped: neighbours whose mean errors are far apart. The shorter goes.
    let mut worst: Option<(f64, usize)> = None;
    for i in 1..segments.len() {
        // Next to the cut: farther away the adjustment has bent the motion until it fits either.
        let time = |i: usize| problem.published[i].pose.t;
        let (before, after) = (&segments[i - 1].poses, &segments[i].poses);
        let near_before =
            before.clone().filter(|p| time(before.end - 1).seconds_since(time(*p)) < NEAR_S).count();
        let near_after = after.clone().filter(|p| time(*p).seconds_since(time(after.start)) < NEAR_S).count();
        let a = &(before.end - near_before..before.end);
        let b = &(after.start..after.start + near_after);
        let metres = (mean(a, |e| e.0) - mean(b, |e| e.0)).norm() / LEAST_ERROR_M;
        let radians = (mean(a, |e| e.1) - mean(b, |e| e.1)).norm() / LEAST_ERROR_RAD;
        let apart = metres.max(radians);
        if apart > 1.0 && worst.is_none_or(|(most, _)| apart > most) {
            worst = Some((apart, if before.len() < after.len() { i - 1 } else { i }));
        }
    }
    if let Some((_, i)) = worst {
        let segment = segments.remove(i);
        return vec![Segment { why: "its frame is not that of the poses beside it", ..segment }];
    }
    let windows = windows(problem, segments);
    let rms = |range: &Range<usize>, part: PartOf| {
        (errors[range.clone()].iter().map(|e| part(e).norm_squared()).sum::<f64>() / range.len() as f64)
            .sqrt()
    };
    let of = |part: PartOf| -> Vec<f64> { windows.iter().map(|w| rms(w, part)).collect() };
    let (metres, radians) = (of(|e| e.0), of(|e| e.1));
    let far_m = LEAST_ERROR_M.max(DISAGREE * median(&metres));
    let far_rad = LEAST_ERROR_RAD.max(DISAGREE * median(&radians));
    let bad = |i: &usize| metres[*i] > far_m || radians[*i] > far_rad;
    let bad: Vec<Segment> = (0..windows.len())
        .filter(bad)
        .map(|i| Segment { poses: windows[i].clone(), why: "it does not move as the IMU says" })
        .collect();
    for window in &bad {
        cut_out(segments, &window.poses);
    }
    bad
}

/// What every published pose is off by: its slow error and what is left.
pub(crate) fn errors(problem: &Problem<'_>, adjusted: &Adjusted) -> Vec<(Vector3<f64>, Vector3<f64>)> {
    let terms = problem.terms(&adjusted.estimate);
    let of = |(k, term): &(usize, crate::published::PoseTerm)| {
        let key = &adjusted.estimate.keys[*k];
        let residual = |at| term.residual.fixed_rows::<3>(at).into_owned();
        (key.position_error + residual(0), key.rotation_error + residual(3))
    };
    terms.iter().map(of).collect()
}

/// Windows of a second within the segments.
fn windows(problem: &Problem<'_>, segments: &[Segment]) -> Vec<Range<usize>> {
    let mut out = Vec::new();
    for segment in segments {
        let mut from = segment.poses.start;
        for i in segment.poses.clone() {
            let begin = problem.published[from].pose.t;
            if problem.published[i].pose.t.seconds_since(begin) >= WINDOW_S {
                out.push(from..i);
                from = i;
            }
        }
        if from < segment.poses.end {
            out.push(from..segment.poses.end);
        }
    }
    out
}

/// The segments without the places of `gone`.
fn cut_out(segments: &mut Vec<Segment>, gone: &Range<usize>) {
    *segments = std::mem::take(segments)
        .into_iter()
        .flat_map(|s| {
            let before = s.poses.start..gone.start.clamp(s.poses.start, s.poses.end);
            let after = gone.end.clamp(s.poses.start, s.poses.end)..s.poses.end;
            [before, after].map(|poses| Segment { poses, why: s.why })
        })
        .filter(|s| !s.poses.is_empty())
        .collect();
}
