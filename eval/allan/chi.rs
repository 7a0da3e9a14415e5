//! Intervals of a quantity that scatters as a chi-squared variable: a variance.

/// Standard normal quantile of 97.5 %.
const Z: f64 = 1.959_963_984_540_054;

/// The 95 % interval of what was estimated as `value` with a standard error of `error`, both positive.
///
/// With nu = 2 value^2 / error^2 degrees of freedom, nu value / quantile; the quantiles are Wilson and Hilferty's, within 1 % from
/// three degrees of freedom on at the upper end and wider than exact at the lower one.
pub(super) fn interval(value: f64, error: f64) -> (f64, f64) {
    if value <= 0.0 {
        return (0.0, 2.0 * error);
    }
    let freedom = (2.0 * (value / error).powi(2)).min(1e12);
    if freedom.is_nan() || freedom < 0.5 {
        return (0.0, value + 2.0 * error);
    }
    let quantile = |z: f64| {
        let part = 2.0 / (9.0 * freedom);
        (1.0 - part + z * part.sqrt()).max(1e-3).powi(3)
    };
    (value / quantile(Z), value / quantile(-Z))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Quantiles of chi-squared by R: qchisq(c(.025, .975), c(10, 100)).
    #[test]
    fn quantiles_are_those_of_the_tables() {
        for (freedom, low, high, off) in
            [(10.0f64, 3.246_973, 20.483_177, 0.005), (100.0, 74.221_927, 129.561_197, 1e-3)]
        {
            let error = (2.0 / freedom).sqrt();
            let (a, b) = interval(1.0, error);
            assert!((freedom / b / low - 1.0).abs() < off, "{}", freedom / b);
            assert!((freedom / a / high - 1.0).abs() < off, "{}", freedom / a);
        }
    }
}
