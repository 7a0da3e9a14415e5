//! Why a live odometry is not made, or does not take what it is fed.

use dpn_core::Stamp;
use dpn_core::camera::BadCamera;
use dpn_core::config::ConfigFault;
use dpn_io::IoError;
use dpn_io::calibration::CalibrationError;
use dpn_io::config::ConfigError;
use dpn_noise::NoiseError;
use dpn_vio::estimator::FeedError;
use thiserror::Error;

/// Why a live odometry is not made, or does not take what it is fed. After the latter it goes on as if nothing had been fed.
#[derive(Debug, Error)]
pub enum LiveError {
    /// A text that is no settings.
    #[error(transparent)]
    Settings(#[from] ConfigError),
    /// Settings of the estimator out of their bounds.
    #[error("the estimator's settings: {}", .0.iter().map(ToString::to_string).collect::<Vec<_>>().join("; "))]
    Config(Vec<ConfigFault>),
    /// A calibration that cannot be used.
    #[error(transparent)]
    Calibration(#[from] CalibrationError),
    /// A calibration of no camera.
    #[error("the calibration's camera: {0}")]
    Camera(#[from] BadCamera),
    /// Noise that cannot be told while samples come.
    #[error(transparent)]
    Noise(#[from] NoiseError),
    /// Input that the estimator does not take.
    #[error(transparent)]
    Feed(#[from] FeedError),
    /// Bytes that are no image.
    #[error(transparent)]
    Image(#[from] IoError),
    /// Images, where tracks were announced, or the other way round.
    #[error("{found} are fed to an odometry that is made for {made}; its settings say `camera = \"{made}\"`")]
    Other {
        /// What was fed.
        found: &'static str,
        /// What it is made for.
        made: &'static str,
    },
    /// Nobody takes what was worked off.
    #[error("an image at {t} while {waiting} wait whose samples are there; take the updates between images")]
    NotTaken {
        /// Its stamp.
        t: Stamp,
        /// How many wait.
        waiting: usize,
    },
    /// An id that a frame has twice.
    #[error("id {id} twice in the frame at {t}; expected each point at most once")]
    IdTwice {
        /// The frame.
        t: Stamp,
        /// The id.
        id: u64,
    },
    /// A point that is nowhere.
    #[error(
        "the point {id} of the frame at {t} is at {at:?}; expected {}",
        if *normalised { "normalised coordinates that the lens can show" } else { "two finite numbers, in pixels" }
    )]
    Point {
        /// The frame.
        t: Stamp,
        /// Its id.
        id: u64,
        /// Where it was said to be.
        at: [f64; 2],
        /// Whether by normalised coordinates.
        normalised: bool,
    },
}

impl LiveError {
    /// What to do about it, where the message does not say it.
    pub fn hint(&self) -> Option<String> {
        match self {
            Self::Settings(error) => error.hint(),
            Self::Calibration(error) => error.hint(),
            Self::Noise(error) => error.hint(),
            _ => None,
        }
    }
}
