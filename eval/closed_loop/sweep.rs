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
use super::sight::Seen;
use super::source::Source;
use super::states::write_states;
use super::store::{Manifest, Store};
use crate::injected::Injection;
use crate::noise::{MeanSquare, Recorded, of_recording};
use dpn_core::estimate::Noise;
use dpn_core::progress::Progress;
use dpn_core::random::Stream;
use dpn_core::{ImuNoise, Sensor};
use dpn_io::{atomic_write, write_tum};
use dpn_pronet::network::Network;
use dpn_train::split::Side;
use dpn_vio::EstimatorConfig;
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;
use std::sync::{Arc, Mutex, PoisonError};

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
    /// More noises, and the seeds of these.
    pub others: (Vec<Noise>, Vec<u64>),
    /// Where in a sequence a run begins.
    pub from: StartAt,
    /// Seconds after a sequence's first frame (or image listed) at which its run ends; without it at the last.
    pub to: Option<f64>,
    /// The estimator's settings.
    pub estimator: EstimatorConfig,
    /// Networks that noises may name.
    pub networks: &'a [Network],
    /// Threads to use.
    pub threads: usize,
    /// What is kept of a cell beside its row.
    pub keep: Keep,
    /// What is added to every recording's samples, from the seed of the cell.
    pub injection: Option<Injection>,
}

/// What is kept of cells beside their rows, each a file a cell.
#[derive(Debug, Clone, Default)]
pub struct Keep {
    /// Whether every cell's trajectory is written: `trajectories/CELL.tum`.
    pub trajectories: bool,
    /// Whether every cell's NEES is, where the estimator gives covariances: `nees/CELL.csv`.
    pub nees: bool,
    /// Whose states are: cells of one of these noises and this seed, `states/CELL.csv`. Such a cell is run again where the file is gone.
    pub states: Option<(Vec<Noise>, u64)>,
}

impl Keep {
    /// Where the states of a cell are, if they are kept.
    pub fn states_path(&self, dir: &Path, key: &CellKey) -> Option<PathBuf> {
        let (noises, seed) = self.states.as_ref()?;
        let wanted = key.seed == *seed && noises.iter().any(|noise| noise.to_string() == key.noise);
        wanted.then(|| dir.join("states").join(key.file_name("csv")))
    }
}

/// A sequence that nothing could be seen of.
#[derive(Debug)]
pub struct Unseen {
    /// Its place in the source.
    pub place: usize,
    /// Why: its files, tracks or images cannot be had, or not enough of them.
    pub error: ClosedLoopError,
}

/// What becomes of the others when one sequence cannot be seen.
enum Blind<'a> {
    /// Nothing: that is an error.
    Ends,
    /// They go on; the first error of each such sequence is kept here.
    IsLeftOut(&'a Mutex<BTreeMap<usize, ClosedLoopError>>),
}

impl Blind<'_> {
    /// Whether a sequence is known to be one.
    fn knows(&self, place: usize) -> bool {
        match self {
            Self::Ends => false,
            Self::IsLeftOut(found) => {
                found.lock().unwrap_or_else(PoisonError::into_inner).contains_key(&place)
            }
        }
    }

    /// An error of seeing a sequence: given back, or kept.
    fn hears(&self, place: usize, error: ClosedLoopError) -> Result<(), ClosedLoopError> {
        match self {
            Self::Ends => Err(error),
            Self::IsLeftOut(found) => {
                found.lock().unwrap_or_else(PoisonError::into_inner).entry(place).or_insert(error);
                Ok(())
            }
        }
    }
}

/// One run of the estimator.
struct Cell<'a> {
    place: usize,
    seed: u64,
    noise: &'a Noise,
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
        self.run_in_store(dir, manifest, &Blind::Ends, stop, progress)
    }

    /// The same where a sequence that cannot be seen ends nothing: it has no rows, and is named with its reason.
    ///
    /// # Errors
    /// As of [`run`](Self::run), but for those sequences.
    pub fn run_what_is_seen(
        &self,
        dir: &Path,
        manifest: &Manifest,
        stop: &AtomicBool,
        progress: &mut dyn Progress,
    ) -> Result<(Vec<Row>, Vec<Unseen>), ClosedLoopError> {
        let found = Mutex::new(BTreeMap::new());
        let rows = self.run_in_store(dir, manifest, &Blind::IsLeftOut(&found), stop, progress)?;
        let found = found.into_inner().unwrap_or_else(PoisonError::into_inner);
        Ok((rows, found.into_iter().map(|(place, error)| Unseen { place, error }).collect()))
    }

    /// How many cells have no row in `dir` yet.
    ///
    /// # Errors
    /// As of [`run`](Self::run); nothing is run.
    pub fn left(&self, dir: &Path, manifest: &Manifest) -> Result<usize, ClosedLoopError> {
        let cells = self.cells();
        if !dir.join("run.json").is_file() {
            return Ok(cells.len());
        }
        let rows = Store::open(dir, manifest)?.rows();
        Ok(cells.iter().filter(|cell| !rows.contains_key(&cell.key)).count())
    }

    fn run_in_store(
        &self,
        dir: &Path,
        manifest: &Manifest,
        blind: &Blind<'_>,
        stop: &AtomicBool,
        progress: &mut dyn Progress,
    ) -> Result<Vec<Row>, ClosedLoopError> {
        let mut store = Store::open(dir, manifest)?;
        match self.fill(&mut store, dir, blind, stop, progress) {
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
        blind: &Blind<'_>,
        stop: &AtomicBool,
        progress: &mut dyn Progress,
    ) -> Result<Vec<Row>, ClosedLoopError> {
        let mut rows = store.rows();
        let cells = self.cells();
        let total = cells.len();
        let gone = |key: &CellKey| self.keep.states_path(dir, key).is_some_and(|path| !path.is_file());
        let todo: Vec<&Cell> =
            cells.iter().filter(|cell| !rows.contains_key(&cell.key) || gone(&cell.key)).collect();
        let todo = self.ahead(todo);
        let means = self.training_means(&todo, blind, stop)?;
        let needs: Vec<Needs> = todo.iter().map(|cell| self.needs(cell)).collect();
        let kept = Kept::new(&needs, means);
        progress.start("closed loop", total as u64);
        let mut done = total - todo.len();
        let finished = each(
            self.threads,
            todo.len(),
            stop,
            |i| {
                let row = self.cell(todo[i], &needs[i], &kept, dir, blind);
                kept.done(&needs[i]);
                row
            },
            |_, row| {
                let Some(row) = row else { return Ok(()) };
                store.append(row)?;
                done += 1;
                progress.step(done as u64, &note(row));
                Ok(())
            },
        )?;
        for row in finished.into_iter().flatten().flatten() {
            rows.insert(row.key(), row);
        }
        let seen = || cells.iter().filter(|cell| !blind.knows(cell.place));
        let total = seen().count();
        let ordered: Vec<Row> = seen().filter_map(|cell| rows.remove(&cell.key)).collect();
        if ordered.len() < total {
            progress.finish(&format!("stopped after {} of {total} cells", ordered.len()));
            return Err(ClosedLoopError::Stopped { done: ordered.len(), total });
        }
        progress.finish(&format!("{total} cells"));
        Ok(ordered)
    }

    /// All cells: noises of one seed of one sequence follow each other, for they share the most.
    fn cells(&self) -> Vec<Cell<'_>> {
        let names = self.source.names();
        let (others, other_seeds) = &self.others;
        let parts = [(&self.noises, &self.seeds), (others, other_seeds)];
        let seeds: BTreeSet<u64> = self.seeds.iter().chain(other_seeds).copied().collect();
        let mut cells = Vec::new();
        for &place in &self.places {
            for &seed in &seeds {
                for (noises, _) in parts.iter().filter(|(_, seeds)| seeds.contains(&seed)) {
                    for noise in *noises {
                        let key =
                            CellKey { sequence: names[place].0.clone(), seed, noise: noise.to_string() };
                        cells.push(Cell { place, seed, noise, key });
                    }
                }
            }
        }
        cells
    }

    /// Cells in the order in which they are begun. What the cells of a sequence and seed share is made by the first of them while the others
    /// wait, so as many such firsts as there are threads are always begun ahead of the rest. Seeds come one after another: what is broken off has
    /// whole seeds.
    fn ahead<'c>(&self, mut cells: Vec<&'c Cell<'c>>) -> Vec<&'c Cell<'c>> {
        let place = |cell: &Cell<'_>| self.places.iter().position(|place| *place == cell.place);
        cells.sort_by_key(|cell| (cell.seed, place(cell)));
        let groups: Vec<&[&Cell<'_>]> =
            cells.chunk_by(|a, b| (a.seed, a.place) == (b.seed, b.place)).collect();
        let first = |i: usize| groups.get(i).map(|group| group[0]);
        let threads = self.threads.max(1);
        let mut ordered: Vec<&Cell<'_>> = (0..threads).filter_map(first).collect();
        for (i, group) in groups.iter().enumerate() {
            ordered.extend(&group[1..]);
            ordered.extend(first(i + threads));
        }
        ordered
    }

    fn needs(&self, cell: &Cell<'_>) -> Needs {
        let seeded = |seeded: bool| (cell.place, if seeded { cell.seed } else { 0 });
        Needs {
            recording: seeded(self.source.recordings_are_seeded() || self.injection.is_some()),
            frames: seeded(self.source.tracks_are_seeded()),
            noise: cell.noise.source().to_string(),
        }
    }

    /// The recording of a cell, with what is added to it.
    fn recording(&self, place: usize, seed: u64) -> Result<Recording, ClosedLoopError> {
        let mut recording = self.source.recording(place, seed)?;
        if let Some(injection) = &self.injection {
            let (imu, oracle) = injection.apply(&recording.name, &recording.imu, seed);
            (recording.imu, recording.oracle) = (imu, Some(oracle));
        }
        Ok(recording)
    }

    /// One row; none where the sequence cannot be seen and that ends nothing.
    fn cell(
        &self,
        cell: &Cell<'_>,
        needs: &Needs,
        kept: &Kept,
        dir: &Path,
        blind: &Blind<'_>,
    ) -> Result<Option<Row>, ClosedLoopError> {
        if blind.knows(cell.place) {
            return Ok(None);
        }
        let (recording, seen) = match self.see(cell, needs, kept) {
            Ok(found) => found,
            Err(error) => return blind.hears(cell.place, error).map(|()| None),
        };
        let from_s = self.from.seconds(&recording.name);
        let frames = seen.span.of(&seen.frames, |frame| frame.t);
        let stream = Stream::new(cell.seed).named("noise").named(&recording.name);
        let sources = kept.sources(needs, recorded(&recording), self.networks);
        let noise = crate::noise::track(cell.noise, &recording.imu, &sources, &stream)?;
        let driven = drive(&self.estimator, &recording, frames, &noise, cell.seed)?;
        let told = Told {
            camera: self.source.camera().into(),
            noise: cell.noise.clone(),
            seed: cell.seed,
            from_s,
            front_end: seen.sight.as_ref().map(|sight| sight.figures.clone()),
        };
        if let Some(path) = self.keep.states_path(dir, &cell.key) {
            atomic_write(&path, |out| write_states(&driven, &noise, out))?;
        }
        if self.keep.trajectories {
            write_tum(&dir.join("trajectories").join(cell.key.file_name("tum")), &driven.poses())?;
        }
        let judged = judge(&recording, &told, &driven)?;
        if let Some(nees) = judged.nees.as_ref().filter(|_| self.keep.nees) {
            write_nees(&nees_path(dir, &cell.key), nees)?;
        }
        let mut told = MeanSquare::default();
        told.add(&noise);
        let noise_rms = told.root().map(|noise| Sensor::ALL.map(|sensor| noise.of(sensor)));
        Ok(Some(Row { noise_rms, ..judged.row }))
    }

    /// What a cell's odometry is given: the recording, and tracks enough.
    fn see(
        &self,
        cell: &Cell<'_>,
        needs: &Needs,
        kept: &Kept,
    ) -> Result<(Arc<Recording>, Arc<Seen>), ClosedLoopError> {
        let recording = kept.recording(needs, || self.recording(cell.place, cell.seed))?;
        let span = Span { from_s: self.from.seconds(&recording.name), to_s: self.to };
        let seen = kept
            .frames(needs, || self.source.seen(cell.place, cell.seed, &span, &recording, &mut |_, _| {}))?;
        frames_from(&recording, &seen.frames, &seen.span)?;
        Ok((recording, seen))
    }

    /// What `mean-of-train` needs, over all training sequences of the source that can be read, whether they are run or not.
    fn training_means(
        &self,
        todo: &[&Cell<'_>],
        blind: &Blind<'_>,
        stop: &AtomicBool,
    ) -> Result<BTreeMap<String, ImuNoise>, ClosedLoopError> {
        let mut sources: Vec<&Noise> = todo
            .iter()
            .map(|cell| cell.noise)
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
        let seed = self.seeds.first().or(self.others.1.first()).copied().unwrap_or(0);
        let of_sequence = |i: usize| {
            let recording = match self.recording(training[i], seed) {
                Ok(recording) => recording,
                Err(error) => return blind.hears(training[i], error).map(|()| Vec::new()),
            };
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
