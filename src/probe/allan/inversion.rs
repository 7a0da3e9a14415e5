//! The interval of a square that was fitted: all values under which the estimate would not have been unlikely.
//!
//! A fitted square scatters by what else is in the log, whatever its own size, and by its own noise, in proportion to its size: its variance
//! at a true square s is a + b s + c s^2. Where the first term rules the estimate is normal about s, and an absent noise often leaves
//! one above zero; where the last rules it is a chi-squared variable of 2 / c degrees of freedom. In between its skewness is
//! the own share's: 2 sqrt(c) (c s^2 / variance)^(3/2). The 95 % interval holds every s whose own 2.5 and 97.5 % quantiles enclose the estimate; the
//! quantiles are those of a shifted chi-squared variable of that skewness. It holds 0 unless the estimate is too large for an absent noise.

use super::chi;

/// Skewness below this is none.
const NORMAL: f64 = 1e-3;

/// Variance of an estimate by the true square.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Spread {
    constant: f64,
    linear: f64,
    square: f64,
}

impl Spread {
    /// From variances at 0, `at` and twice `at`.
    pub(super) fn through(at: f64, [zero, one, two]: [f64; 3]) -> Self {
        let square = (two - 2.0 * one + zero) / (2.0 * at * at);
        let square = square.max(0.0);
        Self { constant: zero.max(0.0), linear: ((one - zero) / at - square * at).max(0.0), square }
    }

    /// The same, every variance `times` as large.
    pub(super) fn times(self, times: f64) -> Self {
        Self { constant: self.constant * times, linear: self.linear * times, square: self.square * times }
    }

    /// Standard error at a true square.
    pub(super) fn error(self, truth: f64) -> f64 {
        (self.constant + truth * (self.linear + truth * self.square)).sqrt()
    }

    /// Distances of the 2.5 and the 97.5 % quantile of the estimate from the true square, both positive.
    fn reach(self, truth: f64) -> (f64, f64) {
        let error = self.error(truth);
        let own = if error > 0.0 { self.square.sqrt() * truth / error } else { 0.0 };
        let skewness = (2.0 * self.square.sqrt() * own.powi(3)).max(NORMAL);
        let freedom = 8.0 / (skewness * skewness);
        let unit = error / (2.0 * freedom).sqrt();
        ((freedom - chi::lower(freedom)) * unit, (chi::upper(freedom) - freedom) * unit)
    }

    /// The least estimate that no absent noise leaves, but one time in forty.
    pub(super) fn least_seen(self) -> f64 {
        self.reach(0.0).1
    }

    /// The 95 % interval about an estimate.
    pub(super) fn interval(self, estimate: f64) -> (f64, f64) {
        let too_small = |truth: f64| truth + self.reach(truth).1 < estimate;
        let low = if too_small(0.0) { bisect(0.0, estimate, too_small) } else { 0.0 };
        let too_large = |truth: f64| truth - self.reach(truth).0 > estimate;
        let mut above = estimate + self.error(estimate);
        for _ in 0..60 {
            if too_large(above) {
                break;
            }
            above *= 2.0;
        }
        (low, bisect(estimate, above, |truth| !too_large(truth)))
    }
}

/// Where `below` ends between `low` and `high`.
fn bisect(mut low: f64, mut high: f64, below: impl Fn(f64) -> bool) -> f64 {
    for _ in 0..50 {
        let middle = 0.5 * (low + high);
        if below(middle) {
            low = middle;
        } else {
            high = middle;
        }
    }
    0.5 * (low + high)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn alone_in_the_log_it_is_the_interval_of_a_variance_and_under_others_that_of_a_normal() {
        // Ten degrees of freedom: scipy.stats.chi2.ppf([.025, .975], 10).
        let own = Spread { constant: 0.0, linear: 0.0, square: 0.2 };
        let (low, high) = own.interval(3.0);
        assert!((low / (30.0 / 20.483_177) - 1.0).abs() < 0.01, "{low}");
        assert!((high / (30.0 / 3.246_973) - 1.0).abs() < 0.02, "{high}");
        let other = Spread { constant: 4.0, linear: 0.0, square: 0.0 };
        let (low, high) = other.interval(5.0);
        assert!((low - 1.08).abs() < 0.01 && (high - 8.92).abs() < 0.01, "{low} {high}");
        // 1.9 standard errors are no sign of anything.
        assert_eq!(other.interval(3.8).0, 0.0);
        assert!((other.least_seen() - 3.92).abs() < 0.01);
        let fitted = Spread::through(2.0, [4.0, 4.0 + 2.0 + 0.8, 4.0 + 4.0 + 3.2]);
        assert!((fitted.error(10.0).powi(2) - (4.0 + 10.0 + 20.0)).abs() < 1e-9, "{fitted:?}");
    }
}
