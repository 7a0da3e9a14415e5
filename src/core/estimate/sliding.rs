//! Deviation of the last samples.

use super::quadratic::c4;
use super::{EstimatorError, StreamSigma};
use crate::signal::stats::{Ddof, deviation};

/// `sliding(length)`: deviation about the mean of the last `length` samples (of all, while there are fewer).
///
/// Takes everything for noise that happens within the window, motion and gravity's turning included. Forgets what is
/// older at once. At rest it has the smallest spread a window of that length allows.
#[derive(Debug, Clone)]
pub struct Sliding {
    name: String,
    length: usize,
    /// The last samples, the oldest overwritten first; their order does not matter.
    ring: Vec<f64>,
    oldest: usize,
}

impl Sliding {
    /// Over the last `length` samples.
    ///
    /// # Errors
    /// `length` below 2.
    pub fn new(length: usize) -> Result<Self, EstimatorError> {
        if length < 2 {
            return Err(EstimatorError::Parameter {
                estimator: "sliding",
                parameter: "length",
                value: length as f64,
                range: "at least 2",
            });
        }
        Ok(Self { name: format!("sliding({length})"), length, ring: Vec::new(), oldest: 0 })
    }
}

impl StreamSigma for Sliding {
    fn name(&self) -> &str {
        &self.name
    }

    fn min_len(&self) -> usize {
        2
    }

    fn push(&mut self, value: f64) {
        if self.ring.len() < self.length {
            self.ring.push(value);
        } else {
            self.ring[self.oldest] = value;
            self.oldest = (self.oldest + 1) % self.length;
        }
    }

    fn sigma(&self) -> f64 {
        if self.ring.len() < 2 {
            return f64::NAN;
        }
        deviation(&self.ring, Ddof::One) / c4((self.ring.len() - 1) as f64)
    }

    fn reset(&mut self) {
        self.ring.clear();
        self.oldest = 0;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_the_last_samples_count() {
        let x: Vec<f64> = (0..50).map(|i| f64::from((i * 7919) % 211)).collect();
        let (mut long, mut short) = (Sliding::new(8).unwrap(), Sliding::new(8).unwrap());
        x.iter().for_each(|v| long.push(*v));
        x[42..].iter().for_each(|v| short.push(*v));
        assert!((long.sigma() / short.sigma() - 1.0).abs() < 1e-14);
    }
}
