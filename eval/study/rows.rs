//! Rows of one closed loop, by noise and sequence.

use crate::closed_loop::{Row, TruthKind};
use dpn_core::estimate::NoiseSpec;
use dpn_core::signal::stats::{mean, median_of};
use dpn_train::split::Side;
use std::collections::BTreeMap;

/// Rows of one closed loop, by noise and sequence.
#[derive(Debug)]
pub struct RowSet<'a> {
    rows: &'a [Row],
    noises: Vec<&'a NoiseSpec>,
    sequences: Vec<(&'a str, Side)>,
}

impl<'a> RowSet<'a> {
    /// Of all `rows`.
    pub fn new(rows: &'a [Row]) -> Self {
        let mut noises: Vec<&NoiseSpec> = Vec::new();
        let mut sequences: BTreeMap<&str, Side> = BTreeMap::new();
        for row in rows {
            if !noises.contains(&&row.noise) {
                noises.push(&row.noise);
            }
            sequences.insert(&row.sequence, row.split);
        }
        noises.sort_by(|a, b| {
            let [a, b] = [a, b].map(|noise| noise.multiple().unwrap_or(f64::INFINITY));
            a.total_cmp(&b)
        });
        Self { rows, noises, sequences: sequences.into_iter().collect() }
    }

    /// Noises: multiples of the baseline in their order, then the others in that of the rows.
    pub fn noises(&self) -> &[&'a NoiseSpec] {
        &self.noises
    }

    /// Names of the sequences of one side or of both, in order.
    pub fn sequences(&self, side: Option<Side>) -> impl Iterator<Item = &'a str> {
        let wanted = self.sequences.iter().filter(move |(_, of)| side.is_none_or(|side| side == *of));
        wanted.map(|(name, _)| *name)
    }

    /// What the runs were judged by; the published truth where no row says it.
    pub fn truth(&self) -> TruthKind {
        self.rows.iter().find_map(|row| row.truth).unwrap_or(TruthKind::Published)
    }

    /// How many sequences one side or both have.
    pub fn count(&self, side: Option<Side>) -> usize {
        self.sequences(side).count()
    }

    /// All rows of one noise.
    pub fn of<'s>(&'s self, noise: &'s NoiseSpec) -> impl Iterator<Item = &'a Row> + 's {
        self.rows.iter().filter(move |row| row.noise == *noise)
    }

    /// All rows of one noise and sequence.
    pub fn cell<'s>(&'s self, sequence: &'s str, noise: &'s NoiseSpec) -> impl Iterator<Item = &'a Row> + 's {
        self.of(noise).filter(move |row| row.sequence == sequence)
    }

    /// Median over seeds of the error \[m\], where any run has one.
    pub fn ate(&self, sequence: &str, noise: &NoiseSpec) -> Option<f64> {
        median_of(self.cell(sequence, noise).filter_map(|row| row.ate_se3))
    }

    /// Failed runs of one noise and sequence.
    pub fn failures(&self, sequence: &str, noise: &NoiseSpec) -> usize {
        self.cell(sequence, noise).filter(|row| row.failure.is_some()).count()
    }

    /// Medians over seeds of the sequences that have one \[m\].
    pub fn ates(&self, noise: &NoiseSpec, side: Option<Side>) -> Vec<f64> {
        self.sequences(side).filter_map(|name| self.ate(name, noise)).collect()
    }

    /// Median over sequences \[m\], a sequence without an error counting as worse than any: none where that leaves no figure.
    pub fn median(&self, noise: &NoiseSpec, side: Option<Side>) -> Option<f64> {
        let worst = |name: &str| self.ate(name, noise).unwrap_or(f64::INFINITY);
        median_of(self.sequences(side).map(worst)).filter(|median| median.is_finite())
    }

    /// Mean over sequences \[m\]; none where a sequence has no error, for means of different sets mislead.
    pub fn mean(&self, noise: &NoiseSpec, side: Option<Side>) -> Option<f64> {
        let ates = self.ates(noise, side);
        (!ates.is_empty() && ates.len() == self.count(side)).then(|| mean(&ates))
    }
}

#[cfg(test)]
mod tests {
    use super::super::testing::{noise, rows};
    use super::*;

    #[test]
    fn cells_are_medians_over_seeds_and_multiples_come_first() {
        let rows = rows();
        let of = RowSet::new(&rows);
        assert_eq!(
            of.noises().iter().map(ToString::to_string).collect::<Vec<_>>(),
            ["x4", "x8", "dualpronet"]
        );
        assert!((of.ate("s0", &noise("x4")).unwrap() - 0.101).abs() < 1e-12);
        assert_eq!((of.count(None), of.count(Some(Side::Test))), (8, 4));
    }

    #[test]
    fn a_mean_over_fewer_sequences_than_there_are_is_none() {
        let mut rows = rows();
        for row in rows.iter_mut().filter(|r| r.sequence == "s3" && r.noise == noise("x8")) {
            row.ate_se3 = None;
        }
        let (of, x8) = (RowSet::new(&rows), noise("x8"));
        // Its errors are .14, .077, .168, none, .196, .105, .224, .119: between .14 and .168 with none last.
        let middle = 0.5 * (of.ate("s0", &x8).unwrap() + of.ate("s2", &x8).unwrap());
        assert!((of.median(&x8, None).unwrap() - middle).abs() < 1e-12);
        assert_eq!(of.mean(&x8, None), None);
        assert!(of.mean(&x8, Some(Side::Train)).is_some());
        let comparison = super::super::compare(&of, &x8, &noise("x4"), 0.1).unwrap().unwrap();
        assert_eq!(comparison.sequences, 7);
    }
}
