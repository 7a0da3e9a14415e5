//! The constant that other noises are compared with.

use super::rows::RowSet;
use dpn_core::estimate::NoiseSpec;
use dpn_train::split::Side;
use serde::Serialize;

/// The constant that other noises are compared with.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Reference {
    /// The constant.
    pub noise: NoiseSpec,
    /// How it was chosen.
    pub choice: Choice,
    /// Whether it was chosen and is the lowest or the highest multiple of the baseline that was run: the lowest error may lie beyond it.
    pub at_edge: bool,
}

/// How a [`Reference`] was chosen. Nothing of a sequence that it is judged on alone ever chooses it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Choice {
    /// The constant with the lowest error on the training sequences; there are test sequences beside them.
    Training,
    /// x1, the baseline: there is nothing to choose on but what is judged.
    Baseline,
}

/// The figure by which a constant is chosen: the one that is reported.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Criterion {
    /// [`RowSet::mean`].
    Mean,
    /// [`RowSet::median`].
    Median,
}

impl Reference {
    /// What it is and what it was chosen on: `x4, the best constant on the training sequences`.
    pub fn words(&self) -> String {
        let noise = &self.noise;
        match self.choice {
            Choice::Training => format!("{noise}, the best constant on the training sequences"),
            Choice::Baseline => format!(
                "{noise}, the usual constants (no constant is chosen without both training and test sequences)"
            ),
        }
    }
}

impl RowSet<'_> {
    /// The constant whose error on the training sequences is lowest, the first of equal ones; x1 where there are not both training
    /// and test sequences, or no constant has an error on all training sequences; none where x1 was not run either.
    pub fn reference(&self, by: Criterion) -> Option<Reference> {
        let error = |noise: &NoiseSpec| match by {
            Criterion::Mean => self.mean(noise, Some(Side::Train)),
            Criterion::Median => self.median(noise, Some(Side::Train)),
        };
        let both = self.count(Some(Side::Train)) > 0 && self.count(Some(Side::Test)) > 0;
        let constants = self.noises().iter().filter(|noise| both && noise.is_constant());
        let with_error = constants.filter_map(|noise| Some((error(noise)?, *noise)));
        if let Some((_, best)) = with_error.min_by(|a, b| a.0.total_cmp(&b.0)) {
            return Some(Reference {
                noise: best.clone(),
                choice: Choice::Training,
                at_edge: self.at_edge(best),
            });
        }
        let x1 = self.noises().iter().find(|noise| noise.multiple() == Some(1.0))?;
        Some(Reference { noise: (*x1).clone(), choice: Choice::Baseline, at_edge: false })
    }

    /// Whether `constant` is the lowest or the highest multiple of the baseline that was run.
    fn at_edge(&self, constant: &NoiseSpec) -> bool {
        let all: Vec<f64> = self.noises().iter().filter_map(|noise| noise.multiple()).collect();
        let of = constant.multiple();
        of.is_some_and(|of| all.iter().all(|m| *m <= of) || all.iter().all(|m| *m >= of))
    }
}

#[cfg(test)]
mod tests {
    use super::super::testing::{noise, rows};
    use super::*;
    use crate::closed_loop::testing::row;

    #[test]
    fn the_best_constant_is_chosen_on_training_sequences_alone() {
        let mut rows = rows();
        let reference = RowSet::new(&rows).reference(Criterion::Mean).unwrap();
        assert_eq!((&reference.noise, reference.choice), (&noise("x4"), Choice::Training));
        assert!(reference.at_edge && reference.words() == "x4, the best constant on the training sequences");
        // Whatever happens to the test sequences.
        for row in rows.iter_mut().filter(|r| r.split == Side::Test && r.noise == noise("x8")) {
            row.ate_se3 = Some(1e-6);
        }
        assert_eq!(RowSet::new(&rows).reference(Criterion::Mean).unwrap(), reference);
        assert_eq!(RowSet::new(&rows).reference(Criterion::Median).unwrap().noise, noise("x4"));
    }

    #[test]
    fn without_a_side_to_choose_on_and_one_to_judge_nothing_is_chosen() {
        let of_side = |side: Side, with_x1: bool| {
            let mut rows = rows();
            if with_x1 {
                rows.extend((0..8).map(|i| row(&format!("s{i}"), "x1", 0, Some(0.9))));
            }
            rows.retain(|row| (row.sequence.as_bytes()[1] % 2 == 1) == (side == Side::Test));
            rows.iter_mut().for_each(|row| row.split = side);
            RowSet::new(&rows).reference(Criterion::Mean)
        };
        for side in [Side::Train, Side::Test] {
            let reference = of_side(side, true).unwrap();
            assert_eq!((&reference.noise, reference.choice), (&noise("x1"), Choice::Baseline));
            assert_eq!(of_side(side, false), None);
        }
    }
}
