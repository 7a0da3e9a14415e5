//! Running deviation since the start, or over the first samples alone.

use super::quadratic::c4;
use super::{EstimatorError, StreamSigma};

/// `running` or `running(first)`: deviation of all samples so far by Welford's recursion; with `first`, of the first
/// so many, held from then on (how drivers calibrate at power-up and expect the sensor to lie still).
///
/// Takes everything for noise, motion and gravity's turning included: right for a sensor at rest, far too large on a
/// moving one, and slower to follow the longer it runs. At rest it has the smallest spread of all.
#[derive(Debug, Clone)]
pub struct Running {
    name: String,
    first: usize,
    count: usize,
    mean: f64,
    squares: f64,
}

impl Running {
    /// Over everything since the start.
    pub fn new() -> Self {
        Self { name: "running".into(), first: usize::MAX, count: 0, mean: 0.0, squares: 0.0 }
    }

    /// Over the first `first` samples.
    ///
    /// # Errors
    /// `first` below 2.
    pub fn over_first(first: usize) -> Result<Self, EstimatorError> {
        if first < 2 {
            return Err(EstimatorError::Parameter {
                estimator: "running",
                parameter: "first",
                value: first as f64,
                range: "at least 2",
            });
        }
        Ok(Self { name: format!("running({first})"), first, ..Self::new() })
    }
}

impl Default for Running {
    fn default() -> Self {
        Self::new()
    }
}

impl StreamSigma for Running {
    fn name(&self) -> &str {
        &self.name
    }

    fn min_len(&self) -> usize {
        2
    }

    fn push(&mut self, value: f64) {
        if self.count == self.first {
            return;
        }
        self.count += 1;
        let before = value - self.mean;
        self.mean += before / self.count as f64;
        self.squares += before * (value - self.mean);
    }

    fn sigma(&self) -> f64 {
        if self.count < 2 {
            return f64::NAN;
        }
        let nu = (self.count - 1) as f64;
        (self.squares / nu).sqrt() / c4(nu)
    }

    fn reset(&mut self) {
        (self.count, self.mean, self.squares) = (0, 0.0, 0.0);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::signal::stats::{Ddof, deviation};

    #[test]
    fn the_recursion_gives_the_two_pass_deviation_under_a_large_offset() {
        let x: Vec<f64> = (0..500).map(|i| 1e6 + f64::from((i * 7919) % 211)).collect();
        let mut running = Running::new();
        x.iter().for_each(|v| running.push(*v));
        let expected = deviation(&x, Ddof::One) / c4(499.0);
        assert!((running.sigma() / expected - 1.0).abs() < 1e-10);
    }

    #[test]
    fn what_comes_after_the_first_samples_changes_nothing() {
        let mut running = Running::over_first(3).unwrap();
        [1.0, 2.0, 4.0].iter().for_each(|v| running.push(*v));
        let sigma = running.sigma();
        running.push(1e9);
        assert_eq!(running.sigma(), sigma);
        assert!(Running::over_first(1).is_err());
    }
}
