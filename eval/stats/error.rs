//! Why a statistic cannot be computed.

use thiserror::Error;

/// Why a statistic cannot be computed.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum StatsError {
    /// NaN or infinity.
    #[error(
        "value {index} is {value}; leave failed runs out, or rank them last by a finite value, before testing"
    )]
    NotFinite {
        /// Its index.
        index: usize,
        /// The value.
        value: f64,
    },
    /// Too few values.
    #[error("{found} values; {what} needs {needed}")]
    TooFew {
        /// What was asked for.
        what: &'static str,
        /// How many it needs.
        needed: usize,
        /// How many there are.
        found: usize,
    },
    /// Paired samples of different lengths.
    #[error("{first} and {second} values; pairs need as many on either side")]
    Unpaired {
        /// Length of the first.
        first: usize,
        /// Length of the second.
        second: usize,
    },
    /// An argument out of its range.
    #[error("`{name}` is {value}; it must be {bound}")]
    BadArgument {
        /// The argument.
        name: &'static str,
        /// Its value.
        value: f64,
        /// What it may be.
        bound: &'static str,
    },
}

/// Refuses values that are not finite.
pub(super) fn finite(values: &[f64]) -> Result<(), StatsError> {
    match values.iter().enumerate().find(|(_, v)| !v.is_finite()) {
        Some((index, &value)) => Err(StatsError::NotFinite { index, value }),
        None => Ok(()),
    }
}

/// Refuses a probability that is not strictly between 0 and 1.
pub(super) fn probability(name: &'static str, value: f64) -> Result<(), StatsError> {
    if value > 0.0 && value < 1.0 {
        return Ok(());
    }
    let bound = "above 0 and below 1";
    Err(StatsError::BadArgument { name, value, bound })
}
