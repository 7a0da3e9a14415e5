//! The run of a cell: the noise that the odometry is given, and the odometry over tracks.
//!
//! `mean(self)` and `shuffled(self)` are made of the noise in force in a first run of the same cell.

use super::drive::{EstimatorOutput, UpdateWatch, drive, drive_tracks};
use super::error::ClosedLoopError;
use super::recording::Recording;
use super::tracked::TrackedSequence;
use crate::noise::{AfterRun, Sources, track};
use dpn_core::NoiseTrack;
use dpn_core::estimate::NoiseSpec;
use dpn_core::random::Stream;
use dpn_live::settings_for;
use dpn_vio::estimator::{EstimatorConfig, FedTracks};
use std::sync::Arc;

/// The stream of the noise's chance.
pub(super) fn noise_stream(seed: u64) -> Stream {
    Stream::new(seed).named("noise")
}

/// Runs the odometry over tracks with `noise`, while `watch` looks on; what it left, and the noise in force.
///
/// # Errors
/// Noise that cannot be had; settings out of their bounds; a run that `watch` ended.
pub(super) fn run_on_tracks(
    config: &EstimatorConfig,
    recording: &Recording,
    seen: &TrackedSequence,
    noise: &NoiseSpec,
    sources: &dyn Sources,
    seed: u64,
    watch: &mut UpdateWatch<'_>,
) -> Result<(EstimatorOutput, Arc<NoiseTrack>), ClosedLoopError> {
    let stream = noise_stream(seed);
    let fed_tracks = if seen.images.is_some() { FedTracks::Followed } else { config.fed_tracks };
    let config = EstimatorConfig { fed_tracks, ..config.clone() };
    let given = match noise.learned_before() {
        None => track(noise, &recording.imu, sources, &stream)?,
        Some(learned) => {
            let given = track(learned, &recording.imu, sources, &stream)?;
            let first = drive(&settings_for(&config, learned), recording, seen.run(), &given, seed)?;
            let sources = AfterRun { sources, in_force: first.in_force(given) };
            track(noise, &recording.imu, &sources, &stream)?
        }
    };
    let output = drive_tracks(&settings_for(&config, noise), recording, seen.run(), &given, seed, watch)?;
    let in_force = output.in_force(given);
    Ok((output, in_force))
}
