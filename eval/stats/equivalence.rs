//! Equivalence of paired measurements: two one-sided tests against a margin.
//!
//! The null hypotheses are that the centre of the differences is at most -margin, and that it is at least +margin; p is the larger of the
//! two one-sided p-values, and below alpha the centre lies within the margin, at that level. A test of difference that fails to reject
//! says nothing of the kind. The pseudo-median is tested by Wilcoxon's signed ranks of d + margin and d - margin (differences symmetric
//! about their centre; with few pairs p cannot go below 2^-n). For errors of odometry take [`log_ratios`] and a margin of ln(1 + share): ratios are symmetric then, and
//! one hard sequence does not outweigh the others. Source: D. J. Schuirmann, Journal of Pharmacokinetics and Biopharmaceutics 1987.

use super::error::{StatsError, finite};
use super::hodges_lehmann::hodges_lehmann;
use super::signed_rank::{Alternative, signed_rank};
use serde::{Deserialize, Serialize};

/// The result of two one-sided tests.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Equivalence {
    /// The centre: the Hodges-Lehmann estimate.
    pub estimate: f64,
    /// The margin tested against.
    pub margin: f64,
    /// p against a centre at or below -margin.
    pub p_low: f64,
    /// p against a centre at or above +margin.
    pub p_high: f64,
    /// The larger of the two: p of the test.
    pub p: f64,
}

/// Tests by signed ranks that the pseudo-median of paired `differences` lies within `margin` of zero; exact up to
/// [`super::EXACT_UP_TO`] differences.
///
/// # Errors
/// No difference; one that is not finite; a margin that is not positive and finite.
pub fn equivalence_signed_rank(differences: &[f64], margin: f64) -> Result<Equivalence, StatsError> {
    if !(margin.is_finite() && margin > 0.0) {
        return Err(StatsError::BadArgument { name: "margin", value: margin, bound: "positive and finite" });
    }
    let shifted = |by: f64, alternative| -> Result<f64, StatsError> {
        let moved: Vec<f64> = differences.iter().map(|d| d + by).collect();
        Ok(signed_rank(&moved, alternative)?.p)
    };
    // Refuses no difference, and one that is not finite.
    let estimate = hodges_lehmann(differences)?;
    let (p_low, p_high) = (shifted(margin, Alternative::Greater)?, shifted(-margin, Alternative::Less)?);
    Ok(Equivalence { estimate, margin, p_low, p_high, p: p_low.max(p_high) })
}

/// `ln(a / b)` pair by pair: 0 where they agree, the same size for a factor and its inverse.
///
/// # Errors
/// Different lengths; a value that is not positive and finite.
pub fn log_ratios(a: &[f64], b: &[f64]) -> Result<Vec<f64>, StatsError> {
    if a.len() != b.len() {
        return Err(StatsError::Unpaired { first: a.len(), second: b.len() });
    }
    finite(a)?;
    finite(b)?;
    if let Some(&value) = a.iter().chain(b).find(|v| **v <= 0.0) {
        return Err(StatsError::BadArgument { name: "a value of a ratio", value, bound: "positive" });
    }
    Ok(a.iter().zip(b).map(|(a, b)| (a / b).ln()).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde::Deserialize;

    #[derive(Deserialize)]
    struct Row {
        d: Vec<f64>,
        margin: f64,
        p_rank_low: f64,
        p_rank_high: f64,
    }

    #[derive(Deserialize)]
    struct Golden {
        equivalence: Vec<Row>,
    }

    #[test]
    fn p_values_are_scipys() {
        let golden: Golden = dpn_testing::golden("paired_tests");
        for row in golden.equivalence {
            let got = equivalence_signed_rank(&row.d, row.margin).unwrap();
            assert!((got.p_low - row.p_rank_low).abs() < 1e-12, "{got:?}");
            assert!((got.p_high - row.p_rank_high).abs() < 1e-12, "{got:?}");
        }
    }

    #[test]
    fn differences_without_scatter_decide_it() {
        assert_eq!(equivalence_signed_rank(&[0.0; 5], 0.5).unwrap().p, 1.0 / 32.0);
    }

    #[test]
    fn a_factor_and_its_inverse_are_equally_far_from_none() {
        let got = log_ratios(&[2.0, 0.5, 1.0], &[1.0, 1.0, 1.0]).unwrap();
        assert_eq!(got, [2.0_f64.ln(), -(2.0_f64.ln()), 0.0]);
        assert!(log_ratios(&[1.0], &[]).is_err());
        assert!(log_ratios(&[1.0], &[0.0]).is_err());
        assert!(equivalence_signed_rank(&[1.0], 0.0).is_err() && equivalence_signed_rank(&[], 0.1).is_err());
    }
}
