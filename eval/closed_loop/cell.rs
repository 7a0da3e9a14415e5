//! The cells of a sweep, each named by its content: whatever is run where, a row is of this cell or of another one.

use super::error::ClosedLoopError;
use super::manifest::Manifest;
use super::row::CellKey;
use super::sweep_plan::Sweep;
use crate::noise::content;
use dpn_core::checksum::of_parts;
use dpn_core::estimate::NoiseSpec;
use dpn_train::split::Side;
use std::collections::{BTreeMap, BTreeSet};

/// One run of the estimator.
#[derive(Debug)]
pub(super) struct Cell<'a> {
    /// Place of the sequence in the source.
    pub(super) place: usize,
    /// The seed.
    pub(super) seed: u64,
    /// The noise told.
    pub(super) noise: &'a NoiseSpec,
    /// What people call the cell.
    pub(super) key: CellKey,
    /// Checksum of everything that the row is a function of: program, settings, the sequence's files, seed, start, the noise by content.
    pub(super) content: String,
    /// The same of the tracks that its odometry has, where images are to be followed.
    pub(super) seen: String,
}

impl Sweep<'_> {
    /// All cells: noises of one seed of one sequence follow each other, for they share the most.
    ///
    /// # Errors
    /// Networks or files of noises that cannot be had.
    pub(super) fn cells(&self, manifest: &Manifest) -> Result<Vec<Cell<'_>>, ClosedLoopError> {
        let names = self.source.names();
        let contents = self.noise_contents()?;
        let run =
            of_parts([&manifest.program, &manifest.estimator.to_string(), &manifest.source.to_string()]);
        let front_end = serde_json::json!(self.estimator.front_end).to_string();
        let source = manifest.source.to_string();
        let tracking = of_parts([&manifest.program, &dpn_pronet::processor(), &front_end, &source]);
        let mut cells = Vec::new();
        for (place, seed, noise) in self.combinations() {
            let (name, side) = &names[place];
            let from = format!("{:?} {:?}", self.from.seconds(name), self.to);
            let of_sequence = [run.as_str(), name, &side.to_string(), &manifest.inputs[name], &from];
            let key = CellKey { sequence: name.clone(), seed, noise: noise.to_string() };
            let of_cell = [&seed.to_string(), &contents[&key.noise]];
            let seen = [&tracking, name, &manifest.inputs[name], &from, of_cell[0]];
            let seen = of_parts(seen.map(String::as_str));
            let content = of_parts(of_sequence.into_iter().chain(of_cell.map(String::as_str)));
            cells.push(Cell { place, seed, noise, key, content, seen });
        }
        Ok(cells)
    }

    /// Place, seed and noise of every cell, in the order of cells.
    fn combinations(&self) -> Vec<(usize, u64, &NoiseSpec)> {
        let parts = [(&self.noises, &self.seeds), (&self.others, &self.other_seeds)];
        let seeds: BTreeSet<u64> = self.seeds.iter().chain(&self.other_seeds).copied().collect();
        let mut all = Vec::new();
        for &place in &self.places {
            for &seed in &seeds {
                for (noises, _) in parts.iter().filter(|(_, seeds)| seeds.contains(&seed)) {
                    all.extend(noises.iter().map(|noise| (place, seed, noise)));
                }
            }
        }
        all
    }

    /// Name and content of every cell, in order.
    ///
    /// # Errors
    /// Networks or files of noises that cannot be had.
    pub fn named_cells(&self, manifest: &Manifest) -> Result<Vec<(CellKey, String)>, ClosedLoopError> {
        Ok(self.cells(manifest)?.into_iter().map(|cell| (cell.key, cell.content)).collect())
    }

    /// The same sweep with those sequences alone that `wanted` takes a cell of, cells counted in order: what else is in their files is not read.
    #[must_use]
    pub fn of_sequences_with(&self, wanted: impl Fn(usize) -> bool) -> Self {
        let of_cells = self.combinations().into_iter().enumerate().filter(|(i, _)| wanted(*i));
        let needed: BTreeSet<usize> = of_cells.map(|(_, (place, ..))| place).collect();
        let places = self.places.iter().copied().filter(|place| needed.contains(place)).collect();
        Self { places, ..self.clone() }
    }

    /// All noises, those with seeds of their own last.
    pub fn every_noise(&self) -> impl Iterator<Item = &NoiseSpec> {
        self.noises.iter().chain(&self.others)
    }

    /// What every noise is a function of, by its spec; a mean over the training sequences, of what these are.
    fn noise_contents(&self) -> Result<BTreeMap<String, String>, ClosedLoopError> {
        let trained_on = self.every_noise().any(NoiseSpec::needs_training).then(|| self.training_content());
        let of = |noise: &NoiseSpec| {
            let content = content(noise, self.networks)?;
            Ok((
                noise.to_string(),
                match &trained_on {
                    Some(sequences) if noise.needs_training() => of_parts([&content, sequences]),
                    _ => content,
                },
            ))
        };
        self.every_noise().map(of).collect()
    }

    /// Seed of the training sequences that a mean is taken over: one for all cells, the first that is run.
    /// None of a sweep without seeds, which has no cells.
    pub(crate) fn training_seed(&self) -> Option<u64> {
        self.seeds.first().or(self.other_seeds.first()).copied()
    }

    /// Whether a sequence's samples depend on the seed.
    pub(super) fn samples_are_seeded(&self) -> bool {
        self.source.recordings_are_seeded() || self.injection.is_some()
    }

    /// Places of all training sequences of the source, whether they are run or not.
    pub(super) fn training_places(&self) -> Vec<usize> {
        let sides = self.source.names();
        (0..sides.len()).filter(|i| sides[*i].1 == Side::Train).collect()
    }

    /// What a mean over the training sequences is a function of, besides the noise. A sequence that cannot be read has no part in the mean.
    fn training_content(&self) -> String {
        let names = self.source.names();
        let mut parts = Vec::new();
        for place in self.training_places() {
            parts.push(names[place].0.clone());
            parts.push(self.source.checksum_of_samples(place));
        }
        if self.samples_are_seeded() {
            parts.extend(self.training_seed().map(|seed| seed.to_string()));
        }
        of_parts(parts)
    }
}

#[cfg(test)]
mod tests {
    use super::super::recording::StartAt;
    use super::super::sequence_set::{SequenceSet, TrackSource};
    use super::super::sweep_plan::CellFiles;
    use super::*;
    use dpn_sim::FlightConfig;
    use dpn_sim::tracks::TracksConfig;
    use dpn_vio::EstimatorConfig;

    fn flights() -> SequenceSet {
        SequenceSet::flights(FlightConfig::default(), TrackSource::Simulated(TracksConfig::default()))
    }

    fn sweep<'a>(source: &'a SequenceSet, noises: &[&str], seeds: &[u64]) -> Sweep<'a> {
        Sweep {
            source,
            places: vec![6, 7],
            noises: noises.iter().map(|noise| noise.parse().unwrap()).collect(),
            seeds: seeds.to_vec(),
            others: Vec::new(),
            other_seeds: Vec::new(),
            from: StartAt::Seconds(50.0),
            to: None,
            estimator: EstimatorConfig::default(),
            networks: &[],
            threads: 1,
            cache: None,
            keep: CellFiles::default(),
            injection: None,
        }
    }

    fn contents(sweep: &Sweep<'_>, program: &str) -> Vec<String> {
        let manifest = Manifest::of(sweep, program.into()).unwrap();
        sweep.cells(&manifest).unwrap().into_iter().map(|cell| cell.content).collect()
    }

    #[test]
    fn a_cell_is_named_by_all_that_its_row_depends_on_and_by_nothing_else() {
        let source = flights();
        let base = sweep(&source, &["x4", "diff2"], &[0, 1]);
        let first = contents(&base, "dpn 1");
        assert_eq!(first.iter().collect::<BTreeSet<_>>().len(), 8);
        // More cells, other threads, other files kept: the same names.
        let keep = CellFiles { trajectories: true, ..CellFiles::default() };
        let more = Sweep { threads: 7, keep, ..sweep(&source, &["x4", "x8", "diff2"], &[0, 1, 2]) };
        let more = contents(&more, "dpn 1");
        assert!(first.iter().all(|content| more.contains(content)));
        let mut estimator = EstimatorConfig::default();
        estimator.window.key_frames = 8;
        let other = |sweep: &Sweep<'_>, program| contents(sweep, program).iter().all(|c| !first.contains(c));
        assert!(other(&base, "dpn 2"));
        assert!(other(&Sweep { estimator, ..base.clone() }, "dpn 1"));
        assert!(other(&Sweep { to: Some(60.0), ..base.clone() }, "dpn 1"));
        assert!(other(&Sweep { from: StartAt::Table, ..base.clone() }, "dpn 1"));
        assert!(other(&Sweep { seeds: vec![5], ..base.clone() }, "dpn 1"));
        assert!(other(
            &Sweep { injection: Some(crate::injected::Injection::default()), ..base.clone() },
            "dpn 1"
        ));
        let mut quiet = FlightConfig::default();
        quiet.vibration.scale = 0.0;
        let quiet = SequenceSet::flights(quiet, source.tracks.clone());
        assert!(other(&Sweep { source: &quiet, ..base.clone() }, "dpn 1"));
    }

    #[test]
    fn a_mean_over_the_training_sequences_is_named_by_the_seed_it_was_made_with() {
        let source = flights();
        let of = |seeds: &[u64]| contents(&sweep(&source, &["mean-of-train(diff2)", "x4"], seeds), "dpn 1");
        let (first, later) = (of(&[0, 1]), of(&[1, 0]));
        // Cells of seeds 0 and 1 in order: the constant's are the same, those of the mean are not.
        assert_eq!((&first[1], &first[3]), (&later[1], &later[3]));
        assert!(first[0] != later[0] && first[2] != later[2]);
    }

    #[test]
    fn a_changed_image_of_the_same_length_is_another_cell_and_an_image_more_is() {
        let dir = tempfile::tempdir().unwrap();
        let excerpt = dpn_testing::repository().join("tests/data/euroc/V1_01_easy");
        for (name, bytes) in dpn_testing::files(&excerpt) {
            let to = dir.path().join(name);
            std::fs::create_dir_all(to.parent().unwrap()).unwrap();
            std::fs::write(to, bytes).unwrap();
        }
        let images = TrackSource::Images { skip_missing: true };
        let source = SequenceSet::one(dir.path(), images).unwrap();
        let sequence = &source.recordings(&[0])[0];
        let frames = sequence.camera_frames().unwrap();
        let [first, second] = [0, 1].map(|i| sequence.image_path(&frames[i]));
        std::fs::create_dir_all(first.parent().unwrap()).unwrap();
        let of = || contents(&Sweep { places: vec![0], ..sweep(&source, &["x4"], &[0]) }, "dpn 1");
        let mut seen = vec![of()];
        for (path, bytes) in [(&first, "picture"), (&first, "pictuRe"), (&second, ""), (&second, "picture")] {
            std::fs::write(path, bytes).unwrap();
            let now = of();
            assert!(!seen.contains(&now), "{path:?} with {bytes}");
            seen.push(now);
        }
        std::fs::remove_file(&second).unwrap();
        assert_eq!(of(), seen[2]);
    }
}
