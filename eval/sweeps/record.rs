//! A shard's own account, `shard.json`: who made it and, at its end, a checksum of every row and file, by which damage is told.

use super::beat::BEAT;
use super::error::SweepError;
use super::manifest::SweepFolder;
use super::shard_files::{FAILED, ROWS};
use crate::text_file::text_of;
use dpn_core::checksum::of_parts;
use dpn_io::{IoError, atomic_write};
use serde::{Deserialize, Serialize};
use std::collections::{BTreeMap, HashSet};
use std::path::{Path, PathBuf};

const NAME: &str = "shard.json";
/// Files that are a shard's account and no result.
const ACCOUNTS: [&str; 6] = [NAME, ROWS, "run.json", FAILED, BEAT, ".dpn.lock"];

/// A shard's account.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct ShardRecord {
    /// The sweep's [id](super::manifest::SweepManifest::id).
    pub(super) sweep: String,
    /// Version and checksum of the program.
    pub(super) program: String,
    /// The kind of processor.
    pub(super) processor: String,
    /// The machine.
    pub(super) node: String,
    /// Whether it went to its end.
    pub(super) done: bool,
    /// Cells that could not be run.
    pub(super) failed: usize,
    /// Of every job's folder, a checksum a row.
    pub(super) rows: BTreeMap<PathBuf, Vec<String>>,
    /// A checksum of every other file, by its path below the shard's folder.
    pub(super) files: BTreeMap<PathBuf, String>,
}

/// Checksum of a row's line, without its end.
pub(super) fn line_sum(line: &str) -> String {
    of_parts([line])[..16].to_owned()
}

pub(super) fn file_sum(path: &Path) -> Result<String, IoError> {
    let bytes = std::fs::read(path).map_err(|source| IoError::Read { path: path.to_path_buf(), source })?;
    Ok(of_parts([bytes]))
}

/// Checksums of the cells that have a row in a shard's folder, whichever shard they are planned for.
pub(super) fn cells_with_rows(folder: &SweepFolder, dir: &Path) -> Result<HashSet<String>, IoError> {
    let mut there = HashSet::new();
    for job in &folder.manifest.jobs {
        let text = text_of(&dir.join(&job.folder).join(ROWS))?;
        let named = text.lines().filter_map(|line| serde_json::from_str::<Named>(line).ok());
        there.extend(named.map(|named| named.cell));
    }
    Ok(there)
}

impl ShardRecord {
    /// The account of the shard in `dir`, none where it has not begun.
    ///
    /// # Errors
    /// A file that does not read; `command` makes it again.
    pub(super) fn read(dir: &Path, command: &str) -> Result<Option<Self>, SweepError> {
        let path = dir.join(NAME);
        let text = text_of(&path)?;
        if text.is_empty() && !path.exists() {
            return Ok(None);
        }
        let bad = |error: serde_json::Error| SweepError::Damaged {
            path: path.clone(),
            line: error.line(),
            message: format!("not a shard's account: {error}"),
            command: command.to_owned(),
        };
        serde_json::from_str(&text).map(Some).map_err(bad)
    }

    pub(super) fn write(&self, dir: &Path) -> Result<(), IoError> {
        let text = serde_json::to_string(self).expect("texts and numbers") + "\n";
        atomic_write(&dir.join(NAME), |out| out.write_all(text.as_bytes()))
    }

    /// Takes the checksums of all that lies in `dir`.
    pub(super) fn take_sums(&mut self, folder: &SweepFolder, dir: &Path) -> Result<(), IoError> {
        (self.rows, self.files) = (BTreeMap::new(), BTreeMap::new());
        for job in &folder.manifest.jobs {
            let text = text_of(&dir.join(&job.folder).join(ROWS))?;
            if !text.is_empty() {
                self.rows.insert(job.folder.clone(), text.lines().map(line_sum).collect());
            }
        }
        for path in results(dir)? {
            let sum = file_sum(&path)?;
            let name = path.strip_prefix(dir).expect("it was found below the folder");
            self.files.insert(name.to_path_buf(), sum);
        }
        Ok(())
    }

    /// Takes away what is damaged in `dir`, so that it is made again: lines that were not written so, and files. Whether there was nothing to take.
    pub(super) fn mend(&self, folder: &SweepFolder, dir: &Path) -> Result<bool, IoError> {
        let mut whole = true;
        for job in &folder.manifest.jobs {
            let path = dir.join(&job.folder).join(ROWS);
            let text = text_of(&path)?;
            let sums = self.rows.get(&job.folder).map(|sums| sums.iter().collect::<HashSet<_>>());
            let good = |line: &&str| match &sums {
                Some(sums) if self.done => sums.contains(&line_sum(line)),
                // Nobody has said yet what must be there: a row is whole if it reads.
                _ => serde_json::from_str::<Named>(line).is_ok(),
            };
            let cut = if text.is_empty() || text.ends_with('\n') { 0 } else { 1 };
            let lines: Vec<&str> = text.lines().collect();
            let kept: Vec<&str> = lines[..lines.len() - cut].iter().copied().filter(good).collect();
            if kept.len() < lines.len() {
                let text: String = kept.iter().flat_map(|line| [line, "\n"]).collect();
                atomic_write(&path, |out| out.write_all(text.as_bytes()))?;
            }
            whole &= kept.len() == lines.len()
                && (!self.done || kept.len() == self.rows.get(&job.folder).map_or(0, Vec::len));
        }
        for (name, sum) in &self.files {
            let path = dir.join(name);
            if !path.is_file() {
                whole = false;
            } else if file_sum(&path)? != *sum {
                std::fs::remove_file(&path).map_err(|source| IoError::Write { path, source })?;
                whole = false;
            }
        }
        Ok(whole)
    }
}

/// What every row says, whatever it is of.
#[derive(Debug, Deserialize)]
pub(super) struct Named {
    /// The cell's checksum.
    pub(super) cell: String,
}

/// Every file of results below `dir`, sorted.
fn results(dir: &Path) -> Result<Vec<PathBuf>, IoError> {
    let mut found = Vec::new();
    let mut folders = vec![dir.to_path_buf()];
    while let Some(folder) = folders.pop() {
        let failed = |source| IoError::Read { path: folder.clone(), source };
        for entry in std::fs::read_dir(&folder).map_err(failed)? {
            let entry = entry.map_err(failed)?;
            let name = entry.file_name();
            let name = name.to_string_lossy();
            if entry.file_type().map_err(failed)?.is_dir() {
                folders.push(entry.path());
            } else if !ACCOUNTS.contains(&name.as_ref()) && !name.ends_with(".tmp") {
                found.push(entry.path());
            }
        }
    }
    found.sort();
    Ok(found)
}
