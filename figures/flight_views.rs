//! What a run looks like: from above, and over time.

use super::belief::PoseBelief;
use super::chart::Chart;
use super::error::FigureError;
use super::table::Cell;
use super::timeline::{TimelinePanel, over_time};
use super::top_view::from_above;
use super::trajectory_errors::{LineOverTime, Path, poses_over_time};
use dpn_core::trajectory::StampedPose;
use dpn_core::{Sensor, Stamp};
use dpn_eval::closed_loop::{JudgedRun, LearnedLevels, MAX_GAP_S, Recording};
use dpn_eval::metrics::{
    Alignment, AlignmentKind, Interpolation, PosePair, TruthOptions, TruthTrack, align,
    associate_interpolated,
};
use dpn_vio::estimator::Phase;
use nalgebra::Isometry3;

/// Poses farther apart than this are not joined \[s\].
const BROKEN_S: f64 = 1.0;

/// The run from above, aligned in yaw and position to the truth where there is any.
///
/// # Errors
/// No pose and no truth.
pub fn top_view(recording: &Recording, run: &JudgedRun) -> Result<Chart, FigureError> {
    let poses = run.output.poses();
    let alignment = aligned(recording, &poses).map(|(_, alignment)| alignment);
    let xy = |pose: &StampedPose| {
        let moved = alignment
            .as_ref()
            .map_or(pose.world_from_body, |alignment| alignment.apply(&pose.world_from_body));
        [moved.translation.x, moved.translation.y]
    };
    let estimate: Vec<Vec<[f64; 2]>> = poses
        .chunk_by(|a, b| b.t.seconds_since(a.t) <= BROKEN_S)
        .map(|part| part.iter().map(xy).collect())
        .collect();
    // Of the truth only what was run.
    let frames = &run.output.frames;
    let within = |t: Stamp| frames.first().is_some_and(|f| *f <= t) && frames.last().is_some_and(|f| t <= *f);
    let truth: Vec<[f64; 2]> = recording
        .truth
        .iter()
        .flatten()
        .filter(|pose| within(pose.t))
        .map(|pose| [pose.world_from_body.translation.x, pose.world_from_body.translation.y])
        .collect();
    let row = &run.report.row;
    let caption = match (alignment, row.ate_yaw) {
        (Some(_), Some(ate)) => format!(
            "Aligned in yaw and position; RMSE {} m. {} poses of {} frames, {} restarts.",
            Cell::metres(ate).shown(),
            row.poses,
            row.frames,
            row.restarts
        ),
        _ => format!("Not aligned. {} poses of {} frames, {} restarts.", row.poses, row.frames, row.restarts),
    };
    from_above(format!("{}, noise {}", row.sequence, row.noise), &truth, &estimate, caption)
}

/// The poses that have a truth, and what brings them to it in yaw and position.
fn aligned(recording: &Recording, poses: &[StampedPose]) -> Option<(Vec<PosePair>, Alignment)> {
    let options = TruthOptions { max_gap_s: MAX_GAP_S, interpolation: Interpolation::Linear };
    let track = TruthTrack::new(recording.truth.as_deref()?, options).ok()?;
    let pairs = associate_interpolated(&track, poses).ok()?.pairs;
    let alignment = align(&pairs, AlignmentKind::YawPosition).ok()?;
    Some((pairs, alignment))
}

/// Positions and angles over time, the estimate before the truth, and around it three deviations where they are believed.
fn pose_panels(recording: &Recording, run: &JudgedRun, seconds: impl Fn(Stamp) -> f64) -> Vec<TimelinePanel> {
    let poses = run.output.poses();
    let (pairs, alignment) = match aligned(recording, &poses) {
        Some((pairs, alignment)) => (pairs, alignment),
        None => (Vec::new(), Alignment::identity()),
    };
    let moved: Vec<Isometry3<f64>> =
        poses.iter().map(|pose| alignment.apply(&pose.world_from_body)).collect();
    let mut estimate =
        Path::of("estimate", poses.iter().zip(&moved).map(|(pose, moved)| (seconds(pose.t), moved)));
    let beliefs: Vec<PoseBelief> = run
        .output
        .covariances()
        .unwrap_or_default()
        .iter()
        .zip(&poses)
        .map(|(covariance, pose)| PoseBelief::of_right(pose.t, &pose.world_from_body, covariance))
        .collect();
    let all = poses.iter().zip(&moved).map(|(pose, moved)| (pose.t, seconds(pose.t), moved));
    estimate.believed(&beliefs, &alignment, all);
    let truth = Path::of("truth", pairs.iter().map(|pair| (seconds(pair.t), &pair.true_world_from_body)));
    let rows = poses_over_time(Some(&truth).filter(|_| !pairs.is_empty()), &[estimate]);
    let panel = |(label, lines): (String, Vec<LineOverTime>)| {
        let band = lines.iter().flat_map(|line| &line.band).copied().collect();
        let lines = lines.into_iter().rev().map(|line| (line.name, line.points)).collect();
        TimelinePanel { label, log: false, lines, band }
    };
    rows.into_iter().map(panel).collect()
}

/// The run over time: poses beside the truth, tracks, parallax, noise given, biases, residuals.
///
/// # Errors
/// A run without frames.
pub fn timeline(recording: &Recording, run: &JudgedRun) -> Result<Chart, FigureError> {
    let updates = &run.output.updates;
    let first = run.output.frames.first().copied().unwrap_or(Stamp::from_ns(0));
    let seconds = |t: Stamp| t.seconds_since(first);
    let of_updates = |value: &dyn Fn(&dpn_vio::estimator::Update) -> Option<f64>| {
        updates.iter().filter_map(|u| Some((seconds(u.t), value(u)?))).collect::<Vec<_>>()
    };
    let running = |u: &dpn_vio::estimator::Update| u.state.is_some();
    let line = |name: &str, points: Vec<(f64, f64)>| (name.to_owned(), points);
    let axes = |name: &str, value: &dyn Fn(&dpn_vio::estimator::Update, usize) -> Option<f64>| {
        ["x", "y", "z"]
            .into_iter()
            .zip(0..3)
            .map(|(axis, k)| line(&format!("{name}{axis}"), of_updates(&|u| value(u, k))))
            .collect::<Vec<_>>()
    };
    let counts = run.frames.iter().map(|frame| (seconds(frame.t), frame.tracks as f64)).collect();
    let ways = run.frames.iter().filter_map(|frame| Some((seconds(frame.t), frame.way_px?))).collect();
    let panel = |label: &str, log, lines| TimelinePanel { label: label.into(), log, lines, band: Vec::new() };
    let noise = |sensor: Sensor| {
        let axis = |k: usize| {
            let stamped = run.noise.stamps().iter().zip(run.noise.noises());
            let within = |(t, _): &(f64, f64)| (0.0..=run.output.data_s).contains(t);
            stamped.map(|(t, noise)| (seconds(*t), noise.of(sensor)[k])).filter(within).collect()
        };
        ["x", "y", "z"].into_iter().zip(0..3).map(|(name, k)| line(name, axis(k))).collect()
    };
    let level = |value: &dyn Fn(LearnedLevels) -> f64| {
        of_updates(&|u| Some(value(LearnedLevels::of(u.levels.as_deref()?))))
    };
    let mut panels = pose_panels(recording, run, seconds);
    panels.extend([
        panel(
            "tracks in a frame",
            false,
            vec![
                line("all", counts),
                line("in the window", of_updates(&|u| running(u).then_some(u.tracked as f64))),
                line("landmarks with a depth", of_updates(&|u| running(u).then_some(u.landmarks as f64))),
            ],
        ),
        panel("median way of a track since the frame before [px]", false, vec![line("", ways)]),
        panel("accelerometer noise in force [m/s²]", true, noise(Sensor::Accel)),
        panel("gyroscope noise in force [rad/s]", true, noise(Sensor::Gyro)),
        // Without levels that are learned it has no points, and is left out.
        panel(
            "estimated, times what is given",
            true,
            vec![
                line("accelerometer's walk", level(&|l| l.accel_walk)),
                line("gyroscope's walk", level(&|l| l.gyro_walk)),
                line("pixels", level(&|l| l.pixel)),
            ],
        ),
        panel("accelerometer bias [m/s²]", false, axes("", &|u, k| Some(u.state?.bias.accel[k]))),
        panel("gyroscope bias [rad/s]", false, axes("", &|u, k| Some(u.state?.bias.gyro[k]))),
        panel(
            "whitened inertial residual (1 where the noise is right), outliers",
            false,
            vec![
                line("residual", of_updates(&|u| Some((u.whitened? / 9.0).sqrt()))),
                line("outliers", of_updates(&|u| running(u).then_some(u.outliers as f64))),
            ],
        ),
    ]);
    let marks: Vec<f64> =
        updates.iter().filter(|u| matches!(u.phase, Phase::Restarted(_))).map(|u| seconds(u.t)).collect();
    let row = &run.report.row;
    let mut caption = "Dashed: restarts.".to_owned();
    if panels.iter().any(|panel| !panel.band.is_empty()) {
        caption.push_str(" Bands: three deviations, as believed.");
    }
    if let Some(figures) = &row.front_end {
        let agreed = figures.inlier_share.map_or_else(String::new, |share| {
            format!("; {:.1} % of the tracks agreed on the camera's motion", 100.0 * share)
        });
        caption =
            format!("{} images, {} passed over{agreed}. {caption}", figures.images, figures.passed_over);
    }
    over_time(format!("{}, noise {}", row.sequence, row.noise), panels, marks, caption)
}
