//! Exponentially weighted deviation, with the mean tracked.
//!
//! Sample `i` of `k` weighs `(1 - a)^(k - i)`. With the sum of weights `W <- (1 - a) W + 1` and `d = x - mean`:
//! `mean <- mean + d / W`, `squares <- (1 - a) squares + d^2 (1 - 1 / W)` (West 1979; `1 / W` falls to `a`, so the first
//! samples count alike and no starting value lingers). Beside them run their expectations for white noise of sigma 1:
//! of the mean's variance `u <- (1 - 1 / W)^2 u + 1 / W^2`, hence of `d^2`, `1 + u`, and of the squares and their spread.
//! The answer is divided by that expectation, so that neither the start nor `a` biases it.

use super::quadratic::c4;
use super::{EstimatorError, StreamSigma};

/// `ewma(alpha)`: exponentially weighted variance of weight `alpha` for the latest sample.
///
/// Takes for noise what a mean of the last `1 / alpha` samples does not follow, motion included. Its memory is about
/// `(2 - alpha) / alpha` samples: .01 is worth a window of 200. A jolt is forgotten slowly.
#[derive(Debug, Clone)]
pub struct Ewma {
    name: String,
    alpha: f64,
    count: usize,
    weight: f64,
    mean: f64,
    squares: f64,
    /// Under white noise of sigma 1: variance of the mean, expectation and half the variance of the squares.
    mean_spread: f64,
    expected: f64,
    half_spread: f64,
}

impl Ewma {
    /// With weight `alpha`, above 0 and below 1.
    ///
    /// # Errors
    /// Another weight.
    pub fn new(alpha: f64) -> Result<Self, EstimatorError> {
        if !(alpha > 0.0 && alpha < 1.0) {
            return Err(EstimatorError::Parameter {
                estimator: "ewma",
                parameter: "alpha",
                value: alpha,
                range: "above 0 and below 1",
            });
        }
        Ok(Self {
            name: format!("ewma({alpha})"),
            alpha,
            count: 0,
            weight: 0.0,
            mean: 0.0,
            squares: 0.0,
            mean_spread: 0.0,
            expected: 0.0,
            half_spread: 0.0,
        })
    }
}

impl StreamSigma for Ewma {
    fn name(&self) -> &str {
        &self.name
    }

    fn min_len(&self) -> usize {
        2
    }

    fn push(&mut self, value: f64) {
        self.count += 1;
        let keep = 1.0 - self.alpha;
        self.weight = keep * self.weight + 1.0;
        let (gain, rest) = (1.0 / self.weight, 1.0 - 1.0 / self.weight);
        let d = value - self.mean;
        self.mean += gain * d;
        self.squares = keep * self.squares + rest * d * d;
        let expected = rest * (1.0 + self.mean_spread);
        self.expected = keep * self.expected + expected;
        self.half_spread = keep * keep * self.half_spread + expected * expected;
        self.mean_spread = rest * rest * self.mean_spread + gain * gain;
    }

    fn sigma(&self) -> f64 {
        if self.count < 2 {
            return f64::NAN;
        }
        // Innovations are taken as uncorrelated here; it changes the correction of the root only.
        let nu = self.expected * self.expected / self.half_spread;
        (self.squares / self.expected).sqrt() / c4(nu)
    }

    fn reset(&mut self) {
        (self.count, self.weight, self.mean, self.squares) = (0, 0.0, 0.0, 0.0);
        (self.mean_spread, self.expected, self.half_spread) = (0.0, 0.0, 0.0);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn weights_outside_zero_to_one_are_refused() {
        for alpha in [0.0, 1.0, -0.1, f64::NAN] {
            assert!(Ewma::new(alpha).is_err(), "{alpha}");
        }
    }

    #[test]
    fn the_recursion_is_the_weighted_deviation() {
        let (alpha, n) = (0.07, 60);
        let x: Vec<f64> = (0..n).map(|i| 9.81 + f64::from((i * 7919) % 211) / 100.0).collect();
        let mut ewma = Ewma::new(alpha).unwrap();
        x.iter().for_each(|v| ewma.push(*v));
        let weights: Vec<f64> = (0..n).rev().map(|age| (1.0 - alpha).powi(age)).collect();
        let total: f64 = weights.iter().sum();
        let mean = x.iter().zip(&weights).map(|(v, w)| v * w).sum::<f64>() / total;
        let squares: f64 = x.iter().zip(&weights).map(|(v, w)| w * (v - mean) * (v - mean)).sum();
        assert!((ewma.mean / mean - 1.0).abs() < 1e-13);
        assert!((ewma.squares / squares - 1.0).abs() < 1e-12);
        // Expectation of the weighted squares under white noise: sum w - sum w^2 / sum w.
        let expected = total - weights.iter().map(|w| w * w).sum::<f64>() / total;
        assert!((ewma.expected / expected - 1.0).abs() < 1e-12);
    }
}
