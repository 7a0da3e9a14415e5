//! Equivalence of paired measurements: two one-sided tests against a margin.
//!
//! The null hypotheses are that the centre of the differences is at most -margin, and that it is at least +margin; p is the larger of the
//! two one-sided p-values, and below alpha the centre lies within the margin, at that level. A test of difference that fails to reject
//! says nothing of the kind. Two forms: `equivalence_t` tests the mean by Student's t (differences about normal), `equivalence_signed_rank`
//! the pseudo-median by Wilcoxon's signed ranks of d + margin and d - margin (differences symmetric about their centre; with few pairs it
//! cannot go below 2^-n). For errors of odometry take [`log_ratios`] and a margin of ln(1 + share): ratios are symmetric then, and
//! one hard sequence does not outweigh the others. Source: D. J. Schuirmann, Journal of Pharmacokinetics and Biopharmaceutics 1987.

use super::error::{StatsError, finite, probability};
use super::hodges_lehmann::hodges_lehmann;
use super::signed_rank::{Alternative, signed_rank};
use dpn_core::signal::stats::{Ddof, deviation, mean};
use serde::{Deserialize, Serialize};
use statrs::distribution::{ContinuousCDF, StudentsT};

/// The result of two one-sided tests.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Equivalence {
    /// The centre: mean (t) or Hodges-Lehmann estimate (signed ranks).
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

/// Tests by Student's t that the mean of paired `differences` lies within `margin` of zero. Differences that are all the same decide
/// it without doubt.
///
/// # Errors
/// Fewer than two differences; one that is not finite; a margin that is not positive and finite.
pub fn equivalence_t(differences: &[f64], margin: f64) -> Result<Equivalence, StatsError> {
    check(differences, margin, "an equivalence test by t", 2)?;
    let n = differences.len() as f64;
    let estimate = mean(differences);
    let error = deviation(differences, Ddof::One) / n.sqrt();
    let t = StudentsT::new(0.0, 1.0, n - 1.0).map_err(|_| StatsError::TooFew {
        what: "an equivalence test by t",
        needed: 2,
        found: differences.len(),
    })?;
    // P(T >= distance / error); without scatter the sign of the distance decides.
    let tail = |distance: f64| match (error > 0.0, distance > 0.0) {
        (true, _) => t.sf(distance / error),
        (false, true) => 0.0,
        (false, false) => 1.0,
    };
    Ok(both(estimate, margin, tail(estimate + margin), tail(margin - estimate)))
}

/// Tests by signed ranks that the pseudo-median of paired `differences` lies within `margin` of zero; exact up to
/// [`super::EXACT_UP_TO`] differences.
///
/// # Errors
/// No difference; one that is not finite; a margin that is not positive and finite.
pub fn equivalence_signed_rank(differences: &[f64], margin: f64) -> Result<Equivalence, StatsError> {
    check(differences, margin, "an equivalence test by ranks", 1)?;
    let shifted = |by: f64, alternative| -> Result<f64, StatsError> {
        let moved: Vec<f64> = differences.iter().map(|d| d + by).collect();
        Ok(signed_rank(&moved, alternative)?.p)
    };
    Ok(both(
        hodges_lehmann(differences)?,
        margin,
        shifted(margin, Alternative::Greater)?,
        shifted(-margin, Alternative::Less)?,
    ))
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

impl Equivalence {
    /// Whether the two tests reject at `alpha`.
    ///
    /// # Errors
    /// `alpha` outside (0, 1).
    pub fn holds(&self, alpha: f64) -> Result<bool, StatsError> {
        probability("alpha", alpha)?;
        Ok(self.p < alpha)
    }
}

fn both(estimate: f64, margin: f64, p_low: f64, p_high: f64) -> Equivalence {
    Equivalence { estimate, margin, p_low, p_high, p: p_low.max(p_high) }
}

fn check(differences: &[f64], margin: f64, what: &'static str, needed: usize) -> Result<(), StatsError> {
    finite(differences)?;
    if differences.len() < needed {
        return Err(StatsError::TooFew { what, needed, found: differences.len() });
    }
    if !(margin.is_finite() && margin > 0.0) {
        return Err(StatsError::BadArgument { name: "margin", value: margin, bound: "positive and finite" });
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde::Deserialize;

    #[derive(Deserialize)]
    struct Row {
        d: Vec<f64>,
        margin: f64,
        p_t: f64,
        p_t_low: f64,
        p_t_high: f64,
        p_rank_low: f64,
        p_rank_high: f64,
    }

    #[derive(Deserialize)]
    struct Golden {
        equivalence: Vec<Row>,
    }

    #[test]
    fn p_values_are_those_of_statsmodels_and_scipy() {
        let golden: Golden = dpn_testing::golden("paired_tests");
        for row in golden.equivalence {
            let got = equivalence_t(&row.d, row.margin).unwrap();
            for (got, expected) in [(got.p_low, row.p_t_low), (got.p_high, row.p_t_high), (got.p, row.p_t)] {
                assert!((got - expected).abs() < 1e-10 + 1e-9 * expected, "{got} {expected}");
            }
            let got = equivalence_signed_rank(&row.d, row.margin).unwrap();
            assert!((got.p_low - row.p_rank_low).abs() < 1e-12, "{got:?}");
            assert!((got.p_high - row.p_rank_high).abs() < 1e-12, "{got:?}");
        }
    }

    #[test]
    fn differences_without_scatter_decide_it() {
        assert_eq!(equivalence_t(&[0.25; 5], 0.5).unwrap().p, 0.0);
        assert_eq!(equivalence_t(&[0.5; 5], 0.5).unwrap().p, 1.0);
        assert_eq!(equivalence_t(&[-0.75; 5], 0.5).unwrap().p, 1.0);
        assert_eq!(equivalence_signed_rank(&[0.0; 5], 0.5).unwrap().p, 1.0 / 32.0);
        assert!(equivalence_t(&[0.0; 5], 0.1).unwrap().holds(0.05).unwrap());
    }

    #[test]
    fn a_factor_and_its_inverse_are_equally_far_from_none() {
        let got = log_ratios(&[2.0, 0.5, 1.0], &[1.0, 1.0, 1.0]).unwrap();
        assert_eq!(got, [2.0_f64.ln(), -(2.0_f64.ln()), 0.0]);
        assert!(log_ratios(&[1.0], &[]).is_err());
        assert!(log_ratios(&[1.0], &[0.0]).is_err());
        assert!(equivalence_t(&[1.0], 0.1).is_err());
        assert!(equivalence_signed_rank(&[1.0], 0.0).is_err());
    }
}
