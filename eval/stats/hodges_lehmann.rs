//! The centre of differences that belongs to the signed-rank test.

use super::error::{StatsError, finite};
use dpn_core::signal::stats::median_in_place;

/// The Hodges-Lehmann estimate: the median of the means of all pairs of values, each with itself included. Of `n` values there are
/// n (n + 1) / 2 pairs; all are held in memory. Source: J. L. Hodges and E. L. Lehmann, Annals of Mathematical Statistics 1963.
///
/// # Errors
/// No value; one that is not finite.
pub fn hodges_lehmann(differences: &[f64]) -> Result<f64, StatsError> {
    finite(differences)?;
    if differences.is_empty() {
        return Err(StatsError::TooFew { what: "the Hodges-Lehmann estimate", needed: 1, found: 0 });
    }
    let mut means: Vec<f64> = differences
        .iter()
        .enumerate()
        .flat_map(|(i, a)| differences[i..].iter().map(move |b| 0.5 * (a + b)))
        .collect();
    Ok(median_in_place(&mut means))
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde::Deserialize;

    #[derive(Deserialize)]
    struct Row {
        d: Vec<f64>,
        estimate: f64,
    }

    #[derive(Deserialize)]
    struct Golden {
        hodges_lehmann: Vec<Row>,
    }

    #[test]
    fn estimates_are_numpys() {
        let golden: Golden = dpn_testing::golden("paired_tests");
        for row in golden.hodges_lehmann {
            assert!((hodges_lehmann(&row.d).unwrap() - row.estimate).abs() < 1e-14);
        }
    }

    #[test]
    fn one_wild_value_moves_it_little() {
        assert_eq!(hodges_lehmann(&[1.0, 2.0, 3.0, 4.0, 1e9]).unwrap(), 3.0);
        assert_eq!(hodges_lehmann(&[7.0]).unwrap(), 7.0);
        assert!(hodges_lehmann(&[]).is_err());
        assert!(hodges_lehmann(&[f64::INFINITY]).is_err());
    }
}
