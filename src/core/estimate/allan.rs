//! Allan deviation at the shortest averaging time, one sample.

use super::quadratic::Gain;
use super::{EstimatorError, WindowSigma};
use crate::signal::stats;

/// `allan`: `sqrt(mean((x[i+1] - x[i])^2) / 2)`, which for white noise is sigma.
///
/// Takes for noise what changes from sample to sample, like `diff1`; but the mean of the differences is not taken
/// out, as the Allan variance has it, so a steady slope counts as noise. Fooled by vibration.
#[derive(Debug, Clone)]
pub(crate) struct Allan {
    gain: Gain,
}

impl Allan {
    /// `samples` is the length of the windows it will mostly be asked for.
    ///
    /// # Errors
    /// `samples` below 2.
    pub(crate) fn new(samples: usize) -> Result<Self, EstimatorError> {
        if samples < 2 {
            return Err(EstimatorError::WindowTooShort { name: "allan".into(), needs: 2, window: samples });
        }
        Ok(Self { gain: Gain::of(samples, |x| stats::differences(x, 1)) })
    }
}

impl WindowSigma for Allan {
    fn name(&self) -> &str {
        "allan"
    }

    fn min_len(&self) -> usize {
        2
    }

    fn sigma(&self, window: &[f64]) -> f64 {
        if window.len() < 2 {
            return f64::NAN;
        }
        let map = |x: &[f64]| stats::differences(x, 1);
        self.gain.at(window.len(), map).sigma(&map(window))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_slope_counts_as_its_step_over_root_two() {
        let ramp: Vec<f64> = (0..2000).map(|i| 0.3 * f64::from(i)).collect();
        let sigma = Allan::new(200).unwrap().sigma(&ramp);
        assert!((sigma - 0.3 / 2f64.sqrt()).abs() < 1e-4, "{sigma}");
    }
}
