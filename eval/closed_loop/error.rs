//! Why the loop was not closed.

use super::sequence_name::meant;
use super::source_error::SourceError;
use crate::metrics::MetricsError;
use crate::noise::NoiseError;
use crate::stats::StatsError;
use dpn_core::camera::BadCamera;
use dpn_core::config::ConfigFault;
use dpn_io::calibration::CalibrationError;
use dpn_io::config::ConfigError;
use dpn_io::{Coverage, IoError, LockError};
use dpn_logs::LogError;
use dpn_sim::SimulationError;
use dpn_sim::render::RenderError;
use dpn_sim::tracks::{BadCameraSettings, PathError, TracksError};
use dpn_vio::estimator::FeedError;
use std::path::PathBuf;
use thiserror::Error;

/// Why a closed loop cannot be run.
#[derive(Debug, Error)]
pub enum ClosedLoopError {
    /// Settings of the estimator out of their bounds.
    #[error("the estimator's settings: {}", .0.iter().map(ToString::to_string).collect::<Vec<_>>().join("; "))]
    Config(Vec<ConfigFault>),
    /// A file that cannot be read or written.
    #[error(transparent)]
    Io(#[from] IoError),
    /// A log that cannot be used.
    #[error(transparent)]
    Log(#[from] LogError),
    /// A file of settings.
    #[error(transparent)]
    Settings(#[from] ConfigError),
    /// A run that cannot be what was asked for.
    #[error(transparent)]
    Source(#[from] SourceError),
    /// A log with images, and nobody knows what camera took them.
    #[error("{}: no calibration of its camera: looked for sensor.yaml, cam0/sensor.yaml, mav0/cam0/sensor.yaml in its folder", path.display())]
    NoCalibration {
        /// The log.
        path: PathBuf,
    },
    /// A calibration that does not read.
    #[error(transparent)]
    Calibration(#[from] CalibrationError),
    /// The results' folder is another process's.
    #[error(transparent)]
    Locked(#[from] LockError),
    /// A noise spec that gives no noise here.
    #[error(transparent)]
    Noise(#[from] NoiseError),
    /// A simulated flight that cannot be.
    #[error(transparent)]
    Flight(#[from] SimulationError),
    /// Ground truth that tracks cannot be made along.
    #[error("{sequence}: no camera tracks can be made along its ground truth")]
    Path {
        /// The sequence.
        sequence: String,
        /// Why.
        source: PathError,
    },
    /// Tracks that cannot be made.
    #[error("{sequence}: no camera tracks can be made")]
    Tracks {
        /// The sequence.
        sequence: String,
        /// Why.
        source: TracksError,
    },
    /// Images that cannot be rendered.
    #[error("{sequence}: nothing can be rendered: {source}")]
    Render {
        /// The sequence.
        sequence: String,
        /// Why.
        source: RenderError,
    },
    /// A camera configuration that describes no camera.
    #[error("{sequence}: its camera cannot be used")]
    Camera {
        /// The sequence.
        sequence: String,
        /// Why.
        source: BadCamera,
    },
    /// Settings of a camera that is none.
    #[error("{sequence}: its camera cannot be used")]
    CameraSettings {
        /// The sequence.
        sequence: String,
        /// Why.
        source: BadCameraSettings,
    },
    /// Given tracks, and nobody knows what camera took them.
    #[error("{}: no cam0/sensor.yaml, so nobody knows what camera the tracks are from; put the camera's calibration there", dir.display())]
    NoCamera {
        /// Folder of the sequence.
        dir: PathBuf,
    },
    /// Tracks are to be made, and there is no ground truth to make them along.
    #[error("{}: no ground truth, along which camera tracks could be made; give tracks with --tracks", dir.display())]
    NoGroundTruth {
        /// Folder of the sequence.
        dir: PathBuf,
    },
    /// Images are to be looked at, and there are none.
    #[error("{sequence}: it has no images{}", if *asked { " in the part that is to be run" } else { "" })]
    NoImages {
        /// The sequence.
        sequence: String,
        /// Whether there are some elsewhere in it.
        asked: bool,
    },
    /// Images are listed that are not there.
    #[error("{sequence}: {coverage}")]
    ImagesMissing {
        /// The sequence.
        sequence: String,
        /// What there is, over all images listed.
        coverage: Box<Coverage>,
    },
    /// Images were looked at, and none showed anything.
    #[error("{sequence}: no track in its {images} images; {why}")]
    NothingTracked {
        /// The sequence.
        sequence: String,
        /// How many there were.
        images: usize,
        /// What was wrong with most of them.
        why: String,
    },
    /// Tracks where there are none: a flight has no file of them, and images are yet to be followed through.
    #[error(
        "{sequence}: it has no file of tracks; a flight's are made with it, and images are followed by the odometry"
    )]
    NoTracks {
        /// The sequence.
        sequence: String,
    },
    /// A name no sequence has.
    #[error("no sequence is called `{name}`; there are {}{}", known.join(", "), meant(name, known))]
    UnknownSequence {
        /// What was asked for.
        name: String,
        /// What there is.
        known: Vec<String>,
    },
    /// A name that begins several sequences' names.
    #[error("`{name}` may be any of {}; write more of it", found.join(", "))]
    AmbiguousSequence {
        /// What was asked for.
        name: String,
        /// What it may mean.
        found: Vec<String>,
    },
    /// Tracks and samples that have (almost) nothing in common.
    #[error(
        "{sequence}: its {frames} frames go from {first_ns} to {last_ns} ns, its IMU from {imu_first_ns} to {imu_last_ns} ns: fewer than {needed} frames have samples; are both on one clock, and the tracks this sequence's?"
    )]
    Apart {
        /// The sequence.
        sequence: String,
        /// How many frames there are.
        frames: usize,
        /// The first frame.
        first_ns: i64,
        /// The last one.
        last_ns: i64,
        /// The first sample.
        imu_first_ns: i64,
        /// The last one.
        imu_last_ns: i64,
        /// How many frames with samples a run needs.
        needed: usize,
    },
    /// Nothing is left between the start and the end that were asked for.
    #[error(
        "{sequence}: its frames last {seconds:.1} s; what is run, from {from_s} s{}, has fewer than {needed}",
        to_s.map_or_else(String::new, |to| format!(" to {to} s"))
    )]
    NothingLeft {
        /// The sequence.
        sequence: String,
        /// From the first to the last frame \[s\].
        seconds: f64,
        /// The start asked for \[s\].
        from_s: f64,
        /// The end asked for \[s\].
        to_s: Option<f64>,
        /// How many frames a run needs.
        needed: usize,
    },
    /// Ids that do not stay with their points.
    #[error("{sequence}: {problem}")]
    TrackIds {
        /// The sequence.
        sequence: String,
        /// What is wrong, with the measured share.
        problem: String,
    },
    /// Input the estimator does not take.
    #[error("{sequence}: {source}")]
    Feed {
        /// The sequence.
        sequence: String,
        /// Why.
        source: FeedError,
    },
    /// Ground truth or estimate that cannot be judged.
    #[error("{sequence}: {source}")]
    Metrics {
        /// The sequence.
        sequence: String,
        /// Why.
        source: MetricsError,
    },
    /// Errors that cannot be compared.
    #[error("the noises cannot be compared: {0}")]
    Compare(#[from] StatsError),
    /// One name, several folders.
    #[error("there are two sequences called `{name}`: {} and {}; give --data one of them", first.display(), second.display())]
    SameName {
        /// The name.
        name: String,
        /// One folder.
        first: PathBuf,
        /// Another one.
        second: PathBuf,
    },
    /// The run's folder holds results of something else.
    #[error("{} holds a run with another {key}: {there} there, {here} now", dir.display())]
    OtherRun {
        /// The folder.
        dir: PathBuf,
        /// What differs.
        key: String,
        /// In the folder.
        there: String,
        /// Asked for.
        here: String,
    },
    /// A line of the results that is none.
    #[error("{}:{line}: not a row of results: {message}", path.display())]
    BadRow {
        /// The file.
        path: PathBuf,
        /// Line, from 1.
        line: usize,
        /// What is wrong.
        message: String,
    },
    /// Who looked on wanted no more.
    #[error("{sequence}: the run was stopped")]
    RunStopped {
        /// The sequence.
        sequence: String,
    },
    /// Stopped from outside; what is finished is kept.
    #[error("stopped after {done} of {total} cells")]
    Stopped {
        /// Cells whose results are on disk.
        done: usize,
        /// Cells in all.
        total: usize,
    },
}

impl ClosedLoopError {
    /// What is wrong and what it comes from, in one line.
    pub fn in_full(&self) -> String {
        dpn_io::in_full(self)
    }

    /// What to do about it, where the message does not say it.
    pub fn hint(&self) -> Option<String> {
        match self {
            Self::Io(error) => error.hint(),
            Self::Log(error) => error.hint(),
            Self::Settings(error) => error.hint(),
            Self::Source(error) => Some(error.hint().into()),
            Self::Calibration(error) => error.hint(),
            Self::NoCalibration { .. } => {
                Some("name it with --calib, or put a cam0/sensor.yaml as EuRoC's beside the log".into())
            }
            Self::Locked(error) => error.hint(),
            Self::Noise(error) => error.hint(),
            Self::OtherRun { .. } => Some("give another folder with --out, or remove this one".into()),
            Self::BadRow { .. } => Some("remove the line; its cell is run again".into()),
            Self::NoImages { asked: true, .. } => {
                Some("look at --from and --to: seconds after the first image".into())
            }
            Self::NothingLeft { .. } => {
                Some("record for longer, or name a longer part with --from and --to".into())
            }
            Self::NoImages { .. } => Some(
                "leave --camera away, and tracks are made along the ground truth; or unpack the images"
                    .into(),
            ),
            Self::ImagesMissing { coverage, .. } => Some(match coverage.longest_s() {
                Some([from, to]) => format!(
                    "run what is there with --from {from} --to {to}, pass over what is not with --skip-missing, or unpack the rest"
                ),
                None => "unpack the images into cam0/data, or leave --camera away".into(),
            }),
            Self::Stopped { .. } => Some("the same command goes on where it stopped".into()),
            _ => None,
        }
    }
}
