//! All cells of a sweep: sequences x seeds x noises.
//!
//! A cell is one run of the estimator. Cells are independent; what several need (a recording, its tracks, a noise track) is made by the
//! first that asks and dropped after the last, so that memory holds what is being worked on. Rows are merged in the order of cells, so
//! that one thread and many give the same bits, but for timing.

use super::cell::Cell;
use super::cell_run::run_on_tracks;
use super::consistency::write_nees;
use super::drive::frames_from;
use super::error::ClosedLoopError;
use super::judge::{RunInfo, judge, noise_rms};
use super::manifest::Manifest;
use super::recording::{Recording, Span};
use super::row::{CellKey, Row};
use super::states::write_states;
use super::store::Store;
use super::sweep_cache::{Needs, SweepCache};
use super::sweep_faults::{FailedCell, OnFault, UnseenSequences, UntrackedSequence};
use super::sweep_plan::{Sweep, nees_path, remove_files, trajectory_path};
use super::tracked::TrackedSequence;
use crate::noise::{MeanSquare, Recorded, of_recording};
use crate::parallel::each;
use dpn_core::ImuNoise;
use dpn_core::estimate::NoiseSpec;
use dpn_core::progress::Progress;
use dpn_io::{FolderLock, ResultPath, atomic_write, write_tum};
use dpn_vio::estimator::Update;
use dpn_vio::window::Window;
use std::collections::{BTreeMap, HashMap, HashSet};
use std::ops::ControlFlow;
use std::sync::atomic::AtomicBool;
use std::sync::{Arc, Mutex, PoisonError};

impl Sweep<'_> {
    /// Runs every cell whose row is not in the folder of `lock` yet; the rows of all cells, in order.
    ///
    /// # Errors
    /// Input that cannot be read or run on, the folder of another run; [`ClosedLoopError::Stopped`] when `stop` was set, after the rows
    /// of all finished cells were written.
    pub fn run(
        &self,
        lock: &FolderLock,
        manifest: &Manifest,
        stop: &AtomicBool,
        progress: &mut dyn Progress,
    ) -> Result<Vec<Row>, ClosedLoopError> {
        let cells = self.cells(manifest)?;
        self.run_in_store(lock, manifest, &cells, &OnFault::Fail, (stop, progress))
    }

    /// The same where a sequence that cannot be seen ends nothing: it has no rows, and is named with its reason.
    ///
    /// # Errors
    /// As of [`run`](Self::run), but for those sequences.
    pub fn run_what_can_be_tracked(
        &self,
        lock: &FolderLock,
        manifest: &Manifest,
        stop: &AtomicBool,
        progress: &mut dyn Progress,
    ) -> Result<(Vec<Row>, Vec<UntrackedSequence>), ClosedLoopError> {
        let found = UnseenSequences::default();
        let cells = self.cells(manifest)?;
        let on_fault = OnFault::LeaveOut(&found);
        let rows = self.run_in_store(lock, manifest, &cells, &on_fault, (stop, progress))?;
        Ok((rows, found.into_list()))
    }

    /// Runs those cells whose content is `wanted` and whose row is not in the folder of `lock` yet. A cell that cannot be run ends nothing: it is named with its reason.
    ///
    /// # Errors
    /// As of [`run`](Self::run), but for faults of cells.
    pub fn run_cells(
        &self,
        wanted: &HashSet<&str>,
        lock: &FolderLock,
        manifest: &Manifest,
        (stop, progress): (&AtomicBool, &mut dyn Progress),
    ) -> Result<Vec<FailedCell>, ClosedLoopError> {
        let (unseen, failed) = (UnseenSequences::default(), Mutex::new(Vec::new()));
        let mut cells = self.cells(manifest)?;
        cells.retain(|cell| wanted.contains(cell.content.as_str()));
        let on_fault = OnFault::Note { unseen: &unseen, failed: &failed };
        self.run_in_store(lock, manifest, &cells, &on_fault, (stop, progress))?;
        Ok(failed.into_inner().unwrap_or_else(PoisonError::into_inner))
    }

    /// How many cells are still to be run in the folder of `lock`.
    ///
    /// # Errors
    /// As of [`run`](Self::run); nothing is run.
    pub fn left(&self, lock: &FolderLock, manifest: &Manifest) -> Result<usize, ClosedLoopError> {
        let cells = self.cells(manifest)?;
        if !lock.dir().join("run.json").is_file() {
            return Ok(cells.len());
        }
        let store = Store::open(lock, manifest)?;
        Ok(cells.len() - self.kept(&cells, &store).len())
    }

    fn run_in_store(
        &self,
        lock: &FolderLock,
        manifest: &Manifest,
        // Named before anything is written: noises that cannot be had are found out by then.
        cells: &[Cell<'_>],
        on_fault: &OnFault<'_>,
        (stop, progress): (&AtomicBool, &mut dyn Progress),
    ) -> Result<Vec<Row>, ClosedLoopError> {
        let mut store = Store::open(lock, manifest)?;
        match self.fill(cells, &mut store, on_fault, (stop, progress)) {
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

    /// Rows of cells that need not be run, under the cells' own names: a row of the same content, and every file that is kept beside it.
    fn kept(&self, cells: &[Cell<'_>], store: &Store<'_>) -> BTreeMap<CellKey, Row> {
        let by_content: HashMap<&str, &Row> =
            store.rows().iter().map(|row| (row.cell.as_str(), row)).collect();
        let mut kept = BTreeMap::new();
        for cell in cells {
            let Some(&row) = by_content.get(cell.content.as_str()) else { continue };
            // A noise track may have moved: the row is right, and the files of its cell have the old name.
            if !self.keep.lacks(store.dir(), &cell.key, row, row.key() == cell.key) {
                kept.insert(cell.key.clone(), Row { noise: cell.noise.clone(), ..row.clone() });
            }
        }
        kept
    }

    /// Takes the rows of cells that another command ran with the same cache, where no file belongs beside them.
    fn take_from_cache(
        &self,
        cells: &[Cell<'_>],
        rows: &mut BTreeMap<CellKey, Row>,
        store: &mut Store<'_>,
    ) -> Result<(), ClosedLoopError> {
        let Some(cache) = self.cache else { return Ok(()) };
        for cell in cells.iter().filter(|cell| !rows.contains_key(&cell.key)).collect::<Vec<_>>() {
            let enough = |row: &Row| !self.keep.lacks(store.dir(), &cell.key, row, false);
            let Some(row) = cache.row(&cell.content, enough) else { continue };
            let row = Row { noise: cell.noise.clone(), ..row };
            store.append(&row)?;
            rows.insert(cell.key.clone(), row);
        }
        Ok(())
    }

    /// Rows of cells that are another's now go, and then the files beside them: at no time does a file of one content lie beside a row of another.
    fn forget_stale(
        &self,
        cells: &[Cell<'_>],
        kept: &BTreeMap<CellKey, Row>,
        store: &mut Store<'_>,
    ) -> Result<(), ClosedLoopError> {
        let contents: HashMap<&CellKey, &str> =
            cells.iter().map(|cell| (&cell.key, cell.content.as_str())).collect();
        store.forget(|row| contents.get(&row.key()).is_some_and(|content| **content != row.cell))?;
        // What is run clears its own; what is kept from under another name has no files, and its name may have some.
        let own: HashSet<CellKey> = store.rows().iter().map(Row::key).collect();
        for key in kept.keys().filter(|key| !own.contains(key)) {
            remove_files(store.dir(), key)?;
        }
        Ok(())
    }

    /// Runs every cell that `store` has no row of.
    fn fill(
        &self,
        cells: &[Cell<'_>],
        store: &mut Store<'_>,
        on_fault: &OnFault<'_>,
        (stop, progress): (&AtomicBool, &mut dyn Progress),
    ) -> Result<Vec<Row>, ClosedLoopError> {
        let mut rows = self.kept(cells, store);
        self.forget_stale(cells, &rows, store)?;
        let (total, kept) = (cells.len(), rows.len());
        self.take_from_cache(cells, &mut rows, store)?;
        let todo: Vec<&Cell> = cells.iter().filter(|cell| !rows.contains_key(&cell.key)).collect();
        let todo = self.ahead(todo);
        let means = self.training_means(&todo, on_fault, stop)?;
        let needs: Vec<Needs> = todo.iter().map(|cell| self.needs(cell)).collect();
        let cache = SweepCache::new(&needs, means);
        progress.start("closed loop", total as u64);
        let there = rows.len();
        let mut done = there;
        let dir = store.dir().clone();
        let finished = each(
            self.threads,
            todo.len(),
            stop,
            |i| {
                let row = self.cell(todo[i], &needs[i], &cache, (&dir, stop), on_fault);
                cache.done(&needs[i]);
                row.or_else(|error| on_fault.of_cell(todo[i], error).map(|()| None))
            },
            |_, row| {
                let Some(row) = row else { return Ok(()) };
                store.append(row)?;
                if let Some(cache) = self.cache {
                    cache.keep_row(row);
                }
                done += 1;
                progress.step(done as u64, &note(row));
                Ok(())
            },
        )?;
        for row in finished.into_iter().flatten().flatten() {
            rows.insert(row.key(), row);
        }
        let seen = || cells.iter().filter(|cell| !on_fault.leaves_out(cell));
        let total = seen().count();
        let ordered: Vec<Row> = seen().filter_map(|cell| rows.remove(&cell.key)).collect();
        if ordered.len() < total {
            progress.finish(&format!("stopped after {} of {total} cells", ordered.len()));
            return Err(ClosedLoopError::Stopped { done: ordered.len(), total });
        }
        let reused = match kept {
            0 => String::new(),
            kept => format!(": {kept} kept from {}, {} run", dir.display(), done - there),
        };
        progress.finish(&format!("{total} cells{reused}"));
        Ok(ordered)
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
            recording: seeded(self.samples_are_seeded()),
            frames: seeded(self.source.tracks_are_seeded()),
            noise: cell.noise.source().to_string(),
        }
    }

    /// The part of a recording that is run.
    fn span(&self, recording: &Recording) -> Span {
        Span { from_s: self.from.seconds(&recording.name), to_s: self.to }
    }

    /// The recording of a cell, with what is added to it.
    fn recording(&self, place: usize, seed: u64) -> Result<Recording, ClosedLoopError> {
        let mut recording = self.source.recording(place, seed)?;
        if let Some(injection) = &self.injection {
            let (imu, oracle) = injection.apply(&recording.imu, seed);
            (recording.imu, recording.oracle) = (imu, Some(oracle));
        }
        Ok(recording)
    }

    /// One row; none where the sequence cannot be seen and that ends nothing.
    fn cell(
        &self,
        cell: &Cell<'_>,
        needs: &Needs,
        cache: &SweepCache,
        (dir, stop): (&ResultPath, &AtomicBool),
        on_fault: &OnFault<'_>,
    ) -> Result<Option<Row>, ClosedLoopError> {
        if on_fault.passes_over(cell) {
            return Ok(None);
        }
        let (recording, seen) = match self.inputs(cell, needs, cache, stop) {
            Ok(found) => found,
            Err(error) => return on_fault.unseen(cell, error).map(|()| None),
        };
        remove_files(dir, &cell.key)?;
        let sources = cache.sources(needs, recorded(&recording), self.networks);
        let mut watch = |_: &Update, _: &Window| ControlFlow::Continue(());
        let (output, noise) =
            run_on_tracks(&self.estimator, &recording, &seen, cell.noise, &sources, cell.seed, &mut watch)?;
        let info = RunInfo {
            front_end: seen.images.as_ref().map(|images| images.figures.clone()),
            ..RunInfo::new(self.source, cell.noise, cell.seed, &self.span(&recording))
        };
        if let Some(path) = self.keep.states_path(dir, &cell.key) {
            atomic_write(&path, |out| write_states(&output, &noise, out))?;
        }
        if self.keep.trajectories {
            write_tum(trajectory_path(dir, &cell.key), &output.poses())?;
        }
        let judged = judge(&recording, &info, &output)?;
        if let Some(nees) = judged.nees.as_ref().filter(|_| self.keep.nees) {
            write_nees(&nees_path(dir, &cell.key), nees)?;
        }
        Ok(Some(Row {
            cell: cell.content.clone(),
            noise_rms: Some(noise_rms(&noise)),
            noise_doubts: dpn_noise::doubts(cell.noise, &recording.imu, &noise),
            ..judged.row
        }))
    }

    /// What a cell's odometry is given: the recording, and tracks enough.
    fn inputs(
        &self,
        cell: &Cell<'_>,
        needs: &Needs,
        cache: &SweepCache,
        stop: &AtomicBool,
    ) -> Result<(Arc<Recording>, Arc<TrackedSequence>), ClosedLoopError> {
        let recording = cache.recording(needs, || self.recording(cell.place, cell.seed))?;
        let span = self.span(&recording);
        let follow = || {
            let camera = self.source.camera_input(cell.place, cell.seed, &span)?;
            camera.tracks(&recording, &self.estimator.front_end, cell.seed)
        };
        let seen = cache.frames(needs, || match self.cache {
            Some(folder) if self.source.tracks.has_images() => Ok(folder.get(&cell.seen, stop, follow)?.0),
            _ => follow(),
        })?;
        frames_from(&recording, &seen.frames, &seen.span)?;
        Ok((recording, seen))
    }

    /// What `mean-of-train` needs, over all training sequences of the source that can be read, whether they are run or not.
    fn training_means(
        &self,
        todo: &[&Cell<'_>],
        on_fault: &OnFault<'_>,
        stop: &AtomicBool,
    ) -> Result<BTreeMap<String, ImuNoise>, ClosedLoopError> {
        let mut sources: Vec<&NoiseSpec> = todo
            .iter()
            .map(|cell| cell.noise)
            .filter(|noise| noise.needs_training())
            .map(NoiseSpec::source)
            .collect();
        sources.sort_by_key(ToString::to_string);
        sources.dedup();
        if sources.is_empty() {
            return Ok(BTreeMap::new());
        }
        let seed = self
            .training_seed()
            .expect("a cell that is to be run has a seed, and a noise that needs it is such a cell's");
        let training = self.training_places();
        let of_sequence = |i: usize| {
            let recording = match self.recording(training[i], seed) {
                Ok(recording) => recording,
                Err(error) => return on_fault.of_training(training[i], error).map(|()| Vec::new()),
            };
            let recorded = recorded(&recording);
            let mean = |source: &&NoiseSpec| {
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
    let ate = row.ate_se3.map_or_else(|| "no ATE".to_owned(), |ate| format!("{ate:.4} m"));
    format!("{} {} seed {}: {ate}", row.sequence, row.noise, row.seed)
}

fn recorded(recording: &Recording) -> Recorded<'_> {
    Recorded { name: &recording.name, imu: &recording.imu, oracle: recording.oracle.as_ref() }
}
