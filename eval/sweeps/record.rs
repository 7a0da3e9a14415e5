//! A shard's own account, `shard.json`: who made it and, at its end, a checksum of every row and file, by which damage is told.

use super::beat::BEAT;
use super::error::{MixedShard, SweepError};
use super::manifest::SweepFolder;
use super::shard_files::{FAILED, ROWS};
use dpn_core::checksum::of_parts;
use dpn_io::{IoError, Kind, ResultPath, write_file, write_json};
use serde::{Deserialize, Serialize};
use std::collections::{BTreeMap, HashSet};
use std::path::PathBuf;

const NAME: &str = "shard.json";
/// Files that are a shard's account and no result.
const ACCOUNTS: [&str; 6] = [NAME, ROWS, "run.json", FAILED, BEAT, ".dpn.lock"];

/// A shard's account.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct ShardRecord {
    /// The sweep's [id](super::manifest::SweepManifest::id).
    pub(super) sweep: String,
    /// Its number there.
    pub(super) shard: usize,
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

/// Checksum of a file; none where it is not there.
fn file_sum(path: &ResultPath) -> Result<Option<String>, IoError> {
    Ok(path.read()?.map(|bytes| of_parts([bytes])))
}

/// Checksums of the cells that have a row in a shard's folder, whichever shard they are planned for.
pub(super) fn cells_with_rows(folder: &SweepFolder, dir: &ResultPath) -> Result<HashSet<String>, IoError> {
    let mut there = HashSet::new();
    for job in &folder.manifest.jobs {
        let text = dir.join(&job.folder).join(ROWS).text()?;
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
    pub(super) fn read(dir: &ResultPath, command: &str) -> Result<Option<Self>, SweepError> {
        let path = dir.join(NAME);
        let Some(bytes) = path.read()? else { return Ok(None) };
        let bad = |error: serde_json::Error| SweepError::Damaged {
            path: path.path().to_path_buf(),
            line: error.line(),
            message: format!("not a shard's account: {error}"),
            command: command.to_owned(),
        };
        serde_json::from_slice(&bytes).map(Some).map_err(bad)
    }

    /// Whether it is the account of this shard of this sweep.
    ///
    /// # Errors
    /// In what it is not.
    pub(super) fn made_for(&self, folder: &SweepFolder, shard: usize) -> Result<(), SweepError> {
        let planned = &folder.manifest;
        let (id, numbers) = (planned.id(), [self.shard.to_string(), shard.to_string()]);
        let pairs = [
            ("program", &self.program, &planned.program),
            ("processor", &self.processor, &planned.processor),
            ("list of cells, and so from other settings or inputs", &self.sweep, &id),
            ("number", &numbers[0], &numbers[1]),
        ];
        // A folder of a number that is not planned may be a copy.
        let asked = if shard < folder.shards() { &pairs[..] } else { &pairs[..3] };
        let Some((key, there, here)) = asked.iter().find(|(_, there, here)| there != here) else {
            return Ok(());
        };
        let first = folder.cells_of_shard(shard).next();
        Err(SweepError::Mixed(Box::new(MixedShard {
            shard,
            label: first
                .map_or_else(|| "none planned".to_owned(), |place| planned.cells[place].label.clone()),
            key: (*key).to_owned(),
            there: (*there).clone(),
            planned: (*here).clone(),
            command: folder.command(shard),
        })))
    }

    pub(super) fn write(&self, dir: &ResultPath) -> Result<(), IoError> {
        write_json(dir.join(NAME), self)
    }

    /// Takes the checksums of all that lies in `dir`.
    pub(super) fn take_sums(&mut self, folder: &SweepFolder, dir: &ResultPath) -> Result<(), IoError> {
        (self.rows, self.files) = (BTreeMap::new(), BTreeMap::new());
        for job in &folder.manifest.jobs {
            let text = dir.join(&job.folder).join(ROWS).text()?;
            if !text.is_empty() {
                self.rows.insert(job.folder.clone(), text.lines().map(line_sum).collect());
            }
        }
        for name in results(dir)? {
            if let Some(sum) = file_sum(&dir.join(&name))? {
                self.files.insert(name, sum);
            }
        }
        Ok(())
    }

    /// Takes away what is damaged in `dir`, so that it is made again: lines that were not written so, and files. Whether there was nothing to take.
    pub(super) fn mend(&self, folder: &SweepFolder, dir: &ResultPath) -> Result<bool, IoError> {
        let mut whole = true;
        for job in &folder.manifest.jobs {
            let path = dir.join(&job.folder).join(ROWS);
            let text = path.text()?;
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
                write_file(&path, &text)?;
            }
            whole &= kept.len() == lines.len()
                && (!self.done || kept.len() == self.rows.get(&job.folder).map_or(0, Vec::len));
        }
        for (name, sum) in &self.files {
            let path = dir.join(name);
            let there = file_sum(&path)?;
            whole &= there.as_ref() == Some(sum);
            if there.is_some_and(|there| there != *sum) {
                path.remove()?;
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

/// Every file of results by its path below `dir`, sorted.
fn results(dir: &ResultPath) -> Result<Vec<PathBuf>, IoError> {
    let mut found = Vec::new();
    let mut folders = vec![PathBuf::new()];
    while let Some(folder) = folders.pop() {
        for (name, kind) in dir.join(&folder).list()? {
            let path = folder.join(&name);
            let Some(name) = name.to_str() else {
                let path = dir.join(path).path().to_path_buf();
                return Err(IoError::InTheWay { path, what: "a name that is no text (UTF-8)" });
            };
            if kind == Kind::Folder {
                folders.push(path);
            } else if !ACCOUNTS.contains(&name) && !name.ends_with(".tmp") {
                found.push(path);
            }
        }
    }
    found.sort();
    Ok(found)
}

#[cfg(all(test, target_os = "linux"))]
mod tests {
    use super::*;
    use std::os::unix::ffi::OsStrExt;

    #[test]
    fn a_name_that_is_no_text_says_what_to_do_and_that_helps() {
        let tmp = tempfile::tempdir().unwrap();
        std::fs::write(tmp.path().join("rows.csv"), "1").unwrap();
        let odd = tmp.path().join(std::ffi::OsStr::from_bytes(b"gr\xfcn.csv"));
        std::fs::write(&odd, "1").unwrap();
        let error = results(&ResultPath::from(tmp.path())).unwrap_err();
        assert!(error.to_string().contains("a name that is no text (UTF-8)"), "{error}");
        assert!(error.hint().unwrap().contains("remove it and run the same again"), "{error}");
        std::fs::remove_file(odd).unwrap();
        assert_eq!(results(&ResultPath::from(tmp.path())).unwrap(), [PathBuf::from("rows.csv")]);
    }
}
