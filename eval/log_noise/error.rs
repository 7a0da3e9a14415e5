//! Why a spec says nothing along a log.

use crate::noise::NoiseError;
use dpn_core::estimate::SpecError;
use dpn_core::noise::units::BadNoise;
use dpn_pronet::model::PairError;
use thiserror::Error;

/// Why there is no noise along a log.
#[derive(Debug, Error)]
pub enum LogNoiseError {
    /// The spec itself, or its networks.
    #[error(transparent)]
    Noise(#[from] NoiseError),
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
    /// A value that is no noise.
    #[error(transparent)]
    Value(#[from] BadNoise),
}

impl From<SpecError> for LogNoiseError {
    fn from(error: SpecError) -> Self {
        Self::Noise(error.into())
    }
}

impl From<PairError> for LogNoiseError {
    fn from(error: PairError) -> Self {
        Self::Noise(error.into())
    }
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
            Self::Noise(_) | Self::Value(_) => None,
        }
    }
}
