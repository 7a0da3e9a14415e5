//! From a recording and its published ground truth to a reconciled one.

use crate::adjust::{Adjusted, adjust};
use crate::align::{Guess, guess};
use crate::components::Levels;
use crate::config::TruthConfig;
use crate::dense::{dense, deviations};
use crate::error::TruthError;
use crate::layout::{CONSTANT_GROUPS, CONSTANTS};
use crate::problem::{Problem, Role};
use crate::report::{Report, report};
use crate::screen::{Segment, disagreeing, segments};
use crate::start::start;
use dpn_core::config::Validate;
use dpn_core::trajectory::StampedPose;
use dpn_core::truth::{GroundTruth, TrueState};
use dpn_core::{ImuRecording, ImuSample, SampleRate};
use nalgebra::SVector;

/// The fewest poses and samples.
pub(crate) const LEAST: usize = 100;
/// How often a part that disagrees is taken out before the rest is taken as it is.
pub(crate) const MOST_ROUNDS: usize = 6;

/// A reconciled ground truth and what is to be known of it.
#[derive(Debug, Clone)]
pub struct Reconciled {
    /// States at the IMU's samples, wherever they are known well enough; velocities and biases with them.
    pub truth: GroundTruth,
    /// What was found, and how far to trust it where.
    pub report: Report,
}

/// An adjustment of samples and poses that fit together, and what was left out for it.
pub(crate) struct Settled<'a> {
    pub(crate) problem: Problem<'a>,
    pub(crate) adjusted: Adjusted,
    pub(crate) guessed: Guess,
    pub(crate) left_out: Vec<Segment>,
}

/// Reconciles `published` with `recording`.
///
/// # Errors
/// Settings out of bounds; too little of either; rates that do not agree; what is no gravity; nothing that can be trusted.
pub fn reconcile(
    recording: &ImuRecording,
    published: &GroundTruth,
    config: &TruthConfig,
) -> Result<Reconciled, TruthError> {
    let pose = |s: &TrueState| StampedPose { t: s.t, world_from_body: s.world_from_body };
    let poses: Vec<StampedPose> = published.states().iter().map(pose).collect();
    let Settled { problem, adjusted, guessed, left_out } =
        settle(recording.samples(), recording.rate(), &poses, config, MOST_ROUNDS)?;
    let deviations = deviations(&adjusted.covariance);
    let good = |k: &usize| {
        let (position, rotation) = deviations[*k];
        position <= config.position_limit_m && rotation.to_degrees() <= config.rotation_limit_deg
    };
    let states: Vec<TrueState> =
        dense(&problem, &adjusted.estimate).into_iter().filter(|(k, _)| good(k)).map(|(_, s)| s).collect();
    let report = report(&problem, &adjusted, &guessed, &deviations, &left_out, config);
    let truth = GroundTruth::new(states).map_err(|_| nothing_trusted(&deviations, config))?;
    Ok(Reconciled { truth, report })
}

/// Adjusts samples of `rate` and poses until both and the levels stand, without what does not belong to the rest, of which it is rid in `most_rounds` at most.
///
/// # Errors
/// As [`reconcile`], but for trust.
pub(crate) fn settle<'a>(
    samples: &'a [ImuSample],
    rate: SampleRate,
    poses: &[StampedPose],
    config: &TruthConfig,
    most_rounds: usize,
) -> Result<Settled<'a>, TruthError> {
    config.validate()?;
    let too_short = |poses: usize, samples: usize| TruthError::TooShort { poses, samples, least: LEAST };
    if poses.len() < LEAST || samples.len() < LEAST {
        return Err(too_short(poses.len(), samples.len()));
    }
    let guessed = guess(samples, poses, config)?;
    let delay = guessed.frames.delay_s;
    let (first, last) = (poses[0].t.plus_seconds(-delay), poses[poses.len() - 1].t.plus_seconds(-delay));
    let from = samples.partition_point(|s| s.t < first);
    let to = samples.partition_point(|s| s.t <= last);
    let (all, samples) = (samples, &samples[from.min(to)..to]);
    let (Some(begin), Some(end)) = (samples.first(), samples.last()) else {
        return Err(TruthError::no_overlap(poses, all));
    };
    let inside: Vec<StampedPose> = poses
        .iter()
        .filter(|pose| (begin.t..=end.t).contains(&pose.t.plus_seconds(-delay)))
        .copied()
        .collect();
    if inside.len() < LEAST || samples.len() < LEAST {
        return Err(too_short(inside.len(), samples.len()));
    }
    let (mut problem, mut estimate) = start(samples, &inside, rate, guessed.frames, config);

    let mut segments = segments(&inside, config);
    let mut left_out: Vec<Segment> = Vec::new();
    let adjusted = loop {
        problem.held.clear();
        let mut adjusted = adjust(&problem, estimate.clone(), Levels::start(), config.most_iterations)?;
        hold_insignificant(&mut problem, &mut adjusted);
        if !problem.held.is_empty() {
            adjusted = adjust(&problem, adjusted.estimate, adjusted.levels, config.most_iterations)?;
        }
        let bad = disagreeing(&problem, &adjusted, &mut segments);
        if bad.is_empty() || left_out.len() >= most_rounds {
            break adjusted;
        }
        for segment in bad {
            problem.published[segment.poses.clone()].iter_mut().for_each(|p| p.role = Role::LeftOut);
            left_out.push(segment);
        }
        estimate.frames = guessed.frames;
    };
    Ok(Settled { problem, adjusted, guessed, left_out })
}

/// Holds the groups of constants that cannot be told from the neutral ones there: a lever of chance would move every pose.
fn hold_insignificant(problem: &mut Problem<'_>, adjusted: &mut Adjusted) {
    let to_neutral = adjusted.estimate.frames.to_neutral();
    let mut step = SVector::<f64, CONSTANTS>::zeros();
    for (at, count, beyond) in CONSTANT_GROUPS {
        let covariance = adjusted.covariance.constants.view((at, at), (count, count)).into_owned();
        let off = to_neutral.rows(at, count).into_owned();
        let square = covariance.cholesky().map_or(f64::INFINITY, |c| off.dot(&c.solve(&off)));
        if square < beyond {
            problem.held.push(at);
            step.rows_mut(at, count).copy_from(&off);
        }
    }
    adjusted.estimate.frames = adjusted.estimate.frames.plus(&step);
}

fn nothing_trusted(deviations: &[(f64, f64)], config: &TruthConfig) -> TruthError {
    let least = |part: fn(&(f64, f64)) -> f64| deviations.iter().map(part).fold(f64::INFINITY, f64::min);
    TruthError::NothingTrusted {
        position_limit_m: config.position_limit_m,
        rotation_limit_deg: config.rotation_limit_deg,
        best_m: least(|d| d.0),
        best_deg: least(|d| d.1).to_degrees(),
    }
}
