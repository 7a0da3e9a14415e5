//! One shard, worked off in its own folder.
//!
//! The folder is that of an ordinary run with fewer cells (of several where a sweep has several jobs), with the shard's account beside it: `shard.json`,
//! `failed.jsonl` and, while it is worked on, `running.json`. Whoever runs it again finds damage by the account and makes what is
//! damaged anew.

use super::beat::{Heart, node};
use super::error::SweepError;
use super::manifest::SweepFolder;
use super::record::{ShardRecord, cells_with_rows};
use super::shard_files::{FAILED, ROWS, TRUTH};
use super::spec::{JobSpec, TrainSpec};
use crate::closed_loop::{Experiment, FailedCell, Manifest, Sweep, TrackCache};
use dpn_core::progress::Progress;
use dpn_io::{FolderLock, IoError, ResultPath, write_file};
use dpn_pronet::network::Network;
use serde::{Deserialize, Serialize};
use std::collections::{BTreeMap, HashMap, HashSet};
use std::fs::File;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};

/// What a shard is run with on this machine.
#[derive(Debug)]
pub struct Node<'a> {
    /// Version and checksum of the program.
    pub program: String,
    /// The kind of processor.
    pub processor: String,
    /// Folder of the data, where it is not where the plan has it.
    pub data: Option<&'a Path>,
    /// Folder of given tracks, where it is not where the plan has it.
    pub tracks: Option<&'a Path>,
    /// Folder of reconciled ground truth, where it is not where the plan has it.
    pub truth: Option<&'a Path>,
    /// The networks.
    pub networks: &'a [Network],
    /// Threads to use.
    pub threads: usize,
    /// Where tracks that were followed through images are kept, for all shards and nodes.
    pub cache: Option<&'a TrackCache>,
}

impl Node<'_> {
    /// The experiment with its folders where they are here; `planned` is the folder of the data in the plan, `truth` that of the sweep's own reconciled truth.
    fn finds(&self, experiment: &Experiment, planned: Option<&Path>, truth: &Path) -> Experiment {
        let moved =
            |own: &PathBuf| match (self.data, planned.and_then(|planned| own.strip_prefix(planned).ok())) {
                (Some(here), Some(below)) if below.as_os_str().is_empty() => here.to_path_buf(),
                (Some(here), Some(below)) => here.join(below),
                _ => own.clone(),
            };
        let in_place_of = |own: &Option<PathBuf>, here: Option<&Path>| {
            own.as_ref().map(|own| here.map_or_else(|| own.clone(), Path::to_path_buf))
        };
        Experiment {
            data: experiment.data.as_ref().map(moved),
            tracks: in_place_of(&experiment.tracks, self.tracks),
            truth: in_place_of(&experiment.truth, self.truth.or(truth.is_dir().then_some(truth))),
            ..experiment.clone()
        }
    }
}

/// Why a training has no result.
#[derive(Debug)]
pub enum TrainFault {
    /// It was stopped.
    Stopped,
    /// Something is wrong, in words.
    Failed(String),
}

/// Trains networks; the library that does is none of this crate's.
pub trait Trainer {
    /// Checksum of everything that the training is a function of.
    ///
    /// # Errors
    /// Data that cannot be read.
    fn content(&mut self, spec: &TrainSpec) -> Result<String, SweepError>;

    /// Trains in `dir`, going on with what is there; the row of its result.
    ///
    /// # Errors
    /// A stop; whatever is wrong.
    fn train(
        &mut self,
        spec: &TrainSpec,
        dir: &ResultPath,
        with: (&AtomicBool, &mut dyn Progress),
    ) -> Result<serde_json::Map<String, serde_json::Value>, TrainFault>;
}

/// From here on this thread does alone what it would spread over all threads: networks side by side, one a core, wait for nobody and take a seventh less time.
pub fn by_itself() {
    // A thread that is a pool's already stays there.
    let _ = rayon::ThreadPoolBuilder::new().num_threads(1).use_current_thread().build();
}

/// What a shard came to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ShardOutcome {
    /// Its cells.
    pub cells: usize,
    /// Whether they were all there before.
    pub was_there: bool,
}

/// A line of `failed.jsonl`.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FailedLine {
    /// Checksum of the cell.
    pub cell: String,
    /// What people call it.
    pub label: String,
    /// Why it could not be run.
    pub reason: String,
}

/// Works off a shard as far as that was not done before.
///
/// # Errors
/// Another program, processor or input than planned; a shard that another process works on; cells that failed, the others being done; a stop.
pub fn run_shard(
    folder: &SweepFolder,
    number: usize,
    here: &Node<'_>,
    trainer: &mut dyn Trainer,
    stop: &AtomicBool,
    progress: &mut dyn Progress,
) -> Result<ShardOutcome, SweepError> {
    let manifest = &folder.manifest;
    if number >= folder.shards() {
        return Err(SweepError::NoShard { shard: number, shards: folder.shards() });
    }
    let pairs =
        [("program", &manifest.program, &here.program), ("processor", &manifest.processor, &here.processor)];
    if let Some((key, planned, here)) = pairs.into_iter().find(|(_, planned, here)| planned != here) {
        return Err(differs(key, planned, here));
    }
    let mut shard = Shard::open(folder, number)?;
    let cells = folder.cells_of_shard(number).count();
    if shard.record.done && shard.whole && shard.record.failed == 0 {
        return Ok(ShardOutcome { cells, was_there: true });
    }
    let result = shard.run(here, trainer, stop, progress);
    shard.note_failed()?;
    match result {
        Err(error) if error.is_stop() => {
            let done = shard.rows_there()?.len();
            Err(SweepError::Stopped { done, total: cells })
        }
        other => other.and_then(|()| shard.finish(cells)),
    }
}

fn differs(key: impl Into<String>, planned: &str, here: &str) -> SweepError {
    SweepError::Differs { key: key.into(), planned: planned.to_owned(), here: here.to_owned() }
}

/// A shard's folder, held.
struct Shard<'a> {
    folder: &'a SweepFolder,
    number: usize,
    lock: FolderLock,
    record: ShardRecord,
    /// Nothing in it was damaged when it was opened.
    whole: bool,
    failed: Vec<FailedCell>,
}

impl<'a> Shard<'a> {
    fn open(folder: &'a SweepFolder, number: usize) -> Result<Self, SweepError> {
        let dir = folder.shard_dir(number);
        let lock = FolderLock::take(&dir)?;
        let manifest = &folder.manifest;
        let new = || ShardRecord {
            sweep: manifest.id(),
            shard: number,
            program: manifest.program.clone(),
            processor: manifest.processor.clone(),
            node: node(),
            done: false,
            failed: 0,
            rows: BTreeMap::new(),
            files: BTreeMap::new(),
        };
        // An account that does not read is one of nothing: rows are judged one by one.
        let found = match ShardRecord::read(&dir, "") {
            Err(SweepError::Damaged { .. }) => None,
            found => found?,
        };
        let record = found.unwrap_or_else(new);
        record.made_for(folder, number)?;
        let whole = record.mend(folder, &dir)?;
        Ok(Self { folder, number, lock, record, whole, failed: Vec::new() })
    }

    fn dir(&self) -> &ResultPath {
        self.lock.dir()
    }

    fn run(
        &mut self,
        here: &Node<'_>,
        trainer: &mut dyn Trainer,
        stop: &AtomicBool,
        progress: &mut dyn Progress,
    ) -> Result<(), SweepError> {
        self.record = ShardRecord { done: false, failed: 0, node: node(), ..self.record.clone() };
        self.record.write(self.dir())?;
        let _heart = Heart::start(self.dir(), self.rows_there()?.len());
        for place in 0..self.folder.manifest.jobs.len() {
            let cells = self.folder.manifest.cells_of(place);
            if self.folder.manifest.cells[cells].iter().all(|cell| cell.shard != self.number) {
                continue;
            }
            match &self.folder.manifest.jobs[place].spec {
                JobSpec::ClosedLoop(experiment) => {
                    self.closed_loop(place, experiment, here, stop, progress)?;
                }
                JobSpec::Train(specs) => self.trainings(place, specs, trainer, stop, progress)?,
            }
        }
        Ok(())
    }

    /// The cells of a closed loop.
    fn closed_loop(
        &mut self,
        place: usize,
        experiment: &Experiment,
        here: &Node<'_>,
        stop: &AtomicBool,
        progress: &mut dyn Progress,
    ) -> Result<(), SweepError> {
        let planned = &self.folder.manifest;
        let cells = &planned.cells[planned.cells_of(place)];
        let truth = self.folder.dir.join(TRUTH).join(&planned.jobs[place].folder);
        // Whoever reads them follows links.
        for (name, _) in truth.list()? {
            truth.join(name).open()?;
        }
        let experiment = here.finds(experiment, planned.data.as_deref(), truth.path());
        let source = experiment.source()?;
        let (threads, cache) = (here.threads, here.cache);
        let whole = Sweep { threads, cache, ..experiment.sweep(&source, here.networks)? };
        let sweep = whole.of_sequences_with(|i| cells.get(i).is_some_and(|cell| cell.shard == self.number));
        let manifest = Manifest::of(&sweep, here.program.clone())?;
        let made_from: Manifest = serde_json::from_value(planned.jobs[place].made_from.clone())
            .expect("the sweep's file was read as this program writes it");
        if let Some((key, planned, here)) = manifest.differs(&made_from) {
            return Err(differs(key, &planned, &here));
        }
        let own: HashSet<&str> =
            cells.iter().filter(|cell| cell.shard == self.number).map(|cell| cell.cell.as_str()).collect();
        let named = sweep.named_cells(&manifest)?;
        let there: HashSet<&str> = named.iter().map(|(_, cell)| cell.as_str()).collect();
        if let Some(gone) =
            cells.iter().find(|cell| own.contains(cell.cell.as_str()) && !there.contains(cell.cell.as_str()))
        {
            let key = format!("network, file of a noise, or training sequence of {}", gone.label);
            return Err(differs(key, &gone.cell[..16], "not so"));
        }
        let dir = self.dir().join(&planned.jobs[place].folder);
        let inner = if dir == *self.dir() { None } else { Some(FolderLock::take(&dir)?) };
        let lock = inner.as_ref().unwrap_or(&self.lock);
        self.failed.extend(sweep.run_cells(&own, lock, &manifest, (stop, progress))?);
        Ok(())
    }

    /// Trainings, one after another; each is spread over the threads by itself.
    fn trainings(
        &mut self,
        place: usize,
        specs: &[TrainSpec],
        trainer: &mut dyn Trainer,
        stop: &AtomicBool,
        progress: &mut dyn Progress,
    ) -> Result<(), SweepError> {
        let planned = &self.folder.manifest;
        let there = self.rows_there()?;
        let dir = self.dir().join(&planned.jobs[place].folder);
        let mut rows = append_to(dir.join(ROWS))?;
        for (cell, spec) in planned.cells[planned.cells_of(place)].iter().zip(specs) {
            if cell.shard != self.number {
                continue;
            }
            let run = dir.join(&spec.folder);
            if there.contains(&cell.cell) && run.join("summary.json").is_file() {
                continue;
            }
            let content = trainer.content(spec)?;
            if content != cell.cell {
                let key = format!("data of {}", cell.label);
                return Err(differs(key, &cell.cell[..16], &content[..16]));
            }
            if stop.load(Ordering::Relaxed) {
                return Err(SweepError::Stopped { done: there.len(), total: 0 });
            }
            match trainer.train(spec, &run, (stop, &mut *progress)) {
                Ok(mut row) => {
                    row.insert("cell".into(), cell.cell.clone().into());
                    row.insert("folder".into(), spec.folder.clone().into());
                    rows.write(&row)?;
                }
                Err(TrainFault::Stopped) => {
                    return Err(SweepError::Stopped { done: there.len(), total: 0 });
                }
                Err(TrainFault::Failed(reason)) => {
                    self.failed.push(FailedCell { cell: cell.cell.clone(), reason });
                }
            }
        }
        Ok(())
    }

    /// Checksums of the cells that have a row.
    fn rows_there(&self) -> Result<HashSet<String>, IoError> {
        let own: HashSet<&str> = self
            .folder
            .cells_of_shard(self.number)
            .map(|place| self.folder.manifest.cells[place].cell.as_str())
            .collect();
        let mut there = cells_with_rows(self.folder, self.dir())?;
        there.retain(|cell| own.contains(cell.as_str()));
        Ok(there)
    }

    /// Writes the cells that failed, none where none did.
    fn note_failed(&self) -> Result<(), IoError> {
        let path = self.dir().join(FAILED);
        if self.failed.is_empty() && path.kind().is_none() {
            return Ok(());
        }
        let mut text = String::new();
        for line in self.failed_lines() {
            text += &(serde_json::to_string(&line).expect("texts") + "\n");
        }
        write_file(&path, &text)
    }

    fn failed_lines(&self) -> impl Iterator<Item = FailedLine> + '_ {
        let cells = &self.folder.manifest.cells;
        let labels: HashMap<&str, &str> =
            cells.iter().map(|cell| (cell.cell.as_str(), cell.label.as_str())).collect();
        self.failed.iter().map(move |FailedCell { cell, reason }| FailedLine {
            cell: cell.clone(),
            label: (*labels.get(cell.as_str()).expect("cells of the sweep alone are run")).to_owned(),
            reason: reason.clone(),
        })
    }

    /// Ends the shard: its account has a checksum of everything.
    fn finish(mut self, cells: usize) -> Result<ShardOutcome, SweepError> {
        let dir = self.dir().clone();
        self.record.take_sums(self.folder, &dir)?;
        self.record.done = true;
        self.record.failed = self.failed.len();
        self.record.write(&dir)?;
        match self.failed_lines().next() {
            None => Ok(ShardOutcome { cells, was_there: false }),
            Some(FailedLine { label, reason, .. }) => Err(SweepError::Failed {
                count: self.failed.len(),
                label,
                reason,
                path: dir.join(FAILED).path().to_path_buf(),
                command: self.folder.command(self.number),
            }),
        }
    }
}

/// A file that lines are added to.
struct Lines {
    path: ResultPath,
    file: File,
}

fn append_to(path: ResultPath) -> Result<Lines, IoError> {
    Ok(Lines { file: path.append()?, path })
}

impl Lines {
    /// Adds a line in one go.
    fn write<T: Serialize>(&mut self, value: &T) -> Result<(), IoError> {
        let line = serde_json::to_string(value).expect("texts and numbers") + "\n";
        let written = self.file.write_all(line.as_bytes());
        written.map_err(|source| IoError::Write { path: self.path.path().to_path_buf(), source })
    }
}
