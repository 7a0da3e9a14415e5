//! What the rows of a closed loop say of every noise: errors over sequences, and each noise against one constant, paired by sequence.
//!
//! 1. [`RowSet`]: rows by noise and sequence. A sequence's figure is the median over seeds.
//! 2. [`Reference`]: the constant that others are compared with, chosen on the training sequences, never in the sample it is judged on.
//! 3. [`Comparison`]: the geometric mean of the ratio of errors with its bootstrap interval, Wilcoxon's signed-rank test, Holm's correction.
//! 4. [`Study`]: all of it; `dpn eval --closed-loop` and `dpn paper` print the same one.

mod compare;
mod file;
mod reference;
mod rows;
mod summary;

pub(crate) use compare::pairs;
pub use compare::{Comparison, FEWEST_SEQUENCES, compare, compare_pairs, correct_for_count};
pub use file::StudyFile;
pub use reference::{Choice, Criterion, Reference};
pub use rows::RowSet;
pub use summary::NoiseSummary;

use crate::stats::StatsError;
use dpn_core::estimate::NoiseSpec;
use serde::Serialize;

/// Half width of what counts as equal to the reference, as a share of its error, where nothing else is asked for.
pub const MARGIN: f64 = 0.1;

/// Every noise of a closed loop.
#[derive(Debug, Clone, Serialize)]
pub struct Study {
    /// What noises are compared with; none where neither a constant could be chosen nor x1 was run.
    pub reference: Option<Reference>,
    /// A line a noise, in the order of [`RowSet::noises`].
    pub noises: Vec<NoiseSummary>,
    /// Half width of what counts as equal to the reference, as a share of its error.
    pub margin: f64,
}

impl Study {
    /// The study of `rows`.
    ///
    /// # Errors
    /// An error of a run that is zero or not finite; a `margin` that is not positive and finite.
    pub fn new(rows: &RowSet<'_>, margin: f64) -> Result<Self, StatsError> {
        Self::against(rows, rows.reference(Criterion::Mean), margin)
    }

    /// The same against another reference.
    ///
    /// # Errors
    /// As of [`new`](Self::new).
    pub fn against(rows: &RowSet<'_>, reference: Option<Reference>, margin: f64) -> Result<Self, StatsError> {
        let of = |noise: &&NoiseSpec| NoiseSummary::new(rows, noise);
        let mut noises = rows.noises().iter().map(of).collect::<Result<Vec<_>, _>>()?;
        if let Some(reference) = &reference {
            for line in noises.iter_mut().filter(|line| line.noise != reference.noise) {
                line.comparison = compare(rows, &line.noise, &reference.noise, margin)?;
            }
            correct_for_count(noises.iter_mut().filter_map(|line| line.comparison.as_mut()))?;
        }
        Ok(Self { reference, noises, margin })
    }

    /// The line of one noise.
    pub fn of(&self, noise: &NoiseSpec) -> Option<&NoiseSummary> {
        self.noises.iter().find(|line| line.noise == *noise)
    }

    /// Whether `noise` is what the others are compared with.
    pub fn is_reference(&self, noise: &NoiseSpec) -> bool {
        self.reference.as_ref().is_some_and(|reference| reference.noise == *noise)
    }
}

#[cfg(test)]
mod testing {
    use crate::closed_loop::{Row, testing::row};
    use dpn_core::estimate::NoiseSpec;
    use dpn_train::split::Side;

    pub(super) fn noise(spec: &str) -> NoiseSpec {
        spec.parse().unwrap()
    }

    /// Eight sequences, odd ones to test on; the best constant of these alone would be x8.
    pub(super) fn rows() -> Vec<Row> {
        let mut rows = Vec::new();
        for i in 0..8_u32 {
            let name = format!("s{i}");
            let base = 0.1 + 0.01 * f64::from(i);
            let odd = i % 2 == 1;
            for (noise, factor) in [("x4", 1.0), ("x8", if odd { 0.7 } else { 1.4 }), ("dualpronet", 0.8)] {
                for seed in 0..3 {
                    let mut row = row(&name, noise, seed, Some(base * factor * (1.0 + 0.01 * seed as f64)));
                    row.split = if odd { Side::Test } else { Side::Train };
                    rows.push(row);
                }
            }
        }
        rows
    }
}

#[cfg(test)]
mod tests {
    use super::testing::{noise, rows};
    use super::*;

    #[test]
    fn ratios_and_tests_are_over_sequences_and_corrected_for_the_number_of_noises() {
        let rows = rows();
        let study = Study::new(&RowSet::new(&rows), 0.1).unwrap();
        let of = |spec: &str| study.of(&noise(spec)).unwrap();
        assert!(of("x4").comparison.is_none() && study.is_reference(&noise("x4")));
        let ours = of("dualpronet").comparison.clone().unwrap();
        assert_eq!((ours.sequences, ours.better), (8, 8));
        assert!((ours.ratio - 0.8).abs() < 1e-12 && (ours.ratio_interval[1] - 0.8).abs() < 1e-12);
        // All eight signs alike: 2 / 2^8, times two noises; far from within 10 %.
        assert!((ours.p.unwrap() - 0.0078125).abs() < 1e-12);
        assert!((ours.p_holm.unwrap() - 0.015625).abs() < 1e-12);
        assert!(ours.p_equal.unwrap() > 0.9);
        assert_eq!(of("x8").comparison.clone().unwrap().better, 4);
        assert_eq!(of("dualpronet").seeds, [3, 3]);
    }

    #[test]
    fn without_a_constant_to_compare_with_nothing_is_compared() {
        let mut rows = rows();
        rows.retain(|row| row.sequence == "s1");
        let study = Study::new(&RowSet::new(&rows), 0.1).unwrap();
        assert_eq!(study.reference, None);
        assert!(study.noises.iter().all(|line| line.comparison.is_none()));
    }
}
