//! Mean square of whitened residuals per degree of freedom: 1 where the assumed noise is the real one.
//!
//! A residual r of n rows with covariance P, whitened to L^-1 r with L L^T = P, has squared length chi-square of n degrees of freedom. Summed over
//! residuals that are taken at the true states, or are independent predictions (innovations), the degrees of freedom are the rows. Taken at
//! states estimated from the same residuals they are fewer, by the number of values that these residuals alone determine; the caller gives
//! what holds. Above 1 the assumed noise is too small, below too large; the root is the factor on its deviation.

use super::error::MetricsError;
use crate::stats::chi_square_interval;
use serde::{Deserialize, Serialize};

/// Accumulates squared whitened residuals. A value that is not finite makes every figure NaN from there on: it is not dropped silently.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct WhitenedResidual {
    /// Sum of squares of all rows.
    pub sum_squares: f64,
    /// Degrees of freedom.
    pub dof: u64,
}

impl WhitenedResidual {
    /// Nothing yet.
    pub fn new() -> Self {
        Self::default()
    }

    /// Adds one residual's rows, each a degree of freedom.
    pub fn push(&mut self, rows: &[f64]) {
        self.push_square(rows.iter().map(|r| r * r).sum(), rows.len() as u64);
    }

    /// Adds a squared length with its degrees of freedom.
    pub fn push_square(&mut self, square: f64, dof: u64) {
        self.sum_squares += square;
        self.dof += dof;
    }

    /// Adds another's sums; in a fixed order, so that the bits are the same on any number of threads.
    pub fn merge(&mut self, other: &Self) {
        self.push_square(other.sum_squares, other.dof);
    }

    /// Mean square per degree of freedom; `None` without any.
    pub fn mean_square(&self) -> Option<f64> {
        (self.dof > 0).then(|| self.sum_squares / self.dof as f64)
    }

    /// Between what the mean square lies with probability `confidence` where the noise is as assumed and residuals are independent.
    ///
    /// # Errors
    /// No degree of freedom; a confidence outside (0, 1).
    pub fn bounds(&self, confidence: f64) -> Result<[f64; 2], MetricsError> {
        let dof = self.dof as f64;
        Ok(chi_square_interval(dof, confidence)?.map(|bound| bound / dof))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use dpn_core::random::Stream;
    use rand::Rng;
    use rand_distr::StandardNormal;

    #[test]
    fn the_right_noise_gives_one_and_a_wrong_one_its_square() {
        let mut rng = Stream::new(3).named("test").named("whitened").rng();
        let mut parts = [WhitenedResidual::new(); 2];
        for i in 0..2000 {
            let rows: [f64; 9] = std::array::from_fn(|_| rng.sample(StandardNormal));
            parts[i % 2].push(&rows);
        }
        let mut all = WhitenedResidual::new();
        parts.iter().for_each(|part| all.merge(part));
        assert_eq!(all.dof, 18_000);
        let [low, high] = all.bounds(0.999).unwrap();
        // 3.29 deviations of sqrt(2 / 18000) each way.
        assert!((high - low - 2.0 * 3.29 * (2.0_f64 / 18_000.0).sqrt()).abs() < 1e-3);
        let got = all.mean_square().unwrap();
        assert!(low < got && got < high, "{low} {got} {high}");
        assert!(!(low..high).contains(&(got / (1.1 * 1.1))));
    }

    #[test]
    fn nothing_is_none_and_nan_stays() {
        assert_eq!(WhitenedResidual::new().mean_square(), None);
        assert!(WhitenedResidual::new().bounds(0.95).is_err());
        let mut sum = WhitenedResidual::new();
        sum.push(&[f64::NAN]);
        sum.push(&[1.0]);
        assert!(sum.mean_square().unwrap().is_nan());
    }
}
