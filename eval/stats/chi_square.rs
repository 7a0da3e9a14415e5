//! Bounds of a sum of squares.

use super::error::{StatsError, probability};
use statrs::distribution::{ChiSquared, ContinuousCDF};

/// Between what a chi-square variable of `dof` degrees of freedom lies with probability `confidence`, as much of the rest below as above.
///
/// # Errors
/// `dof` not positive and finite; `confidence` outside (0, 1).
pub fn chi_square_interval(dof: f64, confidence: f64) -> Result<[f64; 2], StatsError> {
    probability("confidence", confidence)?;
    let bad = StatsError::BadArgument { name: "dof", value: dof, bound: "positive and finite" };
    if !dof.is_finite() {
        return Err(bad);
    }
    let chi = ChiSquared::new(dof).map_err(|_| bad)?;
    let tail = 0.5 * (1.0 - confidence);
    Ok([tail, 1.0 - tail].map(|p| chi.inverse_cdf(p)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde::Deserialize;

    #[derive(Deserialize)]
    struct Row {
        dof: f64,
        confidence: f64,
        low: f64,
        high: f64,
    }

    #[derive(Deserialize)]
    struct Golden {
        chi_square: Vec<Row>,
    }

    #[test]
    fn bounds_are_scipys() {
        let golden: Golden = dpn_testing::golden("paired_tests");
        for row in golden.chi_square {
            let got = chi_square_interval(row.dof, row.confidence).unwrap();
            for (got, expected) in got.into_iter().zip([row.low, row.high]) {
                assert!((got / expected - 1.0).abs() < 1e-9, "{}: {got} {expected}", row.dof);
            }
        }
    }

    #[test]
    fn what_is_no_probability_or_dof_is_refused() {
        for (dof, confidence) in
            [(3.0, 0.0), (3.0, 1.0), (3.0, f64::NAN), (0.0, 0.9), (f64::NAN, 0.9), (f64::INFINITY, 0.9)]
        {
            assert!(chi_square_interval(dof, confidence).is_err());
        }
    }
}
