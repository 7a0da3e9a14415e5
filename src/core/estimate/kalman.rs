//! Deviation from the innovations of a local-level Kalman filter.
//!
//! Model: `level_k = level_{k-1} + w`, `x_k = level_k + v`, `var v = R`, `var w = q R` with the ratio `q` given. In
//! units of R the filter's prediction variance `p` and gain `g = p / (1 + p)` do not depend on the data, and the
//! likelihood's maximum over R is the mean of `e_k^2 / (1 + p_k)` over the innovations `e_k` (Harvey 1989, sec.
//! 4.2: the concentrated likelihood; started at the first sample). The expectation of that sum for white noise alone
//! (`w = 0`) runs beside it and is divided out, as for every estimator here.

use super::quadratic::c4;
use super::{EstimatorError, StreamSigma};

/// `kalman(q)`: deviation of the innovations of a filter that tracks a level which wanders by `sqrt(q)` sigma a sample.
///
/// Takes for noise what that level does not follow: with q = .1 and 200 Hz, changes faster than about 10 Hz. Fooled
/// by vibration, and by motion faster than the level may wander. It averages since the start.
#[derive(Debug, Clone)]
pub struct Kalman {
    name: String,
    ratio: f64,
    count: usize,
    level: f64,
    /// Prediction variance of the next sample's level, in units of R.
    predicted: f64,
    sum: f64,
    /// Under white noise of sigma 1: variance of the level, expectation and half the variance of the sum.
    level_spread: f64,
    expected: f64,
    half_spread: f64,
}

impl Kalman {
    /// With the ratio `q` of the level's step variance to the noise's, positive and at most 100.
    ///
    /// # Errors
    /// Another ratio.
    pub fn new(q: f64) -> Result<Self, EstimatorError> {
        if !(q > 0.0 && q <= 100.0) {
            return Err(EstimatorError::Parameter {
                estimator: "kalman",
                parameter: "q",
                value: q,
                range: "above 0 and at most 100",
            });
        }
        Ok(Self {
            name: format!("kalman({q})"),
            ratio: q,
            count: 0,
            level: 0.0,
            predicted: 0.0,
            sum: 0.0,
            level_spread: 1.0,
            expected: 0.0,
            half_spread: 0.0,
        })
    }
}

impl StreamSigma for Kalman {
    fn name(&self) -> &str {
        &self.name
    }

    fn min_len(&self) -> usize {
        2
    }

    fn push(&mut self, value: f64) {
        self.count += 1;
        if self.count == 1 {
            self.level = value;
            self.predicted = 1.0 + self.ratio; // the first sample fixes the level to R
            return;
        }
        let innovation = value - self.level;
        let (spread, gain) = (1.0 + self.predicted, self.predicted / (1.0 + self.predicted));
        self.level += gain * innovation;
        self.sum += innovation * innovation / spread;
        let expected = (1.0 + self.level_spread) / spread;
        self.expected += expected;
        self.half_spread += expected * expected;
        self.level_spread = (1.0 - gain).powi(2) * self.level_spread + gain * gain;
        self.predicted = self.predicted * (1.0 - gain) + self.ratio;
    }

    fn sigma(&self) -> f64 {
        if self.count < 2 {
            return f64::NAN;
        }
        // Innovations are taken as uncorrelated here; it changes the correction of the root only.
        let nu = self.expected * self.expected / self.half_spread;
        (self.sum / self.expected).sqrt() / c4(nu)
    }

    fn reset(&mut self) {
        (self.count, self.level, self.predicted, self.sum) = (0, 0.0, 0.0, 0.0);
        (self.level_spread, self.expected, self.half_spread) = (1.0, 0.0, 0.0);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_prediction_variance_settles_at_the_riccati_root() {
        let mut kalman = Kalman::new(0.1).unwrap();
        (0..200).for_each(|_| kalman.push(0.0));
        // p = p / (1 + p) + q  =>  p^2 - q p - q = 0
        let root = 0.5 * (0.1 + (0.01_f64 + 0.4).sqrt());
        assert!((kalman.predicted - root).abs() < 1e-14);
    }

    #[test]
    fn ratios_out_of_range_are_refused() {
        for q in [0.0, -1.0, 101.0, f64::NAN] {
            assert!(Kalman::new(q).is_err(), "{q}");
        }
    }
}
