//! One run of the estimator over one recording.

use super::error::ClosedLoopError;
use super::recording::{Recording, Span};
use cpu_time::ThreadTime;
use dpn_core::trajectory::StampedPose;
use dpn_core::{NoiseTrack, Stamp, TrackFrame};
use dpn_vio::estimator::{Estimator, EstimatorConfig, RunReport, Update};
use dpn_vio::preint::NoisySample;
use nalgebra::Matrix6;

/// Fewest frames with samples that are worth a run.
pub const FEWEST_FRAMES: usize = 20;

/// What a run left.
#[derive(Debug, Clone)]
pub struct Driven {
    /// One a frame that was worked off.
    pub updates: Vec<Update>,
    /// The estimator's own totals.
    pub report: RunReport,
    /// CPU time of the whole run on its thread, feeding included \[s\].
    pub cpu_s: f64,
    /// CPU time of each update \[s\].
    pub update_cpu_s: Vec<f64>,
    /// From the first to the last frame handed over \[s\].
    pub data_s: f64,
    /// Stamps of the frames handed over.
    pub frames: Vec<Stamp>,
}

impl Driven {
    /// The estimated trajectory: the newest pose at every frame that has one, as it was known then.
    pub fn poses(&self) -> Vec<StampedPose> {
        let pose = |u: &Update| Some(StampedPose { t: u.t, world_from_body: u.state?.world_from_body });
        self.updates.iter().filter_map(pose).collect()
    }

    /// Covariances of the poses, where every pose has one.
    pub fn covariances(&self) -> Option<Vec<Matrix6<f64>>> {
        self.updates.iter().filter(|u| u.state.is_some()).map(|u| u.covariance).collect()
    }
}

/// The frames within `span`, having checked that there are samples for them.
///
/// # Errors
/// Fewer than [`FEWEST_FRAMES`] left, or within the samples.
pub fn frames_from<'a>(
    recording: &Recording,
    frames: &'a [TrackFrame],
    span: &Span,
) -> Result<&'a [TrackFrame], ClosedLoopError> {
    let sequence = || recording.name.clone();
    let (Some(first), Some(last)) = (frames.first(), frames.last()) else {
        return Err(ClosedLoopError::NothingLeft {
            sequence: sequence(),
            seconds: 0.0,
            from_s: span.from_s,
            to_s: span.to_s,
            needed: FEWEST_FRAMES,
        });
    };
    let samples = recording.imu.samples();
    let (imu_first, imu_last) = (samples[0].t, samples[samples.len() - 1].t);
    let inside =
        |frames: &[TrackFrame]| frames.iter().filter(|f| imu_first <= f.t && f.t <= imu_last).count();
    if inside(frames) < FEWEST_FRAMES {
        return Err(ClosedLoopError::Apart {
            sequence: sequence(),
            frames: frames.len(),
            first_ns: first.t.ns(),
            last_ns: last.t.ns(),
            imu_first_ns: imu_first.ns(),
            imu_last_ns: imu_last.ns(),
            needed: FEWEST_FRAMES,
        });
    }
    let left = span.of(frames, |frame| frame.t);
    if inside(left) < FEWEST_FRAMES {
        return Err(ClosedLoopError::NothingLeft {
            sequence: sequence(),
            seconds: last.t.seconds_since(first.t),
            from_s: span.from_s,
            to_s: span.to_s,
            needed: FEWEST_FRAMES,
        });
    }
    Ok(left)
}

/// Feeds samples with their noise and frames in the order of time, and takes every update as soon as it can be had.
///
/// `noise` has a value at each of the recording's samples; `seed` is the estimator's.
///
/// # Errors
/// Settings out of their bounds; frames whose stamps do not increase.
pub fn drive(
    config: &EstimatorConfig,
    recording: &Recording,
    frames: &[TrackFrame],
    noise: &NoiseTrack,
    seed: u64,
) -> Result<Driven, ClosedLoopError> {
    let refused = |source| ClosedLoopError::Feed { sequence: recording.name.clone(), source };
    let stamps: Vec<Stamp> = frames.iter().map(|f| f.t).collect();
    let data_s = match (stamps.first(), stamps.last()) {
        (Some(first), Some(last)) => last.seconds_since(*first),
        _ => 0.0,
    };
    let (camera, body_from_cam) = (recording.camera, recording.body_from_cam);
    let mut estimator =
        Estimator::new(config.clone(), camera, body_from_cam, seed).map_err(ClosedLoopError::Config)?;
    let samples = recording.imu.samples();
    // The last sample before the first frame is where its interval begins.
    let begin = frames.first().map_or(0, |f| samples.partition_point(|s| s.t <= f.t).saturating_sub(1));
    let mut next = begin;
    let mut driven = Driven {
        updates: Vec::with_capacity(frames.len()),
        report: RunReport::default(),
        cpu_s: 0.0,
        update_cpu_s: Vec::with_capacity(frames.len()),
        data_s,
        frames: stamps,
    };
    let clock = ThreadTime::now();
    for frame in frames {
        // The first sample at or after the frame completes it.
        while next < samples.len() && (next == begin || samples[next - 1].t < frame.t) {
            let (sample, noise) = (samples[next], noise.noises()[next]);
            estimator.feed_imu(NoisySample { sample, noise }).map_err(refused)?;
            next += 1;
        }
        estimator.feed_frame(frame.clone()).map_err(refused)?;
        take(&mut estimator, &mut driven);
    }
    driven.cpu_s = clock.elapsed().as_secs_f64();
    driven.report = estimator.report().clone();
    Ok(driven)
}

/// Takes every update there is.
fn take(estimator: &mut Estimator, driven: &mut Driven) {
    loop {
        let clock = ThreadTime::now();
        let Some(update) = estimator.next_update() else { break };
        driven.update_cpu_s.push(clock.elapsed().as_secs_f64());
        driven.updates.push(update);
    }
}
