//! The two ways an estimator is asked: for a whole window, or after every sample.

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

/// Deviation of the white noise per sample, updated with every sample of one axis.
pub trait StreamSigma: Send {
    /// The spec that names it, for example `"ewma(0.01)"`.
    fn name(&self) -> &str;

    /// Samples below which there is no answer.
    fn min_len(&self) -> usize;

    /// Takes the next sample.
    fn push(&mut self, value: f64);

    /// The deviation by now, in the unit of the samples; NaN before [`min_len`](Self::min_len) samples.
    fn sigma(&self) -> f64;

    /// Forgets everything pushed so far.
    fn reset(&mut self);
}

/// A streaming estimator asked for a window: its value after that window, from fresh.
#[derive(Debug, Clone)]
pub struct FromFresh<S>(S);

impl<S: StreamSigma + Clone> FromFresh<S> {
    /// Wraps `stream`; what it has seen so far is forgotten.
    pub fn new(mut stream: S) -> Self {
        stream.reset();
        Self(stream)
    }
}

impl<S: StreamSigma + Clone + Sync> WindowSigma for FromFresh<S> {
    fn name(&self) -> &str {
        self.0.name()
    }

    fn min_len(&self) -> usize {
        self.0.min_len()
    }

    fn sigma(&self, window: &[f64]) -> f64 {
        let mut stream = self.0.clone();
        window.iter().for_each(|v| stream.push(*v));
        stream.sigma()
    }
}
