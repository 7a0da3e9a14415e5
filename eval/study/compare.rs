//! One noise against another, sequence by sequence.

use super::rows::RowSet;
use crate::stats::{
    Alternative, Bootstrap, StatsError, bootstrap, equivalence_signed_rank, holm, log_ratios, signed_rank,
};
use dpn_core::estimate::NoiseSpec;
use dpn_core::random::Stream;
use dpn_core::signal::stats::{mean, median_of};
use serde::Serialize;
use std::collections::BTreeMap;

/// Fewest sequences that are tested: of five pairs the smallest two-sided p is .0625.
pub const FEWEST_SEQUENCES: usize = 6;

/// One noise against another, sequence by sequence.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Comparison {
    /// Sequences in which both have an error.
    pub sequences: usize,
    /// Those in which the noise is better.
    pub better: usize,
    /// Geometric mean of the ratio of errors.
    pub ratio: f64,
    /// Its 95 % bootstrap interval over sequences.
    pub ratio_interval: [f64; 2],
    /// Two-sided p of the signed-rank test; none with fewer sequences than [`FEWEST_SEQUENCES`].
    pub p: Option<f64>,
    /// The same, corrected by [`correct_for_count`].
    pub p_holm: Option<f64>,
    /// p of two one-sided signed-rank tests that the ratio lies within the margin.
    pub p_equal: Option<f64>,
}

/// `noise` against `reference`, not corrected for other comparisons; nothing with fewer than two sequences in common. `margin` is the half
/// width of what counts as equal, as a share of the reference's error.
///
/// # Errors
/// An error of a run that is zero or not finite; a `margin` that is not positive and finite.
pub fn compare(
    rows: &RowSet<'_>,
    noise: &NoiseSpec,
    reference: &NoiseSpec,
    margin: f64,
) -> Result<Option<Comparison>, StatsError> {
    let (ours, theirs) = pairs(rows, noise, reference);
    compare_pairs(&ours, &theirs, margin)
}

/// [`compare`] of errors that are paired already.
///
/// # Errors
/// As [`compare`].
pub fn compare_pairs(ours: &[f64], theirs: &[f64], margin: f64) -> Result<Option<Comparison>, StatsError> {
    if ours.len() < 2 {
        return Ok(None);
    }
    let logs = log_ratios(ours, theirs)?;
    let statistic = |cases: &[usize]| mean(&cases.iter().map(|&i| logs[i]).collect::<Vec<_>>());
    let stream = Stream::new(0).named("paper").named("ratio");
    let interval = bootstrap(logs.len(), statistic, &Bootstrap::default(), &stream)?;
    let tested = logs.len() >= FEWEST_SEQUENCES;
    let p = if tested { Some(signed_rank(&logs, Alternative::TwoSided)?.p) } else { None };
    let p_equal = if tested { Some(equivalence_signed_rank(&logs, (1.0 + margin).ln())?.p) } else { None };
    Ok(Some(Comparison {
        sequences: logs.len(),
        better: logs.iter().filter(|d| **d < 0.0).count(),
        ratio: interval.observed.exp(),
        ratio_interval: [interval.low.exp(), interval.high.exp()],
        p,
        p_holm: None,
        p_equal,
    }))
}

/// Corrects for the number of tests, by Holm.
///
/// # Errors
/// A p that is no probability.
pub fn correct_for_count<'a>(tests: impl Iterator<Item = &'a mut Comparison>) -> Result<(), StatsError> {
    let mut tested: Vec<&mut Comparison> = tests.filter(|test| test.p.is_some()).collect();
    let p: Vec<f64> = tested.iter().filter_map(|test| test.p).collect();
    for (test, p) in tested.iter_mut().zip(holm(&p)?) {
        test.p_holm = Some(p);
    }
    Ok(())
}

/// Pairs of errors of two noises, by sequence: medians over the seeds that both have an error of.
pub(crate) fn pairs(rows: &RowSet<'_>, noise: &NoiseSpec, reference: &NoiseSpec) -> (Vec<f64>, Vec<f64>) {
    let by_seed = |name: &str, noise: &NoiseSpec| -> BTreeMap<u64, f64> {
        rows.cell(name, noise).filter_map(|row| Some((row.seed, row.ate_se3?))).collect()
    };
    let pair = |name: &str| {
        let (ours, theirs) = (by_seed(name, noise), by_seed(name, reference));
        let both = ours.iter().filter_map(|(seed, ate)| Some((*ate, *theirs.get(seed)?)));
        let (ours, theirs): (Vec<f64>, Vec<f64>) = both.unzip();
        Some((median_of(ours)?, median_of(theirs)?))
    };
    rows.sequences(None).filter_map(pair).unzip()
}

#[cfg(test)]
mod tests {
    use super::super::testing::{noise, rows};
    use super::*;

    #[test]
    fn noises_are_compared_on_the_seeds_that_both_have() {
        let mut rows = rows();
        // A second and third seed that went badly, for the reference alone.
        rows.retain(|r| r.noise != noise("dualpronet") || r.seed == 0);
        for row in rows.iter_mut().filter(|r| r.noise == noise("x4") && r.seed > 0) {
            row.ate_se3 = row.ate_se3.map(|ate| 7.0 * ate);
        }
        let ours = compare(&RowSet::new(&rows), &noise("dualpronet"), &noise("x4"), 0.1).unwrap().unwrap();
        assert!((ours.ratio - 0.8).abs() < 1e-12, "{}", ours.ratio);
    }

    #[test]
    fn few_sequences_have_a_ratio_and_no_test_and_one_has_nothing() {
        let mut rows = rows();
        rows.retain(|row| row.sequence.as_str() < "s5");
        let of = |rows: &[crate::closed_loop::Row]| {
            compare(&RowSet::new(rows), &noise("x8"), &noise("x4"), 0.1).unwrap()
        };
        let few = of(&rows).unwrap();
        assert_eq!((few.sequences, few.p, few.p_equal), (5, None, None));
        rows.retain(|row| row.sequence == "s0");
        assert_eq!(of(&rows), None);
    }
}
