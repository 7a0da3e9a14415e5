//! Every noise against the best constant, paired by sequence.
//!
//! A sequence's figure is the median over seeds of the absolute error; its pair is the log ratio to that of the best constant, the constant (or
//! pair of constants) whose mean over sequences is lowest *in these very rows*, which favours the constant. Wilcoxon's signed-rank
//! test, two-sided, Holm's correction over the noises; the ratio is the exponential of the Hodges-Lehmann estimate. Sequences in which one of both
//! has no error are left out.

use super::row::Row;
use crate::stats::{Alternative, StatsError, hodges_lehmann, holm, log_ratios, signed_rank};
use dpn_core::estimate::NoiseSpec;
use serde::Serialize;

/// Fewest sequences that are compared: of five pairs the smallest two-sided p is .0625.
const FEWEST: usize = 6;

/// One noise against the best constant.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Comparison {
    /// The noise.
    pub noise: String,
    /// The best constant.
    pub constant: String,
    /// Sequences in which both have an error.
    pub sequences: usize,
    /// Those in which the noise is better.
    pub better: usize,
    /// Error over that of the constant, by Hodges and Lehmann.
    pub ratio: f64,
    /// Two-sided p of the signed-rank test.
    pub p: f64,
    /// The same, corrected for the number of noises.
    pub p_holm: f64,
}

/// Compares every noise of `rows` with the best constant among them; nothing where there is none, or with few sequences.
///
/// # Errors
/// An error of a run that is zero or not finite.
pub fn compare(rows: &[Row]) -> Result<Vec<Comparison>, StatsError> {
    let noises = super::table::distinct(rows.iter().map(|r| r.noise.as_str()));
    let mean = |noise: &str| {
        let values: Vec<f64> = medians(rows, noise).into_iter().map(|(_, ate)| ate).collect();
        (!values.is_empty()).then(|| values.iter().sum::<f64>() / values.len() as f64)
    };
    let constants = noises.iter().filter(|noise| is_constant(noise));
    let best = constants.filter_map(|noise| Some((mean(noise)?, *noise))).min_by(|a, b| a.0.total_cmp(&b.0));
    let Some((_, constant)) = best else {
        return Ok(Vec::new());
    };
    let reference = medians(rows, constant);
    let mut found = Vec::new();
    for noise in noises.into_iter().filter(|noise| *noise != constant) {
        let of = medians(rows, noise);
        let pairs = of.iter().filter_map(|(sequence, ate)| {
            Some((*ate, reference.iter().find(|(other, _)| other == sequence)?.1))
        });
        let (ours, theirs): (Vec<f64>, Vec<f64>) = pairs.unzip();
        if ours.len() < FEWEST {
            continue;
        }
        let differences = log_ratios(&ours, &theirs)?;
        found.push(Comparison {
            noise: noise.to_owned(),
            constant: constant.to_owned(),
            sequences: ours.len(),
            better: differences.iter().filter(|d| **d < 0.0).count(),
            ratio: hodges_lehmann(&differences)?.exp(),
            p: signed_rank(&differences, Alternative::TwoSided)?.p,
            p_holm: 1.0,
        });
    }
    let p: Vec<f64> = found.iter().map(|c| c.p).collect();
    for (comparison, p) in found.iter_mut().zip(holm(&p)?) {
        comparison.p_holm = p;
    }
    Ok(found)
}

/// Every sequence that has an error with `noise`, and its median over seeds.
fn medians<'a>(rows: &'a [Row], noise: &str) -> Vec<(&'a str, f64)> {
    let sequences = super::table::distinct(rows.iter().map(|r| r.sequence.as_str()));
    let of = |sequence: &&'a str| Some((*sequence, super::table::cell(rows, sequence, noise).ate?));
    sequences.iter().filter_map(of).collect()
}

fn is_constant(noise: &str) -> bool {
    noise.parse().is_ok_and(|noise: NoiseSpec| noise.is_constant())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::closed_loop::row::testing::row;

    /// A noise, and its error in the i-th sequence.
    type Made = (&'static str, fn(usize) -> f64);

    fn rows(of: &[Made]) -> Vec<Row> {
        let cells = of.iter().flat_map(|(noise, ate)| {
            (0..8).map(|i| row(&format!("f{i:02}"), noise, 0, Some(ate(i)))).collect::<Vec<_>>()
        });
        cells.collect()
    }

    #[test]
    fn the_best_constant_is_the_reference_and_each_noise_has_its_ratio_and_p() {
        let base = |i: usize| 0.1 + 0.01 * i as f64;
        let rows = rows(&[
            ("x1", |i| 0.3 + 0.01 * i as f64),
            ("x4,x1", base),
            ("dualpronet", |i| 0.5 * (0.1 + 0.01 * i as f64)),
            ("diff2", |i| (0.1 + 0.01 * i as f64) * if i % 2 == 0 { 1.01 } else { 1.0 / 1.01 }),
        ]);
        let found = compare(&rows).unwrap();
        let of = |noise: &str| found.iter().find(|c| c.noise == noise).unwrap();
        assert_eq!(found.len(), 3);
        assert!(found.iter().all(|c| c.constant == "x4,x1" && c.sequences == 8));
        let pronet = of("dualpronet");
        assert!((pronet.ratio - 0.5).abs() < 1e-12 && pronet.better == 8);
        // All eight signs alike: 2 / 2^8.
        assert!((pronet.p - 0.0078125).abs() < 1e-12, "{pronet:?}");
        assert!((pronet.p_holm - 3.0 * 0.0078125).abs() < 1e-12, "{pronet:?}");
        assert!(of("diff2").p > 0.5 && of("diff2").better == 4);
        assert_eq!(of("x1").better, 0);
    }

    #[test]
    fn without_a_constant_or_with_few_sequences_nothing_is_compared() {
        let all = rows(&[("x1", |_| 0.1), ("diff2", |_| 0.2)]);
        assert_eq!(compare(&all[..5]).unwrap(), []);
        assert_eq!(compare(&all[8..]).unwrap(), []);
        let few: Vec<Row> = all.iter().filter(|r| r.sequence.as_str() < "f05").cloned().collect();
        assert_eq!(compare(&few).unwrap(), []);
    }
}
