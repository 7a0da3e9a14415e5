//! Why a sequence cannot be run.

use crate::metrics::MetricsError;
use dpn_core::camera::BadCamera;
use dpn_io::Coverage;
use dpn_sim::render::RenderError;
use dpn_sim::tracks::{BadCameraSettings, PathError, TracksError};
use dpn_vio::estimator::FeedError;
use thiserror::Error;

/// Why a sequence cannot be run, without its name.
#[derive(Debug, Error)]
pub enum SequenceFault {
    /// Ground truth that tracks cannot be made along.
    #[error("no camera tracks can be made along its ground truth")]
    Path(#[from] PathError),
    /// Tracks that cannot be made.
    #[error("no camera tracks can be made")]
    Tracks(#[from] TracksError),
    /// Images that cannot be rendered.
    #[error("nothing can be rendered: {0}")]
    Render(#[from] RenderError),
    /// A camera configuration that describes no camera.
    #[error("its camera cannot be used")]
    Camera(#[from] BadCamera),
    /// Settings of a camera that is none.
    #[error("its camera cannot be used")]
    CameraSettings(#[from] BadCameraSettings),
    /// Images are to be looked at, and there are none.
    #[error("it has no images{}", if *asked { " in the part that is to be run" } else { "" })]
    NoImages {
        /// Whether there are some elsewhere in it.
        asked: bool,
    },
    /// Images are listed that are not there.
    #[error("{0}")]
    ImagesMissing(Box<Coverage>),
    /// Images were looked at, and none showed anything.
    #[error("no track in its {images} images; {why}")]
    NothingTracked {
        /// How many there were.
        images: usize,
        /// What was wrong with most of them.
        why: String,
    },
    /// Tracks where there are none: a flight has no file of them, and images are yet to be followed through.
    #[error("it has no file of tracks; a flight's are made with it, and images are followed by the odometry")]
    NoTracks,
    /// Tracks and samples that have (almost) nothing in common.
    #[error(
        "its {frames} frames go from {first_ns} to {last_ns} ns, its IMU from {imu_first_ns} to {imu_last_ns} ns: fewer than {needed} frames have samples; are both on one clock, and the tracks this sequence's?"
    )]
    Apart {
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
        "its frames last {seconds:.1} s; what is run, from {from_s} s{}, has fewer than {needed}",
        to_s.map_or_else(String::new, |to| format!(" to {to} s"))
    )]
    NothingLeft {
        /// From the first to the last frame \[s\].
        seconds: f64,
        /// The start asked for \[s\].
        from_s: f64,
        /// The end asked for \[s\].
        to_s: Option<f64>,
        /// How many frames a run needs.
        needed: usize,
    },
    /// Ids that do not stay with their points, with the measured share.
    #[error("{0}")]
    TrackIds(String),
    /// Input the estimator does not take.
    #[error(transparent)]
    Feed(#[from] FeedError),
    /// Ground truth or estimate that cannot be judged.
    #[error(transparent)]
    Metrics(#[from] MetricsError),
    /// Who looked on wanted no more.
    #[error("the run was stopped")]
    RunStopped,
}

impl SequenceFault {
    /// What to do about it, where the message does not say it.
    pub fn hint(&self) -> Option<String> {
        match self {
            Self::NoImages { asked: true } => {
                Some("look at --from and --to: seconds after the first image".into())
            }
            Self::NoImages { .. } => Some(
                "leave --camera away, and tracks are made along the ground truth; or unpack the images"
                    .into(),
            ),
            Self::NothingLeft { .. } => {
                Some("record for longer, or name a longer part with --from and --to".into())
            }
            Self::ImagesMissing(coverage) => Some(match coverage.longest_s() {
                Some([from, to]) => format!(
                    "run what is there with --from {from} --to {to}, pass over what is not with --skip-missing, or unpack the rest"
                ),
                None => "unpack the images into cam0/data, or leave --camera away".into(),
            }),
            _ => None,
        }
    }
}
