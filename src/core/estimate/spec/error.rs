//! What can be wrong with a noise spec.

use crate::config::suggestion;
use crate::estimate::EstimatorError;
use crate::noise::units::BadNoise;
use thiserror::Error;

/// Why a string names no noise model.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum SpecError {
    /// The grammar is broken.
    #[error("noise spec `{spec}`: expected {expected} at character {}; write for example `x2`, `sg(11,2)` or `x4,x1`", at + 1)]
    Syntax {
        /// The whole spec.
        spec: String,
        /// Characters before the offending one.
        at: usize,
        /// What should stand there.
        expected: &'static str,
    },
    /// A list without a spec.
    #[error("no noise spec among `{text}`; write for example x1,x4,self")]
    NoSpec {
        /// What was given.
        text: String,
    },
    /// A file's name alone.
    #[error("`{path}` is no noise spec; a noise track on disk is named file(\"{path}\")")]
    BarePath {
        /// The path.
        path: String,
    },
    /// A name nobody knows.
    #[error("`{name}` is no noise spec; known are {}{}", known.join(", "), suggestion(nearest.as_deref()))]
    Unknown {
        /// The name.
        name: String,
        /// The known name nearest to it, if one is near.
        nearest: Option<String>,
        /// Every known call.
        known: Vec<String>,
    },
    /// A known name with arguments that do not fit.
    #[error("`{call}`: {problem}; write `{usage}`")]
    Arguments {
        /// The call as read.
        call: String,
        /// What does not fit.
        problem: String,
        /// How it is written.
        usage: &'static str,
    },
    /// More than two calls.
    #[error(
        "noise spec `{spec}` has {calls} parts; give one for both sensors, or two: accelerometer, gyroscope"
    )]
    TooManyParts {
        /// The whole spec.
        spec: String,
        /// How many calls it has.
        calls: usize,
    },
    /// A call that stands for both sensors inside a pair.
    #[error("`{call}` says both sensors' noise and cannot be one half of a pair; give it alone")]
    NotOneSensor {
        /// The call.
        call: String,
    },
    /// A figure that is no deviation.
    #[error(transparent)]
    Noise(#[from] BadNoise),
    /// The estimator refuses its parameters.
    #[error(transparent)]
    Estimator(#[from] EstimatorError),
}
