//! A figure with what it lies between.

use serde::{Deserialize, Serialize};

/// 97.5 % of a normal distribution.
const NORMAL: f64 = 1.959_963_985;

/// A positive figure with its 95 % interval.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Interval {
    /// The median.
    pub value: f64,
    /// 2.5 % lies below.
    pub low: f64,
    /// 2.5 % lies above.
    pub high: f64,
}

impl Interval {
    /// An interval wider than this, higher over lower end, is a bound and no figure.
    pub const WIDEST: f64 = 3.0;

    /// Of a figure whose natural logarithm has this deviation.
    pub fn of_log(value: f64, deviation: f64) -> Self {
        let spread = (NORMAL * deviation).exp();
        Self { value, low: value / spread, high: value * spread }
    }

    /// Higher over lower end.
    pub fn width(&self) -> f64 {
        self.high / self.low
    }

    /// The same figure in another unit.
    #[must_use]
    pub fn times(&self, factor: f64) -> Self {
        Self { value: self.value * factor, low: self.low * factor, high: self.high * factor }
    }

    /// Deviation of its logarithm.
    pub fn log_deviation(&self) -> f64 {
        0.5 * self.width().ln() / NORMAL
    }
}

#[cfg(test)]
mod tests {
    use super::Interval;

    #[test]
    fn a_deviation_comes_back_from_its_interval() {
        let interval = Interval::of_log(2.0, 0.1);
        assert!((interval.log_deviation() - 0.1).abs() < 1e-12, "{interval:?}");
        assert!((interval.low * interval.high - 4.0).abs() < 1e-12);
        assert!((interval.times(3.0).width() - interval.width()).abs() < 1e-12);
    }
}
