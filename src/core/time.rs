//! Instants as integer nanoseconds, and sampling rates.

use serde::{Deserialize, Serialize};
use std::fmt;

/// An instant: integer nanoseconds since the recording's own epoch. Seconds appear only as differences.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(transparent)]
pub struct Stamp(i64);

impl Stamp {
    /// The instant `ns` nanoseconds after the epoch.
    pub const fn from_ns(ns: i64) -> Self {
        Self(ns)
    }

    /// Nanoseconds since the epoch.
    pub const fn ns(self) -> i64 {
        self.0
    }

    /// Seconds from `earlier` to this instant; negative when `earlier` is later.
    pub fn seconds_since(self, earlier: Self) -> f64 {
        // The difference of two `i64` fits `i128`; its conversion is exact below 104 days.
        (i128::from(self.0) - i128::from(earlier.0)) as f64 * 1e-9
    }

    /// The instant `seconds` later, rounded to the nearest nanosecond.
    pub fn plus_seconds(self, seconds: f64) -> Self {
        Self(self.0.saturating_add((seconds * 1e9).round() as i64))
    }
}

/// The median step between instants in their order \[ns\]; of an even count the longer of the middle two, so that it is a step that was
/// there. None for fewer than two instants.
pub fn median_step_ns(stamps: impl IntoIterator<Item = Stamp>) -> Option<i64> {
    let stamps: Vec<Stamp> = stamps.into_iter().collect();
    let mut steps: Vec<i64> = stamps.windows(2).map(|pair| pair[1].0.saturating_sub(pair[0].0)).collect();
    let middle = steps.len() / 2;
    (!steps.is_empty()).then(|| *steps.select_nth_unstable(middle).1)
}

/// [`median_step_ns`] in seconds.
pub fn median_step_s(stamps: impl IntoIterator<Item = Stamp>) -> Option<f64> {
    median_step_ns(stamps).map(|step| Stamp(step).seconds_since(Stamp(0)))
}

impl fmt::Display for Stamp {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} ns", self.0)
    }
}

/// Samples a second, positive and finite.
#[derive(Debug, Clone, Copy, PartialEq, PartialOrd, Serialize, Deserialize)]
#[serde(transparent)]
pub struct SampleRate(f64);

impl SampleRate {
    /// EuRoC's and the paper's IMU rate.
    pub const HZ_200: Self = Self(200.0);

    /// A rate of `hz` samples a second; `None` unless positive and finite.
    pub fn from_hz(hz: f64) -> Option<Self> {
        (hz.is_finite() && hz > 0.0).then_some(Self(hz))
    }

    /// Samples a second \[Hz\].
    pub fn hz(self) -> f64 {
        self.0
    }

    /// Time between two samples \[s\].
    pub fn period(self) -> f64 {
        1.0 / self.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn seconds_keep_nanoseconds_at_unix_epoch_scale() {
        let a = Stamp::from_ns(1_403_636_579_758_555_392);
        let b = Stamp::from_ns(1_403_636_579_763_555_392);
        assert!((b.seconds_since(a) - 0.005).abs() < 1e-15);
        assert_eq!(a.plus_seconds(0.005), b);
    }

    #[test]
    fn the_median_step_is_one_that_was_there() {
        let of = |ns: &[i64]| median_step_ns(ns.iter().copied().map(Stamp::from_ns));
        assert_eq!(of(&[0, 5, 1000, 1007]), Some(7));
        assert_eq!(of(&[0, 5, 12]), Some(7));
        assert_eq!((of(&[3]), of(&[])), (None, None));
        assert_eq!(median_step_s([0, 5_000_000].map(Stamp::from_ns)), Some(5e6 * 1e-9));
    }

    #[test]
    fn a_rate_must_be_positive_and_finite() {
        for bad in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            assert!(SampleRate::from_hz(bad).is_none());
        }
    }
}
