//! A sweep's folder: what was asked for in `run.json`, a row a line in `rows.jsonl`.
//!
//! `run.json` is written before the first cell. Rows are appended as cells end, so that a run may be interrupted anywhere: one line may be
//! cut, and is dropped. Who opens the folder again with the same estimator, program and input gets the rows that are there; sequences,
//! noises and seeds may have been added. Who writes to it holds its lock.

use super::error::ClosedLoopError;
use super::manifest::Manifest;
use super::row::Row;
use dpn_io::{FolderLock, IoError, ResultPath, write_file};
use std::collections::HashSet;
use std::fs::File;
use std::io::Write;

/// A sweep's folder, open.
#[derive(Debug)]
pub struct Store<'a> {
    lock: &'a FolderLock,
    rows: Vec<Row>,
    file: File,
    /// What lies in the folder was made by this run: taken away again if it comes to nothing.
    created: bool,
}

impl<'a> Store<'a> {
    /// Opens the folder of `lock` for the run of `manifest`; rows that are there are kept.
    ///
    /// # Errors
    /// A folder that cannot be written to, or holds another run; a row that does not read.
    pub fn open(lock: &'a FolderLock, manifest: &Manifest) -> Result<Self, ClosedLoopError> {
        let dir = lock.dir();
        let created = !dir.join("run.json").is_file();
        manifest.clone().put_into(dir)?;
        let path = rows_path(dir);
        let mut rows = read_rows(&path)?;
        // Of two rows of one cell, which a run that was broken off may leave, the later one.
        let mut seen = HashSet::new();
        rows.reverse();
        rows.retain(|row| seen.insert(row.key()));
        rows.reverse();
        // What was cut in the middle of a line must not be appended to.
        let file = rewritten(&path, rows.iter())?;
        Ok(Self { lock, rows, file, created })
    }

    /// The folder.
    pub fn dir(&self) -> &ResultPath {
        self.lock.dir()
    }

    /// The rows that were there.
    pub fn rows(&self) -> &[Row] {
        &self.rows
    }

    /// Forgets rows, on disk too.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub fn forget(&mut self, stale: impl Fn(&Row) -> bool) -> Result<(), ClosedLoopError> {
        let before = self.rows.len();
        self.rows.retain(|row| !stale(row));
        if self.rows.len() < before {
            self.file = rewritten(&rows_path(self.dir()), self.rows.iter())?;
        }
        Ok(())
    }

    /// Takes away what [`open`](Self::open) made, where no row has come since: a run that was refused leaves nothing behind.
    pub fn abandon(self) {
        let rows = rows_path(self.dir());
        if !self.created || rows.text().is_ok_and(|rows| !rows.is_empty()) {
            return;
        }
        // The error that led here matters more than one about what it left.
        let _ = rows.remove();
        let _ = self.dir().join("run.json").remove();
    }

    /// Appends one row.
    ///
    /// # Errors
    /// A file that cannot be written to.
    pub fn append(&mut self, row: &Row) -> Result<(), ClosedLoopError> {
        let written = self.file.write_all(line(row).as_bytes()).and_then(|()| self.file.flush());
        Ok(written
            .map_err(|source| IoError::Write { path: rows_path(self.dir()).path().to_owned(), source })?)
    }

    /// Writes the file anew: `ordered`, then what was there of other cells.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub fn finish(self, ordered: &[Row]) -> Result<(), ClosedLoopError> {
        let keys: HashSet<_> = ordered.iter().map(Row::key).collect();
        let others = self.rows.iter().filter(|row| !keys.contains(&row.key()));
        rewritten(&rows_path(self.dir()), ordered.iter().chain(others)).map(|_| ())
    }
}

fn rows_path(dir: &ResultPath) -> ResultPath {
    dir.join("rows.jsonl")
}

/// The rows of a file, none where it is not there; a last line that was cut is left out.
///
/// # Errors
/// A file that cannot be read, a line that is no row.
pub fn read_rows(path: &ResultPath) -> Result<Vec<Row>, ClosedLoopError> {
    let text = path.text()?;
    let whole = &text[..text.rfind('\n').map_or(0, |end| end + 1)];
    let read = |(line, text): (usize, &str)| {
        serde_json::from_str(text).map_err(|error| ClosedLoopError::BadRow {
            path: path.path().to_path_buf(),
            line: line + 1,
            message: error.to_string(),
        })
    };
    whole.lines().enumerate().filter(|(_, text)| !text.is_empty()).map(read).collect()
}

/// A row as it is written.
fn line(row: &Row) -> String {
    serde_json::to_string(row).expect("numbers, texts and lists of them") + "\n"
}

/// Writes the file and opens it to append to.
fn rewritten<'a>(path: &ResultPath, rows: impl Iterator<Item = &'a Row>) -> Result<File, ClosedLoopError> {
    let mut text = String::new();
    for row in rows {
        text.push_str(&line(row));
    }
    write_file(path, &text)?;
    Ok(path.append()?)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::closed_loop::row::testing::row;
    use serde_json::json;
    use std::collections::BTreeMap;

    fn manifest() -> Manifest {
        Manifest {
            program: "dpn 1".into(),
            estimator: json!({ "window": { "key_frames": 10, "loss": "huber" } }),
            source: json!({ "tracks": "given" }),
            from: "table".into(),
            inputs: BTreeMap::from([("MH_01".to_owned(), "aa".to_owned())]),
            networks: "nn".into(),
            cells: json!({ "seeds": [0] }),
        }
    }

    fn held(dir: &std::path::Path) -> FolderLock {
        FolderLock::take(dir).unwrap()
    }

    #[test]
    fn rows_survive_a_cut_line_and_are_ordered_at_the_end() {
        let tmp = tempfile::tempdir().unwrap();
        let rows: Vec<Row> = ["x1", "x2", "x4"].map(|noise| row("MH_01", noise, 0, Some(0.1 / 3.0))).to_vec();
        let lock = held(tmp.path());
        let mut store = Store::open(&lock, &manifest()).unwrap();
        store.append(&rows[2]).unwrap();
        store.append(&rows[0]).unwrap();
        store.append(&Row { frames: 7, ..rows[2].clone() }).unwrap();
        drop(store);
        let path = tmp.path().join("rows.jsonl");
        let mut text = std::fs::read_to_string(&path).unwrap();
        text.push_str(&serde_json::to_string(&rows[1]).unwrap()[..40]);
        std::fs::write(&path, text).unwrap();

        let mut store = Store::open(&lock, &manifest()).unwrap();
        let later = Row { frames: 7, ..rows[2].clone() };
        assert_eq!(store.rows(), [rows[0].clone(), later.clone()]);
        store.append(&rows[1]).unwrap();
        store.finish(&rows[..2]).unwrap();
        assert_eq!(read_rows(&ResultPath::from(&path)).unwrap(), [rows[0].clone(), rows[1].clone(), later]);

        let mut store = Store::open(&lock, &manifest()).unwrap();
        store.forget(|row| row.frames == 7).unwrap();
        store.append(&rows[2]).unwrap();
        assert_eq!(read_rows(&ResultPath::from(&path)).unwrap(), rows);
    }

    #[test]
    fn another_run_is_refused_by_what_differs_and_more_sequences_are_none() {
        let tmp = tempfile::tempdir().unwrap();
        let lock = held(tmp.path());
        Store::open(&lock, &manifest()).unwrap();
        let refused = |change: &dyn Fn(&mut Manifest)| {
            let mut other = manifest();
            change(&mut other);
            assert_ne!(other.fingerprint(), manifest().fingerprint());
            Store::open(&lock, &other).unwrap_err().to_string()
        };
        let text = refused(&|m| m.estimator["window"]["key_frames"] = 8.into());
        assert!(text.ends_with("another estimator.window.key_frames: 10 there, 8 now"), "{text}");
        assert!(refused(&|m| m.program = "dpn 2".into()).contains("another program: dpn 1 there, dpn 2 now"));
        assert!(refused(&|m| m.from = "0".into()).contains("another start"));
        let text = refused(&|m| *m.inputs.get_mut("MH_01").unwrap() = "bb".into());
        assert!(text.contains("another input of MH_01: aa there, bb now"), "{text}");
        let mut more = manifest();
        more.inputs = BTreeMap::from([("MH_02".to_owned(), "cc".to_owned())]);
        more.cells = json!({ "seeds": [0, 1] });
        Store::open(&lock, &more).unwrap();
        // Both sequences' sums are kept.
        let mut third = manifest();
        third.inputs = BTreeMap::from([("MH_02".to_owned(), "dd".to_owned())]);
        assert!(Store::open(&lock, &third).is_err());
        assert!(Store::open(&lock, &manifest()).is_ok());
        // Other networks are other cells, in the same folder.
        let networks = Manifest { networks: "oo".into(), ..manifest() };
        assert_ne!(networks.fingerprint(), manifest().fingerprint());
        assert!(Store::open(&lock, &networks).is_ok());
    }

    #[test]
    fn what_came_to_nothing_leaves_nothing_and_rows_are_kept() {
        let tmp = tempfile::tempdir().unwrap();
        let new = tmp.path().join("new");
        Store::open(&held(&new), &manifest()).unwrap().abandon();
        assert!(!new.exists());
        Store::open(&held(tmp.path()), &manifest()).unwrap().abandon();
        let left = std::fs::read_dir(tmp.path()).unwrap().count();
        assert_eq!(left, 0, "the folder that was there stays, empty");
        {
            let lock = held(&new);
            let mut store = Store::open(&lock, &manifest()).unwrap();
            store.append(&row("MH_01", "x1", 0, None)).unwrap();
            store.abandon();
        }
        Store::open(&held(&new), &manifest()).unwrap().abandon();
        assert_eq!(Store::open(&held(&new), &manifest()).unwrap().rows().len(), 1);
    }

    #[test]
    fn a_line_that_is_no_row_is_named() {
        let tmp = tempfile::tempdir().unwrap();
        let good = serde_json::to_string(&row("MH_01", "x1", 0, None)).unwrap();
        std::fs::write(tmp.path().join("rows.jsonl"), format!("{good}\n{{\"sequence\":1}}\n")).unwrap();
        let text = Store::open(&held(tmp.path()), &manifest()).unwrap_err().to_string();
        assert!(text.contains("rows.jsonl:2: not a row of results"), "{text}");
    }
}
