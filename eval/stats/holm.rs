//! p-values of several tests at once.

use super::error::StatsError;

/// Holm's step-down adjustment, in the order given: comparing each with alpha bounds the probability of any false rejection by
/// alpha, whatever the dependence between the tests. Source: S. Holm, Scandinavian Journal of Statistics 1979.
///
/// # Errors
/// A value outside \[0, 1\].
pub fn holm(p: &[f64]) -> Result<Vec<f64>, StatsError> {
    if let Some(&value) = p.iter().find(|p| !(0.0..=1.0).contains(*p)) {
        return Err(StatsError::BadArgument { name: "p", value, bound: "between 0 and 1" });
    }
    let mut order: Vec<usize> = (0..p.len()).collect();
    order.sort_by(|&a, &b| p[a].total_cmp(&p[b]));
    let mut adjusted = vec![0.0; p.len()];
    let mut largest: f64 = 0.0;
    for (i, &k) in order.iter().enumerate() {
        largest = largest.max(p[k] * (p.len() - i) as f64).min(1.0);
        adjusted[k] = largest;
    }
    Ok(adjusted)
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde::Deserialize;

    #[derive(Deserialize)]
    struct Row {
        p: Vec<f64>,
        adjusted: Vec<f64>,
    }

    #[derive(Deserialize)]
    struct Golden {
        holm: Vec<Row>,
    }

    #[test]
    fn adjusted_values_are_statsmodels() {
        let golden: Golden = dpn_testing::golden("paired_tests");
        for row in golden.holm {
            for (got, expected) in holm(&row.p).unwrap().iter().zip(&row.adjusted) {
                assert!((got - expected).abs() < 1e-14, "{:?}", row.p);
            }
        }
    }

    #[test]
    fn what_is_no_probability_is_refused() {
        assert!(holm(&[0.1, f64::NAN]).is_err());
        assert!(holm(&[1.1]).is_err());
        assert_eq!(holm(&[]).unwrap(), Vec::<f64>::new());
    }
}
