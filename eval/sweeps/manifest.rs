//! `sweep.json`: everything that the shards of a sweep are a function of, and which cell is whose.

use super::error::SweepError;
use super::spec::JobSpec;
use dpn_core::checksum::of_parts;
use dpn_core::config::gone;
use dpn_io::{ResultPath, write_file};
use serde::{Deserialize, Serialize};
use std::path::PathBuf;

/// The version of the format that this program writes and reads.
const FORMAT: u32 = 2;
const NAME: &str = "sweep.json";

/// A sweep.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SweepManifest {
    /// Version of this format.
    pub format: u32,
    /// Version and checksum of the program.
    pub program: String,
    /// The kind of processor: others give other bits.
    pub processor: String,
    /// Folder of the data as the plan names it; none where nothing is read.
    pub data: Option<PathBuf>,
    /// Whether the networks are those of the folder `models/` beside this file, and not the program's own.
    pub models: bool,
    /// The lists of cells.
    pub jobs: Vec<Job>,
    /// What each shard is predicted to take \[s\].
    pub shard_s: Vec<f64>,
    /// All cells, job by job, each in its job's order.
    pub cells: Vec<PlannedCell>,
}

/// A list of cells that leave a folder together.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Job {
    /// Its folder below the results' and below a shard's; empty where it is that folder itself.
    pub folder: PathBuf,
    /// What its cells are.
    pub spec: JobSpec,
    /// What they are made from: of a closed loop, its folder's `run.json`.
    pub made_from: serde_json::Value,
}

/// A cell.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PlannedCell {
    /// Place of its job.
    pub job: usize,
    /// Checksum of all that its result is a function of.
    pub cell: String,
    /// What people call it.
    pub label: String,
    /// How much there is to do: seconds of the recording; updates of a training.
    pub amount: f64,
    /// What it is predicted to take, without what it shares \[s\].
    pub cost_s: f64,
    /// Its shard.
    pub shard: usize,
}

/// A sweep's folder, read.
#[derive(Debug)]
pub struct SweepFolder {
    /// The folder.
    pub dir: ResultPath,
    /// Its `sweep.json`.
    pub manifest: SweepManifest,
}

impl SweepManifest {
    /// Of this format.
    pub fn new(program: String, processor: String, data: Option<PathBuf>, models: bool) -> Self {
        let (jobs, shard_s, cells) = (Vec::new(), Vec::new(), Vec::new());
        Self { format: FORMAT, program, processor, data, models, jobs, shard_s, cells }
    }

    /// A checksum of the cells and of what they are made by and on: shards of one sweep agree in it.
    pub fn id(&self) -> String {
        let of = [self.program.as_str(), &self.processor];
        let sum = of_parts(of.into_iter().chain(self.cells.iter().map(|cell| cell.cell.as_str())));
        sum[..16].to_owned()
    }

    /// Places of a job's cells.
    pub fn cells_of(&self, job: usize) -> std::ops::Range<usize> {
        let begin = self.cells.partition_point(|cell| cell.job < job);
        begin..self.cells.partition_point(|cell| cell.job <= job)
    }
}

impl SweepFolder {
    /// Reads `dir`.
    ///
    /// # Errors
    /// A folder without a sweep; a file that does not read, or is another version's.
    pub fn open(dir: &ResultPath) -> Result<Self, SweepError> {
        let path = dir.join(NAME);
        let no_sweep = || SweepError::NoSweep { dir: dir.path().to_path_buf() };
        let text = path.read()?.ok_or_else(no_sweep)?;
        let damaged = |line, message| SweepError::Damaged {
            path: path.path().to_path_buf(),
            line,
            message,
            command: format!("dpn sweep plan PLAN.toml --out {}", dir.display()),
        };
        #[derive(Deserialize)]
        struct Version {
            format: u32,
        }
        let bad = |error: serde_json::Error| {
            let words = error.to_string();
            damaged(error.line(), gone(&words).unwrap_or(words))
        };
        let version: Version = serde_json::from_slice(&text).map_err(bad)?;
        if version.format != FORMAT {
            let message = format!("a sweep of format {}, and this program reads {FORMAT}", version.format);
            return Err(damaged(1, message));
        }
        let manifest: SweepManifest = serde_json::from_slice(&text).map_err(bad)?;
        let bounds =
            |cell: &PlannedCell| cell.shard < manifest.shard_s.len() && cell.job < manifest.jobs.len();
        let in_order = manifest.cells.is_sorted_by_key(|cell| cell.job);
        if !in_order || !manifest.cells.iter().all(bounds) {
            return Err(damaged(1, "cells of shards or jobs that are not there".into()));
        }
        Ok(Self { dir: dir.clone(), manifest })
    }

    /// Whether `manifest` may be written into `dir`: where none is, or the same sweep, in other shards only if none of them has begun.
    ///
    /// # Errors
    /// Another sweep's folder, or one whose shards have begun; a file that does not read.
    pub fn may_take(dir: &ResultPath, manifest: &SweepManifest) -> Result<(), SweepError> {
        if dir.join(NAME).kind().is_none() {
            return Ok(());
        }
        let there = Self::open(dir)?;
        let begun = dir.join("shards").kind().is_some();
        if there.manifest.id() != manifest.id() || (begun && there.manifest != *manifest) {
            return Err(SweepError::OtherSweep { dir: dir.path().to_path_buf() });
        }
        Ok(())
    }

    /// Writes `manifest` into `dir`, which [may take](Self::may_take) it.
    ///
    /// # Errors
    /// A folder that cannot be written to; a path in the plan that is no text.
    pub fn create(dir: &ResultPath, manifest: SweepManifest) -> Result<Self, SweepError> {
        let text = serde_json::to_string(&manifest).map_err(|_| SweepError::NotText)? + "\n";
        write_file(dir.join(NAME), &text)?;
        Ok(Self { dir: dir.clone(), manifest })
    }

    /// Folder of a shard.
    pub fn shard_dir(&self, shard: usize) -> ResultPath {
        self.dir.join("shards").join(shard.to_string())
    }

    /// The command that makes a shard.
    pub fn command(&self, shard: usize) -> String {
        format!("dpn sweep run {} --shard {shard}", self.dir.display())
    }

    /// How many shards there are.
    pub fn shards(&self) -> usize {
        self.manifest.shard_s.len()
    }

    /// Places of a shard's cells, in order.
    pub fn cells_of_shard(&self, shard: usize) -> impl Iterator<Item = usize> + '_ {
        let cells = self.manifest.cells.iter().enumerate();
        cells.filter(move |(_, cell)| cell.shard == shard).map(|(place, _)| place)
    }
}
