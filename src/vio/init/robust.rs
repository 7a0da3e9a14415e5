//! Weights that fall with the residual, and the scale of residuals by their median.

/// Squared residual over its variance at which the weight is one half: for two normal components 99 % stay below 9.2.
const HALF_WEIGHT: f64 = 9.0;

/// Cauchy weight of a squared, whitened residual: 1 at zero, never rising.
#[inline]
pub(super) fn weight(squared: f64) -> f64 {
    1.0 / (1.0 + squared / HALF_WEIGHT)
}

/// Cauchy cost of a squared, whitened residual: half of it for small ones.
#[inline]
pub(super) fn cost(squared: f64) -> f64 {
    0.5 * HALF_WEIGHT * (squared / HALF_WEIGHT).ln_1p()
}

/// The median of absolute values; 0 of none.
pub(super) fn median(values: &mut [f64]) -> f64 {
    if values.is_empty() {
        return 0.0;
    }
    let middle = values.len() / 2;
    *values.select_nth_unstable_by(middle, f64::total_cmp).1
}

/// Deviation of normal noise whose absolute values have this median.
pub(super) fn std_of_median(median_of_absolute: f64) -> f64 {
    1.4826 * median_of_absolute
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn the_weight_is_the_costs_slope_and_never_rises(s in 0.0..200.0f64) {
            let h = 1e-4;
            let slope = (cost(s + h) - cost((s - h).max(0.0))) / (s + h - (s - h).max(0.0));
            prop_assert!((2.0 * slope - weight(s)).abs() < 1e-4);
            prop_assert!(weight(s + h) < weight(s));
        }
    }

    #[test]
    fn zero_has_weight_one_and_the_median_ignores_an_outlier() {
        assert_eq!(weight(0.0), 1.0);
        assert_eq!(median(&mut [3.0, 1e9, 1.0, 2.0, 2.5]), 2.5);
        assert_eq!(median(&mut []), 0.0);
    }
}
