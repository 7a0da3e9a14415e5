//! Why a spec says nothing along a log.

use dpn_core::noise::units::BadNoise;
use dpn_noise::CausalError;
use thiserror::Error;

/// Why there is no noise along a log.
#[derive(Debug, Error)]
pub enum LogNoiseError {
    /// A spec that says nothing of this log's samples.
    #[error(transparent)]
    Noise(#[from] CausalError),
    /// Stamps in another unit than was thought.
    #[error("the rate is {found_hz:.0} Hz; no IMU is faster than 100000 Hz")]
    TooFast {
        /// The log's rate \[Hz\].
        found_hz: f64,
    },
    /// A log that ends before there is an answer.
    #[error("{found_s:.2} s; the first window alone has {needed_s:.2} s")]
    TooShort {
        /// The log's length \[s\].
        found_s: f64,
        /// The first window's \[s\].
        needed_s: f64,
    },
    /// A value that is no noise.
    #[error(transparent)]
    Value(#[from] BadNoise),
    /// Samples or answers that cannot be kept or read again.
    #[error(transparent)]
    Store(#[from] std::io::Error),
}

impl LogNoiseError {
    /// What to do about it.
    pub fn hint(&self) -> Option<String> {
        match self {
            Self::Noise(error) => error.hint(),
            Self::TooFast { .. } => Some(
                "the stamps count in another unit, it seems: name it by --time-unit s, ms, us or ns".into(),
            ),
            Self::TooShort { .. } => Some("record for longer, or ask constants (--noise x1)".into()),
            Self::Value(_) | Self::Store(_) => None,
        }
    }
}
