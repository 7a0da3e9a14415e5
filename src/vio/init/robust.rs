//! Weights that fall with the residual, and the scale of residuals by their median.

use crate::factors::loss::Loss;
use dpn_core::signal::stats::upper_median;

/// Deviations at which the weight is one half: of two normal components together 99 % stay below 3.03.
pub(super) const LOSS_SCALE: f64 = 3.0;
/// The initialisation's loss.
pub(super) const LOSS: Loss = Loss::Cauchy;

/// Weight of a squared, whitened residual: 1 at zero, never rising.
#[inline]
pub(super) fn weight(squared: f64) -> f64 {
    LOSS.evaluate(squared, LOSS_SCALE).1
}

/// The median of absolute values; 0 of none.
pub(super) fn median(values: impl IntoIterator<Item = f64>) -> f64 {
    upper_median(values).unwrap_or(0.0)
}

/// Deviation of normal noise whose absolute values have this median.
pub(super) fn std_of_median(median_of_absolute: f64) -> f64 {
    1.4826 * median_of_absolute
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_median_ignores_an_outlier() {
        assert_eq!(median([3.0, 1e9, 1.0, 2.0, 2.5]), 2.5);
        assert_eq!(median([]), 0.0);
    }
}
