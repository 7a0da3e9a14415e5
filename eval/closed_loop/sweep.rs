//! All cells of a sweep: sequences x seeds x noises.
//!
//! A cell is one run of the estimator. Cells are independent; what several need (a recording, its tracks, a noise track) is made by the
//! first that asks and dropped after the last, so that memory holds what is being worked on. Rows are merged in the order of cells, so
//! that one thread and many give the same bits, but for timing.

use super::consistency::{nees_path, write_nees};
use super::drive::{drive, frames_from};
use super::error::ClosedLoopError;
use super::judge::{Told, judge};
use super::kept::{Kept, Needs};
use super::parallel::each;
use super::recording::{Recording, Span, StartAt};
use super::row::{CellKey, Row};
use super::source::Source;
use super::store::{Manifest, Store};
use crate::noise::{MeanSquare, Noise, Recorded, of_recording};
use crate::open_loop::Network;
use dpn_core::ImuNoise;
use dpn_core::io::write_tum;
use dpn_core::progress::Progress;
use dpn_core::random::Stream;
use dpn_train::split::Side;
use dpn_vio::EstimatorConfig;
use std::collections::BTreeMap;
use std::path::Path;
use std::sync::atomic::AtomicBool;

/// What to run.
#[derive(Debug, Clone)]
pub struct Sweep<'a> {
    /// Where sequences come from.
    pub source: &'a Source,
    /// Places of the sequences to run, as [`Source::select`] gives them.
    pub places: Vec<usize>,
    /// The noises.
    pub noises: Vec<Noise>,
    /// The seeds.
    pub seeds: Vec<u64>,
    /// Where in a sequence a run begins.
    pub from: StartAt,
    /// The estimator's settings.
    pub estimator: EstimatorConfig,
    /// Networks that noises may name.
    pub networks: &'a [Network],
    /// Threads to use.
    pub threads: usize,
    /// Whether every cell's trajectory is written.
    pub trajectories: bool,
}

/// One run of the estimator.
struct Cell {
    place: usize,
    seed: u64,
    noise: usize,
    key: CellKey,
}

impl Sweep<'_> {
    /// Runs every cell whose row is not in `dir` yet; the rows of all cells, in order.
    ///
    /// # Errors
    /// Input that cannot be read or run on, the folder of another run; [`ClosedLoopError::Stopped`] when `stop` was set, after the rows
    /// of all finished cells were written.
    pub fn run(
        &self,
        dir: &Path,
        manifest: &Manifest,
        stop: &AtomicBool,
        progress: &mut dyn Progress,
    ) -> Result<Vec<Row>, ClosedLoopError> {
        let mut store = Store::open(dir, manifest)?;
        match self.fill(&mut store, dir, stop, progress) {
            Ok(ordered) => {
                store.finish(&ordered)?;
                Ok(ordered)
            }
            Err(error) => {
                store.abandon();
                Err(error)
            }
        }
    }

    /// Runs every cell that `store` has no row of.
    fn fill(
        &self,
        store: &mut Store,
        dir: &Path,
        stop: &AtomicBool,
        progress: &mut dyn Progress,
    ) -> Result<Vec<Row>, ClosedLoopError> {
        let mut rows = store.rows();
        let cells = self.cells();
        let total = cells.len();
        let todo: Vec<&Cell> = cells.iter().filter(|cell| !rows.contains_key(&cell.key)).collect();
        let means = self.training_means(&todo, stop)?;
        let needs: Vec<Needs> = todo.iter().map(|cell| self.needs(cell)).collect();
        let kept = Kept::new(&needs, means);
        progress.start("closed loop", total as u64);
        let mut done = total - todo.len();
        let finished = each(
            self.threads,
            todo.len(),
            stop,
            |i| self.cell(todo[i], &needs[i], &kept, dir),
            |_, row| {
                store.append(row)?;
                done += 1;
                progress.step(done as u64, &note(row));
                Ok(())
            },
        )?;
        for row in finished.into_iter().flatten() {
            rows.insert(row.key(), row);
        }
        let ordered: Vec<Row> = cells.iter().filter_map(|cell| rows.remove(&cell.key)).collect();
        if ordered.len() < total {
            progress.finish(&format!("stopped after {} of {total} cells", ordered.len()));
            return Err(ClosedLoopError::Stopped { done: ordered.len(), total });
        }
        progress.finish(&format!("{total} cells"));
        Ok(ordered)
    }

    /// All cells: noises of one seed of one sequence follow each other, for they share the most.
    fn cells(&self) -> Vec<Cell> {
        let names = self.source.names();
        let specs: Vec<String> = self.noises.iter().map(ToString::to_string).collect();
        let mut cells = Vec::new();
        for &place in &self.places {
            for &seed in &self.seeds {
                for (noise, spec) in specs.iter().enumerate() {
                    let key = CellKey { sequence: names[place].0.clone(), seed, noise: spec.clone() };
                    cells.push(Cell { place, seed, noise, key });
                }
            }
        }
        cells
    }

    fn needs(&self, cell: &Cell) -> Needs {
        let seeded = |seeded: bool| (cell.place, if seeded { cell.seed } else { 0 });
        Needs {
            recording: seeded(self.source.recordings_are_seeded()),
            frames: seeded(self.source.tracks_are_seeded()),
            noise: self.noises[cell.noise].source().to_string(),
        }
    }

    fn cell(&self, cell: &Cell, needs: &Needs, kept: &Kept, dir: &Path) -> Result<Row, ClosedLoopError> {
        let recording = kept.recording(needs, || self.source.recording(cell.place, cell.seed))?;
        let from_s = self.from.seconds(&recording.name);
        let span = Span::from(from_s);
        let see = || self.source.seen(cell.place, cell.seed, &span, &recording, &mut |_, _| {});
        let seen = kept.frames(needs, see)?;
        let frames = frames_from(&recording, &seen.frames, &seen.span)?;
        let stream = Stream::new(cell.seed).named("noise").named(&recording.name);
        let sources = kept.sources(needs, recorded(&recording), self.networks);
        let noise = self.noises[cell.noise].track(&recording.imu, &sources, &stream)?;
        let driven = drive(&self.estimator, &recording, frames, &noise, cell.seed)?;
        let told = Told {
            camera: self.source.camera().into(),
            noise: cell.key.noise.clone(),
            seed: cell.seed,
            from_s,
            front_end: seen.sight.as_ref().map(|sight| sight.figures.clone()),
        };
        if self.trajectories {
            write_tum(&dir.join("trajectories").join(cell.key.file_name("tum")), &driven.poses())?;
        }
        let judged = judge(&recording, &told, &driven)?;
        if let Some(nees) = &judged.nees {
            write_nees(&nees_path(dir, &cell.key), nees)?;
        }
        kept.done(needs);
        Ok(judged.row)
    }

    /// What `mean-of-train` needs, over all training sequences of the source, whether they are run or not.
    fn training_means(
        &self,
        todo: &[&Cell],
        stop: &AtomicBool,
    ) -> Result<BTreeMap<String, ImuNoise>, ClosedLoopError> {
        let mut sources: Vec<&Noise> = todo
            .iter()
            .map(|cell| &self.noises[cell.noise])
            .filter(|noise| noise.needs_training())
            .map(Noise::source)
            .collect();
        sources.sort_by_key(ToString::to_string);
        sources.dedup();
        if sources.is_empty() {
            return Ok(BTreeMap::new());
        }
        let sides = self.source.names();
        let training: Vec<usize> = (0..sides.len()).filter(|i| sides[*i].1 == Side::Train).collect();
        let seed = self.seeds.first().copied().unwrap_or(0);
        let of_sequence = |i: usize| {
            let recording = self.source.recording(training[i], seed)?;
            let recorded = recorded(&recording);
            let mean = |source: &&Noise| {
                let mut mean = MeanSquare::default();
                mean.add(&of_recording(source, &recorded, self.networks)?);
                Ok(mean)
            };
            sources.iter().map(mean).collect::<Result<Vec<MeanSquare>, ClosedLoopError>>()
        };
        let found = each(self.threads, training.len(), stop, of_sequence, |_, _| Ok(()))?;
        let mut means = vec![MeanSquare::default(); sources.len()];
        for sequence in found.into_iter().flatten() {
            for (mean, more) in means.iter_mut().zip(&sequence) {
                mean.merge(more);
            }
        }
        let named = sources.iter().zip(&means);
        Ok(named.filter_map(|(source, mean)| Some((source.to_string(), mean.root()?))).collect())
    }
}

fn note(row: &Row) -> String {
    let ate = row.ate_se3.map_or_else(|| "no ATE".to_owned(), |ate| format!("{ate:.3} m"));
    format!("{} {} seed {}: {ate}", row.sequence, row.noise, row.seed)
}

fn recorded(recording: &Recording) -> Recorded<'_> {
    Recorded { name: &recording.name, imu: &recording.imu, oracle: recording.oracle.as_ref() }
}
