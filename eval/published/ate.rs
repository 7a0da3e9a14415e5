//! Absolute errors of other people's closed loops, by sequence and noise.

use super::rows;
use crate::closed_loop::TruthKind;
use dpn_core::estimate::NoiseSpec;
use dpn_train::split::paper_side;
use std::collections::BTreeMap;

/// Absolute errors of somebody else, by sequence and noise.
#[derive(Debug, Clone, PartialEq)]
pub struct PublishedAte {
    /// Whose: a word for the head of a column.
    pub name: &'static str,
    /// Decimals in which they are given.
    pub decimals: usize,
    rows: Vec<(String, Vec<(NoiseSpec, f64)>)>,
}

impl PublishedAte {
    /// The paper's table "ATE performance", on real images; noises `x0.5`, `x1`, `x2`, `dualpronet`.
    pub fn paper() -> Self {
        Self::read("paper", 2, include_str!("closed_loop.csv"))
    }

    /// VINS-Mono's (C++, its own defaults) on the given tracks, judged by this truth of the recordings; noises `x0.5` to `x16`.
    pub fn vins_mono(truth: TruthKind) -> Self {
        let table = match truth {
            TruthKind::Published | TruthKind::Exact => include_str!("vins_mono_tracks.csv"),
            TruthKind::Reconciled => include_str!("vins_mono_tracks_reconciled.csv"),
        };
        Self::read("vins", 3, table)
    }

    /// Absolute error of one cell \[m\]; `sequence` with or without its difficulty.
    pub fn ate(&self, sequence: &str, noise: &NoiseSpec) -> Option<f64> {
        paper_side(sequence)?;
        let (_, ates) = self.rows.iter().find(|(name, _)| sequence.starts_with(name.as_str()))?;
        ates.iter().find(|(of, _)| of == noise).map(|(_, ate)| *ate)
    }

    /// Mean over all its sequences \[m\], where it has the noise.
    pub fn mean(&self, noise: &NoiseSpec) -> Option<f64> {
        let ates: Vec<f64> =
            self.rows.iter().map(|(name, _)| self.ate(name, noise)).collect::<Option<_>>()?;
        Some(ates.iter().sum::<f64>() / ates.len() as f64)
    }

    /// Columns are `sequence` and those called `ate_NOISE_m`.
    fn read(name: &'static str, decimals: usize, text: &str) -> Self {
        let of_row = |mut cells: BTreeMap<String, String>| {
            let sequence = cells.remove("sequence").expect("the first column is the sequence");
            let ates = cells.iter().filter_map(|(column, ate)| {
                let noise = column.strip_prefix("ate_")?.strip_suffix("_m")?;
                let noise = noise.parse().expect("a column is named for a noise spec");
                Some((noise, ate.parse().expect("an error is a number")))
            });
            (sequence, ates.collect())
        };
        Self { name, decimals, rows: rows(text).into_iter().map(of_row).collect() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_built_in_tables_have_the_means_they_are_known_by() {
        let (paper, vins) = (PublishedAte::paper(), PublishedAte::vins_mono(TruthKind::Published));
        let reconciled = PublishedAte::vins_mono(TruthKind::Reconciled);
        let noise = |spec: &str| spec.parse::<NoiseSpec>().unwrap();
        // As the paper's text and the comparison give them.
        for (peer, spec, known) in [
            (&paper, "x1", 0.196),
            (&paper, "dualpronet", 0.150),
            (&vins, "x1", 0.175),
            (&vins, "x16", 0.286),
            (&reconciled, "x1", 0.153),
        ] {
            let mean = peer.mean(&noise(spec)).unwrap();
            assert!((mean - known).abs() < 6e-4 && peer.rows.len() == 11, "{spec}: {mean}");
        }
        assert_eq!(vins.ate("MH_02_easy", &noise("x16")), Some(1.56));
        assert_eq!(paper.ate("MH_02", &noise("x4")), None);
        assert_eq!(vins.ate("f01-hall-slow", &noise("x1")), None);
    }
}
