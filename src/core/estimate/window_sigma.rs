//! How an estimator is asked, and why it cannot be made.

use crate::signal::FilterError;
use thiserror::Error;

/// Why an estimator cannot be made.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum EstimatorError {
    /// The filter it rests on refuses its parameters.
    #[error(transparent)]
    Filter(#[from] FilterError),
    /// A parameter out of its range.
    #[error("{estimator}: {parameter} is {value}, it must be {range}")]
    Parameter {
        /// Which estimator.
        estimator: &'static str,
        /// Which parameter.
        parameter: &'static str,
        /// Its value.
        value: f64,
        /// What it may be.
        range: &'static str,
    },
    /// A window that does not hold enough samples.
    #[error("`{name}` needs windows of at least {needs} samples, not {window}")]
    WindowTooShort {
        /// The estimator's spec.
        name: String,
        /// Samples it needs.
        needs: usize,
        /// Samples it is to get.
        window: usize,
    },
    /// A schedule that never asks.
    #[error("a schedule of window {window} and hop {hop} never asks; both must be at least 1")]
    EmptySchedule {
        /// Samples in a window.
        window: usize,
        /// Samples between two questions.
        hop: usize,
    },
}

/// Deviation of the white noise per sample from one window of one axis.
pub trait WindowSigma: Send + Sync {
    /// The spec that names it, for example `"sg(11,2)"`.
    fn name(&self) -> &str;

    /// Samples below which there is no answer.
    fn min_len(&self) -> usize;

    /// The deviation, in the unit of the samples; NaN for a window below [`min_len`](Self::min_len).
    ///
    /// Zero for a window without noise, but for rounding.
    fn sigma(&self, window: &[f64]) -> f64;
}
