//! Shards put together into the folder that one process would have left.
//!
//! Rows are not taken apart on the way: a line is checked against its shard's account, found by its cell's checksum, and copied byte by byte to its
//! place in the order of cells.

use super::error::{MissingShard, SweepError};
use super::manifest::SweepFolder;
use super::record::{Named, ShardRecord, line_sum};
use super::shard::FailedLine;
use super::shard_files::{FAILED, ROWS};
use super::spec::JobSpec;
use crate::closed_loop::{Manifest, Row, StageSeconds};
use dpn_core::checksum::of_parts;
use dpn_io::{FolderLock, IoError, ResultPath, atomic_write, write_file};
use std::collections::{BTreeMap, HashMap, HashSet};
use std::path::{Path, PathBuf};

/// What was put together.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Collected {
    /// The folder.
    pub out: ResultPath,
    /// Rows of all jobs.
    pub rows: usize,
    /// Files beside them.
    pub files: usize,
    /// Cells that have none, for they could not be run.
    pub failed: usize,
}

/// What the shards have.
struct Found<'a> {
    folder: &'a SweepFolder,
    /// Of every cell, by its job and its checksum, its place: two jobs may have a cell in common.
    place_of: HashMap<(usize, &'a str), usize>,
    /// Of every cell, by its place, its row and the shard that has it.
    lines: Vec<Option<(usize, String)>>,
    /// Files beside rows, by their path below the results' folder: the shard that has them, and their checksum.
    files: BTreeMap<PathBuf, (usize, String)>,
    failed: Vec<(usize, FailedLine)>,
    missing: Vec<MissingShard>,
}

/// Puts the shards of `folder` together in `out`; with `without_failed` where cells could not be run, too.
///
/// # Errors
/// Shards that are missing, damaged, of another program, processor or sweep, or that contradict each other; cells that failed; a folder of another
/// run, or one that cannot be written to. Nothing is written then.
pub fn collect(
    folder: &SweepFolder,
    out: &ResultPath,
    without_failed: bool,
) -> Result<Collected, SweepError> {
    let cells = &folder.manifest.cells;
    let mut found = Found {
        folder,
        place_of: (0..).zip(cells).map(|(place, cell)| ((cell.job, cell.cell.as_str()), place)).collect(),
        lines: vec![None; cells.len()],
        files: BTreeMap::new(),
        failed: Vec::new(),
        missing: Vec::new(),
    };
    for shard in found.numbers()? {
        found.read_shard(shard)?;
    }
    found.check(without_failed)?;
    found.write(out)
}

impl Found<'_> {
    /// The numbers of all shards, planned or there.
    fn numbers(&self) -> Result<Vec<usize>, IoError> {
        let mut numbers: Vec<usize> = (0..self.folder.shards()).collect();
        let there = self.folder.dir.join("shards").list()?;
        numbers.extend(there.iter().filter_map(|(name, _)| name.to_str()?.parse::<usize>().ok()));
        numbers.sort_unstable();
        numbers.dedup();
        Ok(numbers)
    }

    fn read_shard(&mut self, shard: usize) -> Result<(), SweepError> {
        let (folder, dir) = (self.folder, self.folder.shard_dir(shard));
        let planned = &folder.manifest;
        let (own, command) = (folder.cells_of_shard(shard), folder.command(shard));
        let Some(record) = ShardRecord::read(&dir, &command)? else {
            let cells = own.count();
            if cells > 0 {
                self.missing.push(MissingShard { shard, done: 0, cells, command });
            }
            return Ok(());
        };
        record.made_for(folder, shard)?;
        if !record.done {
            let done = count_rows(folder, &dir)?;
            self.missing.push(MissingShard { shard, done, cells: own.count(), command });
            return Ok(());
        }
        for job in 0..planned.jobs.len() {
            self.read_rows(shard, job, &record, &dir)?;
        }
        for (name, sum) in record.files {
            self.files.entry(name).or_insert((shard, sum));
        }
        for line in dir.join(FAILED).text()?.lines() {
            if let Ok(line) = serde_json::from_str(line) {
                self.failed.push((shard, line));
            }
        }
        Ok(())
    }

    /// The rows of one job in one shard.
    fn read_rows(
        &mut self,
        shard: usize,
        job: usize,
        record: &ShardRecord,
        dir: &ResultPath,
    ) -> Result<(), SweepError> {
        let name = &self.folder.manifest.jobs[job].folder;
        let path_in = |dir: &ResultPath| dir.join(name).join(ROWS);
        let path = path_in(dir);
        let Some(sums) = record.rows.get(name) else { return Ok(()) };
        let command = || self.folder.command(shard);
        let damaged = |line: usize, message: &str| SweepError::Damaged {
            path: path.path().to_path_buf(),
            line,
            message: message.to_owned(),
            command: command(),
        };
        let rows = path.read()?.ok_or_else(|| damaged(1, "the file has gone"))?;
        let mut number = 0;
        for bytes in rows.split_inclusive(|byte| *byte == b'\n') {
            number += 1;
            let text = std::str::from_utf8(bytes).ok().and_then(|text| text.strip_suffix('\n'));
            let good = text.filter(|text| sums.get(number - 1).is_some_and(|sum| *sum == line_sum(text)));
            let Some(text) = good else {
                return Err(damaged(number, "not the row that the shard wrote"));
            };
            let Ok(Named { cell }) = serde_json::from_str(text) else {
                return Err(damaged(number, "not a row"));
            };
            let Some(&place) = self.place_of.get(&(job, cell.as_str())) else {
                return Err(damaged(number, "a row of no cell of this sweep"));
            };
            match &self.lines[place] {
                None => self.lines[place] = Some((shard, text.to_owned())),
                Some((_, first)) if same(first, text) => {}
                Some((first, _)) => {
                    return Err(SweepError::Contradiction {
                        label: self.folder.manifest.cells[place].label.clone(),
                        first: path_in(&self.folder.shard_dir(*first)).path().to_path_buf(),
                        second: path.path().to_path_buf(),
                    });
                }
            }
        }
        if number < sums.len() {
            return Err(damaged(number + 1, "the file ends before the shard's last row"));
        }
        Ok(())
    }

    /// Whether everything is there.
    fn check(&mut self, without_failed: bool) -> Result<(), SweepError> {
        if !self.missing.is_empty() {
            return Err(SweepError::Missing { shards: std::mem::take(&mut self.missing) });
        }
        let failed: HashSet<&str> = self.failed.iter().map(|(_, line)| line.cell.as_str()).collect();
        let cells = &self.folder.manifest.cells;
        let gone = |place: usize| {
            let planned = &cells[place];
            self.lines[place].is_none() && !failed.contains(planned.cell.as_str())
        };
        let mut missing: BTreeMap<usize, usize> = BTreeMap::new();
        for place in (0..cells.len()).filter(|place| gone(*place)) {
            *missing.entry(cells[place].shard).or_default() += 1;
        }
        if !missing.is_empty() {
            let of = |(shard, gone)| {
                let cells = self.folder.cells_of_shard(shard).count();
                MissingShard { shard, done: cells - gone, cells, command: self.folder.command(shard) }
            };
            return Err(SweepError::Missing { shards: missing.into_iter().map(of).collect() });
        }
        let open: HashSet<&str> = (0..cells.len())
            .filter(|place| self.lines[*place].is_none())
            .map(|place| cells[place].cell.as_str())
            .collect();
        self.failed.retain(|(_, line)| open.contains(line.cell.as_str()));
        match self.failed.first() {
            Some((shard, line)) if !without_failed => Err(SweepError::Failed {
                count: self.failed.len(),
                label: line.label.clone(),
                reason: line.reason.clone(),
                path: self.folder.shard_dir(*shard).join(FAILED).path().to_path_buf(),
                command: self.folder.command(*shard),
            }),
            _ => Ok(()),
        }
    }

    fn write(&self, out: &ResultPath) -> Result<Collected, SweepError> {
        // Read twice, so that what is refused has written nothing.
        for name in self.files.keys() {
            self.checked_file(name)?;
        }
        let _lock = FolderLock::take(out)?;
        for (place, job) in self.folder.manifest.jobs.iter().enumerate() {
            let dir = out.join(&job.folder);
            if matches!(job.spec, JobSpec::ClosedLoop(_)) {
                let manifest: Manifest = serde_json::from_value(job.made_from.clone())
                    .expect("the sweep's file was read as this program writes it");
                manifest.put_into(&dir)?;
            }
            self.write_rows(place, &dir)?;
        }
        for name in self.files.keys() {
            let bytes = self.checked_file(name)?;
            write_file(out.join(name), &bytes)?;
        }
        let rows = self.lines.iter().flatten().count();
        Ok(Collected { out: out.clone(), rows, files: self.files.len(), failed: self.failed.len() })
    }

    /// The bytes of a file beside rows, as its shard wrote them.
    fn checked_file(&self, name: &Path) -> Result<Vec<u8>, SweepError> {
        let (shard, sum) = &self.files[name];
        let path = self.folder.shard_dir(*shard).join(name);
        let bytes = path.read_existing()?;
        if of_parts([&bytes]) == *sum {
            return Ok(bytes);
        }
        Err(SweepError::Damaged {
            path: path.path().to_path_buf(),
            line: 1,
            message: "not the file that the shard wrote".into(),
            command: self.folder.command(*shard),
        })
    }

    /// The rows of a job in the order of its cells, then those of other cells that were there.
    fn write_rows(&self, job: usize, dir: &ResultPath) -> Result<(), SweepError> {
        let path = dir.join(ROWS);
        let before = path.text()?;
        let others: Vec<&str> = before
            .split_inclusive('\n')
            .filter(|line| line.ends_with('\n'))
            .filter(|line| {
                let named = serde_json::from_str::<Named>(line);
                named.is_ok_and(|named| !self.place_of.contains_key(&(job, named.cell.as_str())))
            })
            .collect();
        let cells = self.folder.manifest.cells_of(job);
        Ok(atomic_write(&path, |out| {
            let own = self.lines[cells].iter().flatten();
            for (_, line) in own {
                writeln!(out, "{line}")?;
            }
            others.iter().try_for_each(|line| out.write_all(line.as_bytes()))
        })?)
    }
}

/// How many rows a shard has that has not ended.
fn count_rows(folder: &SweepFolder, dir: &ResultPath) -> Result<usize, IoError> {
    let count =
        |job: &super::manifest::Job| Ok(dir.join(&job.folder).join(ROWS).text()?.matches('\n').count());
    folder.manifest.jobs.iter().map(count).sum()
}

/// Whether two rows say the same but for the times that they took.
fn same(one: &str, other: &str) -> bool {
    let without_times = |text: &str| {
        let mut row: Row = serde_json::from_str(text).ok()?;
        (row.cpu_per_data_s, row.p95_update_ms, row.stage_s) = (0.0, 0.0, StageSeconds::default());
        if let Some(front_end) = &mut row.front_end {
            (front_end.cpu_per_data_s, front_end.p95_ms) = (0.0, 0.0);
        }
        Some(row)
    };
    one == other || without_times(one).is_some_and(|row| without_times(other) == Some(row))
}
