//! Why a spec says nothing along a log.

use dpn_core::estimate::SpecError;
use dpn_core::noise::units::BadNoise;
use dpn_pronet::model::PairError;
use dpn_pronet::network::UnknownNetwork;
use thiserror::Error;

/// Why there is no noise along a log.
#[derive(Debug, Error)]
pub enum LogNoiseError {
    /// Parameters of the spec.
    #[error(transparent)]
    Spec(#[from] SpecError),
    /// A network nobody has.
    #[error("`{spec}`: {source}")]
    NoNetwork {
        /// The spec.
        spec: String,
        /// What was asked for, and what there is.
        source: UnknownNetwork,
    },
    /// Two networks that are no pair.
    #[error(transparent)]
    Pair(#[from] PairError),
    /// A spec that needs more than the samples so far.
    #[error("`{spec}` is not causal: it needs more than the samples so far")]
    NotCausal {
        /// The spec.
        spec: String,
    },
    /// Networks of another rate than any thinning of the log gives.
    #[error(
        "the log has {found_hz:.1} Hz; the networks of `{spec}` were trained at {trained_hz:.1} Hz and count samples, not time"
    )]
    Rate {
        /// The spec.
        spec: String,
        /// The log's rate \[Hz\].
        found_hz: f64,
        /// The networks' \[Hz\].
        trained_hz: f64,
    },
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
            Self::NotCausal { .. } => {
                Some("give networks (dualpronet), a simple estimator (diff2, sg(11,2)) or constants".into())
            }
            Self::Rate { trained_hz, .. } => Some(format!(
                "whole multiples of {trained_hz:.0} Hz are thinned by themselves; else give a simple estimator: --noise diff2"
            )),
            Self::TooFast { .. } => Some(
                "the stamps count in another unit, it seems: name it by --time-unit s, ms, us or ns".into(),
            ),
            Self::TooShort { .. } => Some("record for longer, or ask constants (--noise x1)".into()),
            Self::Spec(_) | Self::NoNetwork { .. } | Self::Pair(_) | Self::Value(_) | Self::Store(_) => None,
        }
    }
}
