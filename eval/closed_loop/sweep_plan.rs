//! What a sweep runs, and what is kept of it.

use super::recording::StartAt;
use super::row::{CellKey, Row};
use super::sequence_set::SequenceSet;
use super::track_cache::TrackCache;
use crate::injected::Injection;
use dpn_core::estimate::NoiseSpec;
use dpn_io::{IoError, ResultPath};
use dpn_pronet::network::Network;
use dpn_vio::EstimatorConfig;
use serde::{Deserialize, Serialize};

/// What to run.
#[derive(Debug, Clone)]
pub struct Sweep<'a> {
    /// Where sequences come from.
    pub source: &'a SequenceSet,
    /// Places of the sequences to run, as [`SequenceSet::select`] gives them.
    pub places: Vec<usize>,
    /// The noises.
    pub noises: Vec<NoiseSpec>,
    /// The seeds.
    pub seeds: Vec<u64>,
    /// More noises.
    pub others: Vec<NoiseSpec>,
    /// The seeds of these.
    pub other_seeds: Vec<u64>,
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
    /// Where tracks that were followed through images are kept for others; without it each run follows them itself.
    pub cache: Option<&'a TrackCache>,
    /// What is kept of a cell beside its row.
    pub keep: CellFiles,
    /// What is added to every recording's samples, from the seed of the cell.
    pub injection: Option<Injection>,
}

/// What is kept of cells beside their rows, each a file a cell. A cell is run again where such a file is not there.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CellFiles {
    /// Whether every cell's trajectory is written: `trajectories/CELL.tum`.
    pub trajectories: bool,
    /// Whether every cell's NEES is, where the estimator gives covariances: `nees/CELL.csv`.
    pub nees: bool,
    /// Whose states are: cells of one of these noises and this seed, `states/CELL.csv`.
    pub states: Option<(Vec<NoiseSpec>, u64)>,
}

impl CellFiles {
    /// Whether a file that belongs beside a cell's `row` is not in `dir`; none of a row that has another's name (`own`) is.
    pub(super) fn lacks(&self, dir: &ResultPath, key: &CellKey, row: &Row, own: bool) -> bool {
        let gone = |path: ResultPath| !own || !path.is_file();
        self.states_path(dir, key).is_some_and(gone)
            || (self.trajectories && gone(trajectory_path(dir, key)))
            || (self.nees && row.nees_position.is_some() && gone(nees_path(dir, key)))
    }

    /// Where the states of a cell are, if they are kept.
    pub fn states_path(&self, dir: &ResultPath, key: &CellKey) -> Option<ResultPath> {
        let (noises, seed) = self.states.as_ref()?;
        let wanted = key.seed == *seed && noises.iter().any(|noise| noise.to_string() == key.noise);
        wanted.then(|| states_path(dir, key))
    }
}

fn states_path(dir: &ResultPath, key: &CellKey) -> ResultPath {
    dir.join("states").join(key.file_name("csv"))
}

/// Where a cell's NEES is.
pub(super) fn nees_path(dir: &ResultPath, key: &CellKey) -> ResultPath {
    dir.join("nees").join(key.file_name("csv"))
}

/// Where a cell's trajectory is.
pub(super) fn trajectory_path(dir: &ResultPath, key: &CellKey) -> ResultPath {
    dir.join("trajectories").join(key.file_name("tum"))
}

/// Removes every file of a cell, for its row is of something else or about to be made.
///
/// # Errors
/// A file that cannot be removed.
pub(super) fn remove_files(dir: &ResultPath, key: &CellKey) -> Result<(), IoError> {
    for path in [states_path(dir, key), nees_path(dir, key), trajectory_path(dir, key)] {
        path.remove()?;
    }
    Ok(())
}
