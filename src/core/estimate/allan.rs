//! Allan deviation at the shortest averaging time, one sample.

use super::EstimatorError;
use super::quadratic::Linear;
use crate::signal::stats;

/// `allan`: `sqrt(mean((x[i+1] - x[i])^2) / 2)`, which for white noise is sigma.
///
/// Takes for noise what changes from sample to sample, like `diff1`; but the mean of the differences is not taken
/// out, as the Allan variance has it, so a steady slope counts as noise. Fooled by vibration.
///
/// `samples` is the length of the windows it will mostly be asked for.
///
/// # Errors
/// `samples` below 2.
pub(crate) fn allan(samples: usize) -> Result<Linear, EstimatorError> {
    Linear::new("allan".into(), 2, samples, |x| stats::differences(x, 1))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::estimate::WindowSigma;

    #[test]
    fn a_slope_counts_as_its_step_over_root_two() {
        let ramp: Vec<f64> = (0..2000).map(|i| 0.3 * f64::from(i)).collect();
        let sigma = allan(200).unwrap().sigma(&ramp);
        assert!((sigma - 0.3 / 2f64.sqrt()).abs() < 1e-4, "{sigma}");
    }
}
