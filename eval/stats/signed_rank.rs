//! Wilcoxon's signed-rank test of paired differences.
//!
//! W+ is the sum of the ranks of |d| over positive d; ties share their mean rank; differences of zero are left out (Wilcoxon's way).
//! Under the null hypothesis every difference is as likely to be positive as negative, its size given. Up to [`EXACT_UP_TO`] non-zero
//! differences the null distribution is counted exactly *with the ties that there are*, by adding one rank after another to the distribution
//! of sums; above, it is normal with the variance reduced for ties and with continuity correction.
//! Two-sided p: twice the smaller tail, at most 1. Differences that are equal but for rounding do not tie: round before testing
//! where that matters. Source: F. Wilcoxon, Biometrics Bulletin 1945; M. Hollander and D. A. Wolfe, "Nonparametric statistical methods", sec. 3.1.

use super::error::{StatsError, finite};
use super::ranks::doubled_midranks;
use serde::{Deserialize, Serialize};
use statrs::distribution::{ContinuousCDF, Normal};

/// Up to so many non-zero differences p is exact.
pub const EXACT_UP_TO: usize = 25;

/// What is held against the null hypothesis.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Alternative {
    /// The differences are not centred on zero.
    TwoSided,
    /// They tend to be below zero.
    Less,
    /// They tend to be above zero.
    Greater,
}

/// Where p comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum NullDistribution {
    /// Counted, ties included.
    Exact,
    /// Normal approximation.
    Normal,
}

/// The result of the test.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct SignedRank {
    /// Differences other than zero.
    pub n: usize,
    /// Differences of zero, left out.
    pub zeros: usize,
    /// Sum of ranks of positive differences.
    pub w_plus: f64,
    /// Sum of ranks of negative differences.
    pub w_minus: f64,
    /// Probability of as much or more under the null hypothesis; 1 where all differences are zero.
    pub p: f64,
    /// Where p comes from.
    pub null: NullDistribution,
}

/// Tests paired `differences`.
///
/// # Errors
/// A difference that is not finite; none at all.
pub fn signed_rank(differences: &[f64], alternative: Alternative) -> Result<SignedRank, StatsError> {
    finite(differences)?;
    if differences.is_empty() {
        return Err(StatsError::TooFew { what: "the signed-rank test", needed: 1, found: 0 });
    }
    let nonzero: Vec<f64> = differences.iter().copied().filter(|d| *d != 0.0).collect();
    let sizes: Vec<f64> = nonzero.iter().map(|d| d.abs()).collect();
    let ranks = doubled_midranks(&sizes);
    let sum_where = |keep: fn(&f64) -> bool| -> usize {
        let kept = nonzero.iter().zip(&ranks).filter(|(d, _)| keep(d));
        kept.map(|(_, rank)| rank).sum()
    };
    let (plus, minus) = (sum_where(|d| *d > 0.0), sum_where(|d| *d < 0.0));
    let (null, [less, greater]) = if nonzero.len() <= EXACT_UP_TO {
        (NullDistribution::Exact, exact_tails(&ranks, plus))
    } else {
        (NullDistribution::Normal, normal_tails(&ranks, plus))
    };
    Ok(SignedRank {
        n: nonzero.len(),
        zeros: differences.len() - nonzero.len(),
        w_plus: 0.5 * plus as f64,
        w_minus: 0.5 * minus as f64,
        p: match alternative {
            Alternative::TwoSided => (2.0 * less.min(greater)).min(1.0),
            Alternative::Less => less,
            Alternative::Greater => greater,
        },
        null,
    })
}

/// P(W+ <= observed) and P(W+ >= observed), with ranks and sums doubled.
fn exact_tails(ranks: &[usize], observed: usize) -> [f64; 2] {
    let total: usize = ranks.iter().sum();
    // ways[s]: sets of ranks that add up to s. At most 2^25, whole numbers in f64.
    let mut ways = vec![0.0; total + 1];
    ways[0] = 1.0;
    let mut reached = 0;
    for &rank in ranks {
        for sum in (0..=reached).rev() {
            ways[sum + rank] += ways[sum];
        }
        reached += rank;
    }
    let all = 2.0_f64.powi(ranks.len() as i32);
    let share = |ways: &[f64]| ways.iter().sum::<f64>() / all;
    [share(&ways[..=observed]), share(&ways[observed..])]
}

/// The same by the normal approximation.
fn normal_tails(ranks: &[usize], observed: usize) -> [f64; 2] {
    // The variance of a sum of ranks that are in or out: a quarter of their squares; ties are in the ranks already.
    let mean = 0.25 * ranks.iter().sum::<usize>() as f64;
    let squares: f64 = ranks.iter().map(|&r| (0.5 * r as f64).powi(2)).sum();
    let deviation = (0.25 * squares).sqrt();
    let off = 0.5 * observed as f64 - mean;
    let normal = Normal::standard();
    [normal.cdf((off + 0.5) / deviation), normal.sf((off - 0.5) / deviation)]
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde::Deserialize;
    use std::collections::BTreeMap;

    #[derive(Deserialize)]
    struct Row {
        d: Vec<f64>,
        w_plus: f64,
        w_minus: f64,
        p: BTreeMap<String, f64>,
    }

    #[derive(Deserialize)]
    struct Rows {
        exact: Vec<Row>,
        counted: Vec<Row>,
        normal: Vec<Row>,
    }

    #[derive(Deserialize)]
    struct Golden {
        signed_rank: Rows,
    }

    fn hold(rows: &[Row], null: NullDistribution, tolerance: f64) {
        let alternatives = [
            ("two-sided", Alternative::TwoSided),
            ("less", Alternative::Less),
            ("greater", Alternative::Greater),
        ];
        for row in rows {
            for (name, alternative) in alternatives {
                let got = signed_rank(&row.d, alternative).unwrap();
                assert_eq!((got.w_plus, got.w_minus), (row.w_plus, row.w_minus));
                assert_eq!(got.null, null);
                let expected = row.p[name];
                assert!((got.p - expected).abs() < tolerance, "{name}: {got:?} {expected}");
            }
        }
    }

    #[test]
    fn p_is_scipys_and_with_ties_that_of_all_signs_counted_one_by_one() {
        let golden: Golden = dpn_testing::golden("paired_tests");
        let rows = golden.signed_rank;
        hold(&rows.exact, NullDistribution::Exact, 1e-12);
        hold(&rows.counted, NullDistribution::Exact, 1e-12);
        hold(&rows.normal, NullDistribution::Normal, 1e-9);
    }

    #[test]
    fn eleven_out_of_eleven_is_two_in_two_to_the_eleventh() {
        let d: Vec<f64> = (1..=11).map(f64::from).collect();
        let got = signed_rank(&d, Alternative::TwoSided).unwrap();
        assert_eq!(got.p, 2.0 / 2048.0);
    }

    #[test]
    fn at_the_border_both_null_distributions_agree() {
        let d: Vec<f64> = (1..=25).map(|i| f64::from(i) * if i % 3 == 0 { -1.0 } else { 1.0 }).collect();
        let sizes: Vec<f64> = d.iter().map(|d| d.abs()).collect();
        let ranks = doubled_midranks(&sizes);
        for observed in (100..=550).step_by(50) {
            let (exact, normal) = (exact_tails(&ranks, observed), normal_tails(&ranks, observed));
            for (a, b) in exact.into_iter().zip(normal) {
                assert!((a - b).abs() < 4e-3, "{observed}: {exact:?} {normal:?}");
            }
        }
    }

    #[test]
    fn zeros_alone_say_nothing_and_bad_values_are_refused() {
        let got = signed_rank(&[0.0, 0.0], Alternative::TwoSided).unwrap();
        assert_eq!((got.n, got.zeros, got.p), (0, 2, 1.0));
        assert!(signed_rank(&[], Alternative::Less).is_err());
        let error = signed_rank(&[1.0, f64::NAN], Alternative::Less).unwrap_err();
        assert!(error.to_string().starts_with("value 1 is NaN"));
    }
}
