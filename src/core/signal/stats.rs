//! Statistics of one window: moments, quantiles, median absolute deviation, differences.
//!
//! All take a slice, allocate at most one copy, and return NaN for a window too short to define the figure. Values
//! must be finite. Conventions are those of numpy and scipy, named at each function.

/// What the sum of squares about the mean is divided by.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Ddof {
    /// By `n`: the deviation of these very numbers (numpy's default).
    Zero,
    /// By `n - 1`: unbiased variance of what the numbers were drawn from.
    One,
}

/// Deviation of a normal variable over its median absolute deviation, `1 / Phi^-1(3/4)`.
pub(crate) const MAD_TO_SIGMA: f64 = 1.482_602_218_505_602;

/// Arithmetic mean; NaN for no values.
pub fn mean(x: &[f64]) -> f64 {
    let rough = x.iter().sum::<f64>() / x.len() as f64;
    // The second pass recovers the digits the first lost to a large offset.
    rough + x.iter().map(|v| v - rough).sum::<f64>() / x.len() as f64
}

/// Central moment of order `k` about the mean, divided by `n`.
fn central_moment(x: &[f64], k: i32) -> f64 {
    let centre = mean(x);
    x.iter().map(|v| (v - centre).powi(k)).sum::<f64>() / x.len() as f64
}

/// Variance in two passes; NaN for fewer values than the divisor needs.
pub fn variance(x: &[f64], ddof: Ddof) -> f64 {
    let centre = mean(x);
    let squares: f64 = x.iter().map(|v| (v - centre) * (v - centre)).sum();
    match (ddof, x.len()) {
        (_, 0) | (Ddof::One, 1) => f64::NAN,
        (Ddof::Zero, n) => squares / n as f64,
        (Ddof::One, n) => squares / (n - 1) as f64,
    }
}

/// Standard deviation in two passes; NaN for fewer values than the divisor needs.
pub fn deviation(x: &[f64], ddof: Ddof) -> f64 {
    variance(x, ddof).sqrt()
}

/// Median; the mean of the middle two for an even count. NaN for no values.
pub fn median(x: &[f64]) -> f64 {
    median_in_place(&mut x.to_vec())
}

/// As [`median`], reordering `x` instead of copying it.
pub fn median_in_place(x: &mut [f64]) -> f64 {
    if x.is_empty() {
        return f64::NAN;
    }
    let middle = x.len() / 2;
    let odd = !x.len().is_multiple_of(2);
    let (below, &mut upper, _) = x.select_nth_unstable_by(middle, f64::total_cmp);
    if odd {
        return upper;
    }
    let lower = below.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    0.5 * (lower + upper)
}

/// Median of values that there may be none of.
pub fn median_of(values: impl IntoIterator<Item = f64>) -> Option<f64> {
    let mut values: Vec<f64> = values.into_iter().collect();
    (!values.is_empty()).then(|| median_in_place(&mut values))
}

/// The median as a value that was there: of an even count the larger of the middle two. None for no values.
pub fn upper_median(values: impl IntoIterator<Item = f64>) -> Option<f64> {
    let mut values: Vec<f64> = values.into_iter().collect();
    let middle = values.len() / 2;
    (!values.is_empty()).then(|| *values.select_nth_unstable_by(middle, f64::total_cmp).1)
}

/// Median absolute deviation about the median, times 1.4826: estimates the deviation of a normal variable.
pub fn mad(x: &[f64]) -> f64 {
    let mut work = x.to_vec();
    let centre = median_in_place(&mut work);
    work.iter_mut().for_each(|v| *v = (*v - centre).abs());
    MAD_TO_SIGMA * median_in_place(&mut work)
}

/// Quantiles at `levels` in \[0, 1\], linear between order statistics (Hyndman and Fan's type 7, numpy's default).
///
/// Sorts once for all levels. NaN for no values and for a level outside \[0, 1\].
pub fn quantiles(x: &[f64], levels: &[f64]) -> Vec<f64> {
    let mut sorted = x.to_vec();
    sorted.sort_unstable_by(f64::total_cmp);
    levels.iter().map(|level| of_sorted(&sorted, *level)).collect()
}

fn of_sorted(sorted: &[f64], level: f64) -> f64 {
    if sorted.is_empty() || !(0.0..=1.0).contains(&level) {
        return f64::NAN;
    }
    let place = level * (sorted.len() - 1) as f64;
    let below = place.floor() as usize;
    let above = (below + 1).min(sorted.len() - 1);
    sorted[below] + (place - below as f64) * (sorted[above] - sorted[below])
}

/// The quantile at one `level`; see [`quantiles`].
pub fn quantile(x: &[f64], level: f64) -> f64 {
    quantiles(x, &[level])[0]
}

/// Excess kurtosis `m4 / m2^2 - 3`, zero for a normal variable (scipy's default). NaN for a constant window.
pub fn excess_kurtosis(x: &[f64]) -> f64 {
    central_moment(x, 4) / central_moment(x, 2).powi(2) - 3.0
}

/// Differences of order `order`: `order` values fewer than `x`; empty when `x` is too short.
pub fn differences(x: &[f64], order: usize) -> Vec<f64> {
    let mut out = x.to_vec();
    for _ in 0..order.min(x.len()) {
        for i in 1..out.len() {
            out[i - 1] = out[i] - out[i - 1];
        }
        out.pop();
    }
    out
}

/// Deviation of a difference of order `order` over that of the white noise under it: `sqrt(C(2 order, order))`.
pub fn difference_gain(order: usize) -> f64 {
    // C(2k, k) = prod (k + i) / i, whole after every step.
    (1..=order).fold(1.0, |c, i| c * (order + i) as f64 / i as f64).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use serde::Deserialize;
    use std::collections::BTreeMap;

    #[derive(Deserialize)]
    struct Row {
        x: Vec<f64>,
        mean: f64,
        deviation_0: f64,
        deviation_1: f64,
        median: f64,
        mad: f64,
        quantiles: Vec<f64>,
        kurtosis: f64,
        differences: Vec<Vec<f64>>,
    }

    #[derive(Deserialize)]
    struct Golden {
        levels: Vec<f64>,
        rows: BTreeMap<String, Row>,
    }

    #[test]
    fn statistics_agree_with_numpy_and_scipy() {
        let golden: Golden = dpn_testing::golden("stats");
        for (name, row) in &golden.rows {
            let x = &row.x;
            // A large offset costs both sides digits of the input itself.
            let (same, near) = (1e-14, if name == "offset" { 1e-8 } else { 1e-11 });
            let check = |what: &str, got: f64, expected: f64, tolerance: f64| {
                let error = (got - expected).abs() / expected.abs().max(1.0e-3);
                assert!(error < tolerance, "{name} {what}: {got} is not {expected} ({error:e})");
            };
            check("mean", mean(x), row.mean, same);
            check("deviation 0", deviation(x, Ddof::Zero), row.deviation_0, near);
            check("deviation 1", deviation(x, Ddof::One), row.deviation_1, near);
            check("median", median(x), row.median, same);
            check("mad", mad(x), row.mad, 1e-13);
            check("kurtosis", excess_kurtosis(x), row.kurtosis, near);
            for ((got, expected), level) in
                quantiles(x, &golden.levels).iter().zip(&row.quantiles).zip(&golden.levels)
            {
                check(&format!("quantile {level}"), *got, *expected, same);
            }
            for (k, expected) in row.differences.iter().enumerate() {
                assert_eq!(&differences(x, k + 1), expected, "{name} order {}", k + 1);
            }
        }
    }

    #[test]
    fn medians_of_what_there_may_be_none_of() {
        let x = [4.0, 1.0, 2.0, 3.0];
        assert_eq!((median_of(x), upper_median(x)), (Some(2.5), Some(3.0)));
        assert_eq!((median_of([7.0]), upper_median([7.0])), (Some(7.0), Some(7.0)));
        assert_eq!((median_of([]), upper_median([])), (None, None));
    }

    #[test]
    fn windows_too_short_for_a_figure_give_nan_and_not_a_panic() {
        for figure in [mean(&[]), median(&[]), mad(&[]), quantile(&[], 0.5), deviation(&[1.0], Ddof::One)] {
            assert!(figure.is_nan());
        }
        assert!(quantile(&[1.0, 2.0], 1.5).is_nan());
        assert!(differences(&[1.0, 2.0], 2).is_empty());
        assert!(differences(&[1.0], 5).is_empty());
    }

    #[test]
    fn the_gain_of_a_difference_is_the_norm_of_its_binomials() {
        for (order, square) in [(0, 1.0), (1, 2.0), (2, 6.0), (3, 20.0), (4, 70.0)] {
            assert!((difference_gain(order) - f64::sqrt(square)).abs() < 1e-14);
        }
    }

    proptest! {
        #[test]
        fn shifting_and_scaling_moves_location_and_scale_alike(
            x in prop::collection::vec(-1.0..1.0_f64, 2..60), a in 0.1..5.0_f64, b in -20.0..20.0_f64,
        ) {
            let y: Vec<f64> = x.iter().map(|v| a * v + b).collect();
            prop_assert!((mean(&y) - (a * mean(&x) + b)).abs() < 1e-12);
            prop_assert!((median(&y) - (a * median(&x) + b)).abs() < 1e-12);
            prop_assert!((mad(&y) - a * mad(&x)).abs() < 1e-12);
            prop_assert!((deviation(&y, Ddof::One) - a * deviation(&x, Ddof::One)).abs() < 1e-12);
        }

        #[test]
        fn differences_of_order_k_forget_a_polynomial_of_lower_degree(
            c in prop::collection::vec(-1.0..1.0_f64, 4), k in 1_usize..5,
        ) {
            let x: Vec<f64> = (0..30)
                .map(|i| c[..k].iter().rev().fold(0.0, |sum, c| sum * f64::from(i) / 30.0 + c))
                .collect();
            prop_assert!(differences(&x, k).iter().all(|d| d.abs() < 1e-13));
        }
    }
}
