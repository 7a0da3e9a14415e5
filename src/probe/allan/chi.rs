//! Intervals of a quantity that scatters as a chi-squared variable: a variance.

/// Standard normal quantile of 97.5 %.
const Z: f64 = 1.959_963_984_540_054;

/// The 95 % interval of what was estimated as `value` with a standard error of `error`.
///
/// With nu = 2 value^2 / error^2 degrees of freedom, at least one half, nu value / quantile.
pub(super) fn interval(value: f64, error: f64) -> (f64, f64) {
    if value <= 0.0 {
        return (0.0, 2.0 * error);
    }
    let freedom = 2.0 * (value / error).powi(2);
    let freedom = if freedom.is_nan() { 0.5 } else { freedom.clamp(0.5, 1e12) };
    (value * freedom / upper(freedom), value * freedom / lower(freedom))
}

/// Quantile of 97.5 % by Wilson and Hilferty.
pub(super) fn upper(freedom: f64) -> f64 {
    hilferty(freedom, Z)
}

/// Quantile of 2.5 %: by Wilson and Hilferty, below five degrees by two terms of the incomplete gamma function's series.
pub(super) fn lower(freedom: f64) -> f64 {
    if freedom >= 5.0 {
        return hilferty(freedom, -Z);
    }
    let a = freedom / 2.0;
    let first = |more: f64| (0.025 * gamma_above_one(a) * more).powf(1.0 / a);
    2.0 * first(1.0 + a / (a + 1.0) * first(1.0))
}

fn hilferty(freedom: f64, z: f64) -> f64 {
    let part = 2.0 / (9.0 * freedom);
    freedom * (1.0 - part + z * part.sqrt()).powi(3)
}

/// Gamma of 1 + x for x in [0, 3]: Abramowitz and Stegun 6.1.35, to 5e-5.
fn gamma_above_one(x: f64) -> f64 {
    if x > 1.0 {
        return x * gamma_above_one(x - 1.0);
    }
    let terms = [-0.574_864_6, 0.951_236_3, -0.699_858_8, 0.424_554_9, -0.101_067_8];
    1.0 + terms.iter().rev().fold(0.0, |sum, term| (sum + term) * x)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Quantiles of chi-squared: scipy.stats.chi2.ppf([.025, .975], nu).
    #[test]
    fn quantiles_are_those_of_the_tables() {
        let table: [(f64, f64, f64); 6] = [
            (1.0, 0.000_982_07, 5.023_886),
            (2.0, 0.050_635_6, 7.377_759),
            (4.0, 0.484_418_6, 11.143_287),
            (6.0, 1.237_344, 14.449_375),
            (10.0, 3.246_973, 20.483_177),
            (100.0, 74.221_927, 129.561_197),
        ];
        for (freedom, low, high) in table {
            assert!((lower(freedom) / low - 1.0).abs() < 0.03, "{freedom}: {}", lower(freedom));
            assert!((upper(freedom) / high - 1.0).abs() < 0.03, "{freedom}: {}", upper(freedom));
            let (a, b) = interval(3.0, 3.0 * (2.0 / freedom).sqrt());
            assert!(
                (a - 3.0 * freedom / upper(freedom)).abs() < 1e-9
                    && (b - 3.0 * freedom / lower(freedom)).abs() < 1e-9 * b
            );
        }
    }
}
