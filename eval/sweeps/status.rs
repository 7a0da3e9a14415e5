//! How far a sweep is, told from its shards' files alone: whoever looks disturbs nobody.

use super::beat::{BEAT, Beat, now};
use super::error::SweepError;
use super::manifest::SweepFolder;
use super::record::{ShardRecord, cells_with_rows};
use super::shard::FailedLine;
use super::shard_files::FAILED;
use serde::Serialize;

/// A process that has not been heard of for so long is taken for gone \[s\].
const SILENT_S: u64 = 60;

/// What a shard is about.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum ShardState {
    /// Nobody has begun it.
    Waiting,
    /// A process works on it.
    Running,
    /// A process worked on it, and is gone or silent.
    BrokenOff,
    /// Its folder holds another shard, or one of another sweep.
    Misplaced,
    /// It is at its end, and some of its cells failed.
    Failed,
    /// It is at its end.
    Done,
}

/// A shard.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ShardStatus {
    /// Its number.
    pub shard: usize,
    /// What it is about.
    pub state: ShardState,
    /// Cells with a row.
    pub done: usize,
    /// Cells.
    pub cells: usize,
    /// What it is predicted to take from its beginning to its end \[s\].
    pub predicted_s: f64,
    /// What is left of that \[s\].
    pub left_s: f64,
    /// Who works on it.
    pub by: Option<Beat>,
    /// Cells that could not be run.
    pub failed: Vec<FailedLine>,
}

/// A sweep.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SweepStatus {
    /// Cells with a row.
    pub done: usize,
    /// Cells.
    pub cells: usize,
    /// Cells that could not be run.
    pub failed: usize,
    /// Shards that processes work on.
    pub running: usize,
    /// Until the end, if as many shards are worked on from now on as are now, at the speed that they have shown \[s\]; nothing where nobody works.
    pub left_s: Option<f64>,
    /// Every shard.
    pub shards: Vec<ShardStatus>,
}

/// Looks at a sweep.
///
/// # Errors
/// A file that cannot be read.
pub fn status(folder: &SweepFolder) -> Result<SweepStatus, SweepError> {
    let now = now();
    let mut own: Vec<Vec<usize>> = vec![Vec::new(); folder.shards()];
    for (place, cell) in folder.manifest.cells.iter().enumerate() {
        own[cell.shard].push(place);
    }
    let shards = own.iter().enumerate().map(|(shard, own)| of_shard(folder, shard, own, now));
    let shards = shards.collect::<Result<Vec<_>, SweepError>>()?;
    let running = shards.iter().filter(|shard| shard.state == ShardState::Running).count();
    Ok(SweepStatus {
        done: shards.iter().map(|shard| shard.done).sum(),
        cells: folder.manifest.cells.len(),
        failed: shards.iter().map(|shard| shard.failed.len()).sum(),
        running,
        left_s: left_s(&shards, running, now),
        shards,
    })
}

fn of_shard(folder: &SweepFolder, shard: usize, own: &[usize], now: u64) -> Result<ShardStatus, SweepError> {
    let (dir, manifest) = (folder.shard_dir(shard), &folder.manifest);
    // An account that does not read is found and mended by the shard's next run.
    let record = match ShardRecord::read(&dir, "") {
        Err(SweepError::Damaged { .. }) => None,
        record => record?,
    };
    let there = cells_with_rows(folder, &dir)?;
    let by: Option<Beat> = serde_json::from_str(&dir.join(BEAT).text()?).ok();
    let failed = dir.join(FAILED).text()?;
    let failed: Vec<FailedLine> = failed.lines().filter_map(|line| serde_json::from_str(line).ok()).collect();
    let alive = by.as_ref().is_some_and(|beat| now.saturating_sub(beat.beat) < SILENT_S && !beat.is_dead());
    let state = match &record {
        Some(record) if record.made_for(folder, shard).is_err() => ShardState::Misplaced,
        Some(record) if record.done && record.failed > 0 => ShardState::Failed,
        Some(record) if record.done => ShardState::Done,
        _ if alive => ShardState::Running,
        None => ShardState::Waiting,
        Some(_) => ShardState::BrokenOff,
    };
    let is_there = |place: &&usize| there.contains(&manifest.cells[**place].cell);
    let (all, left): (f64, f64) = own.iter().fold((0.0, 0.0), |(all, left), place| {
        let cost = manifest.cells[*place].cost_s;
        (all + cost, if is_there(&place) { left } else { left + cost })
    });
    let predicted_s = manifest.shard_s[shard];
    let left_share = if all > 0.0 { left / all } else { 0.0 };
    Ok(ShardStatus {
        shard,
        state,
        done: own.iter().filter(is_there).count(),
        cells: own.len(),
        predicted_s,
        left_s: if matches!(state, ShardState::Done | ShardState::Failed) {
            0.0
        } else {
            left_share * predicted_s
        },
        by,
        failed,
    })
}

/// Until all shards are at their end.
fn left_s(shards: &[ShardStatus], running: usize, now: u64) -> Option<f64> {
    let open = || shards.iter().filter(|shard| shard.left_s > 0.0);
    if open().next().is_none() {
        return Some(0.0);
    }
    if running == 0 {
        return None;
    }
    // Seconds that passed for a predicted one, over what was done since processes began.
    let (mut passed, mut done) = (0.0, 0.0);
    for shard in shards.iter().filter(|shard| shard.state == ShardState::Running) {
        let Some(by) = &shard.by else { continue };
        if shard.done > by.found {
            let share = (shard.done - by.found) as f64 / shard.cells as f64;
            passed += now.saturating_sub(by.since) as f64;
            done += share * shard.predicted_s;
        }
    }
    let pace = if done > 0.0 { passed / done } else { 1.0 };
    let sum: f64 = open().map(|shard| shard.left_s).sum();
    let longest = open().map(|shard| shard.left_s).fold(0.0, f64::max);
    Some(pace * (sum / running as f64).max(longest))
}
