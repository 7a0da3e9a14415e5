//! From a path, the camera's stamps, a configuration and a seed to tracks.

use super::camera::BadCameraSettings;
use super::config::TracksConfig;
use super::path::CameraPath;
use super::sight::Sight;
use super::tracker::Tracker;
use super::world::Points;
use dpn_core::config::{ConfigFaults, Validate};
use dpn_core::random::Stream;
use dpn_core::time::median_step_s;
use dpn_core::{Stamp, TrackFrame};
use thiserror::Error;

/// The period that a single frame is taken to have \[s\].
const ONE_FRAME_PERIOD_S: f64 = 0.05;

/// Why there are no tracks.
#[derive(Debug, PartialEq, Error)]
pub enum TracksError {
    /// Settings out of their bounds.
    #[error(transparent)]
    Config(#[from] ConfigFaults),
    /// A camera that is none.
    #[error(transparent)]
    Camera(#[from] BadCameraSettings),
    /// The camera took no image.
    #[error("the camera has no frame")]
    NoFrame,
    /// Stamps that stand still or go back.
    #[error("the camera's stamps go from {} to {} at frame {index}; they must increase", prev.ns(), t.ns())]
    TimeNotIncreasing {
        /// Index of the later frame.
        index: usize,
        /// Stamp of the frame before.
        prev: Stamp,
        /// Its own stamp.
        t: Stamp,
    },
    /// No frame while the path is known.
    #[error(
        "none of the {frames} camera frames, {} to {} ns, lies on the path, {} to {} ns: are both on one clock?",
        first.ns(), last.ns(), path_first.ns(), path_last.ns()
    )]
    Apart {
        /// How many frames there are.
        frames: usize,
        /// The first frame's stamp.
        first: Stamp,
        /// The last frame's stamp.
        last: Stamp,
        /// Where the path begins.
        path_first: Stamp,
        /// Where the path ends.
        path_last: Stamp,
    },
}

/// What a tracker with the habits and errors of `config` hands over of a flight along `path`, its camera taking images at `stamps`.
///
/// Pixels are in hundredths, as files of tracks hold them: writing and reading changes nothing. Every n-th of the camera's frames is
/// handed over; none where the path is not known. A frame with nothing in sight has no tracks, but is there. The same arguments give
/// the same bits.
///
/// # Errors
/// Settings out of their bounds; no stamp, or stamps that do not increase; none of them on the path.
pub fn simulate_tracks(
    config: &TracksConfig,
    path: &dyn CameraPath,
    stamps: &[Stamp],
    seed: u64,
) -> Result<Vec<TrackFrame>, TracksError> {
    config.validate()?;
    let (Some(&first), Some(&last)) = (stamps.first(), stamps.last()) else {
        return Err(TracksError::NoFrame);
    };
    if let Some(index) = (1..stamps.len()).find(|i| stamps[i - 1] >= stamps[*i]) {
        return Err(TracksError::TimeNotIncreasing { index, prev: stamps[index - 1], t: stamps[index] });
    }
    let stream = Stream::new(seed).named("tracks");
    let points = Points::around(&path.bounds(), config.world, &stream);
    let mut sight = Sight::new(&points, &config.camera_or_default())?;
    let period = median_step_s(stamps.iter().copied()).unwrap_or(ONE_FRAME_PERIOD_S);
    let mut tracker = Tracker::new(config, period, points.len(), &stream);
    let every = ((1.0 / (period * config.rate_hz)).round() as usize).max(1);

    let mut frames = Vec::with_capacity(stamps.len() / every + 1);
    let mut prev: Option<Stamp> = None;
    let mut on_path = 0_usize;
    for &t in stamps {
        let Some(pose) = path.world_from_body(t.plus_seconds(config.ground_truth_delay_s)) else {
            tracker.lose_all();
            continue;
        };
        if prev.replace(t).is_some_and(|prev| t.seconds_since(prev) > config.longest_blind_s) {
            tracker.lose_all();
        }
        sight.look(&pose);
        tracker.follow(&sight);
        if on_path.is_multiple_of(every) {
            tracker.replenish(t, &sight);
            frames.push(tracker.hand_over(t));
        }
        on_path += 1;
    }
    if frames.is_empty() {
        let pieces = path.pieces();
        let path_first = pieces.first().map_or(Stamp::from_ns(0), |piece| piece.0);
        let path_last = pieces.last().map_or(path_first, |piece| piece.1);
        return Err(TracksError::Apart { frames: stamps.len(), first, last, path_first, path_last });
    }
    Ok(frames)
}
