//! Whether a network is as far off as it says.

use serde::{Deserialize, Serialize};

/// Errors of logarithms, and the same in units of what the network said of them.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Calibration {
    /// Root mean square error of the natural logarithm: .1 is 10 %.
    pub log_rmse: f64,
    /// Share of the answers that are off by less than the spread they came with; .68 of a calibrated normal law.
    pub within_one: f64,
    /// Root mean square of the errors over their spreads; 1 of a calibrated law.
    pub rms_z: f64,
}

impl Calibration {
    /// Of answers `sigma` with the spreads of their logarithms, held against `truth`.
    ///
    /// # Shapes
    /// All `[count]`; NaN for none.
    pub fn of(sigma: &[f64], spread: &[f64], truth: &[f64]) -> Self {
        let count = truth.len() as f64;
        let errors: Vec<f64> = sigma.iter().zip(truth).map(|(s, t)| (s / t).ln()).collect();
        let z: Vec<f64> = errors.iter().zip(spread).map(|(e, s)| e / s).collect();
        let rms = |x: &[f64]| (x.iter().map(|v| v * v).sum::<f64>() / count).sqrt();
        let within_one = z.iter().filter(|z| z.abs() < 1.0).count() as f64 / count;
        Self { log_rmse: rms(&errors), within_one, rms_z: rms(&z) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn errors_are_counted_in_their_own_spreads() {
        let up = |e: f64| 2.0 * e.exp();
        let found = Calibration::of(&[up(0.1), up(-0.3), up(0.0), up(0.4)], &[0.2, 0.1, 0.1, 0.4], &[2.0; 4]);
        // z = .5, -3, 0, 1: the last stands on the border, and rounding decides.
        assert!((found.rms_z - (10.25f64 / 4.0).sqrt()).abs() < 1e-9);
        assert!((found.log_rmse - (0.26f64 / 4.0).sqrt()).abs() < 1e-9);
        assert!((0.5..=0.75).contains(&found.within_one));
    }
}
