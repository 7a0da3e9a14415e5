//! A sweep's folder: what was asked for in `run.json`, a row a line in `rows.jsonl`.
//!
//! `run.json` is written before the first cell. Rows are appended as cells end, so that a run may be interrupted anywhere: one line may be
//! cut, and is dropped. Who opens the folder again with the same estimator, program and input gets the rows that are there; sequences,
//! noises and seeds may have been added.

use super::error::ClosedLoopError;
use super::images::ImageSource;
use super::row::{CellKey, Row};
use super::sequence_set::{SequenceSet, TrackSource};
use super::sweep::Sweep;
use dpn_core::estimate::NoiseSpec;
use dpn_io::{IoError, atomic_write};
use serde::{Deserialize, Serialize};
use std::collections::{BTreeMap, HashMap};
use std::fs::{File, OpenOptions};
use std::io::Write;
use std::path::{Path, PathBuf};

/// What a run is a function of, besides its cells.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Manifest {
    /// The program: its version and, where known, a checksum of it.
    pub program: String,
    /// The estimator's settings, resolved.
    pub estimator: serde_json::Value,
    /// Where recordings and tracks come from, with all settings that a number depends on.
    pub source: serde_json::Value,
    /// Where runs begin: `table` or seconds; and where they end, if that is said.
    pub from: String,
    /// SHA-256 of every sequence's files.
    pub inputs: BTreeMap<String, String>,
    /// The cells last asked for.
    pub cells: serde_json::Value,
}

impl Manifest {
    /// Of `sweep` by `program`; `networks` names the networks where they are not those that come with the program.
    ///
    /// # Errors
    /// A sequence's file that cannot be read.
    pub fn of(sweep: &Sweep<'_>, program: String, networks: Option<String>) -> Result<Self, ClosedLoopError> {
        let names = sweep.source.names();
        let mut inputs = BTreeMap::new();
        for &place in &sweep.places {
            inputs.insert(names[place].0.clone(), sweep.source.checksum(place)?);
        }
        inputs.extend(networks.map(|networks| ("models".to_owned(), networks)));
        let tracks = match sweep.source.tracks() {
            TrackSource::File(_) => serde_json::json!("given"),
            TrackSource::Simulated(config) => serde_json::json!(config),
            // The front-end's settings are the estimator's.
            TrackSource::Images(images) => match images {
                ImageSource::Folder { .. } => serde_json::json!(images.name()),
                ImageSource::Rendered(config) => serde_json::json!({ "rendered": config }),
            },
        };
        let mut source = match sweep.source {
            SequenceSet::Recorded { .. } => serde_json::json!({ "tracks": tracks }),
            SequenceSet::Flights { config, .. } => serde_json::json!({ "flights": config, "tracks": tracks }),
        };
        if let Some(injection) = &sweep.injection {
            source["injection"] = serde_json::json!(injection);
        }
        let specs = |noises: &[NoiseSpec]| noises.iter().map(ToString::to_string).collect::<Vec<_>>();
        let sequences: Vec<&str> = sweep.places.iter().map(|place| names[*place].0.as_str()).collect();
        let mut cells = serde_json::json!({ "sequences": sequences, "noises": specs(&sweep.noises), "seeds": sweep.seeds });
        if !sweep.others.0.is_empty() {
            cells["others"] =
                serde_json::json!({ "noises": specs(&sweep.others.0), "seeds": sweep.others.1 });
        }
        Ok(Self {
            program,
            estimator: serde_json::json!(sweep.estimator),
            source,
            from: sweep.to.map_or_else(|| sweep.from.to_string(), |to| format!("{} to {to}", sweep.from)),
            inputs,
            cells,
        })
    }

    /// SHA-256 over all but the cells: runs that agree in it may share a folder.
    pub fn fingerprint(&self) -> String {
        use sha2::{Digest, Sha256};
        let mut hash = Sha256::new();
        let parts = [&self.program, &self.estimator.to_string(), &self.source.to_string(), &self.from];
        for part in
            parts.map(String::as_str).into_iter().chain(self.inputs.iter().flat_map(|(a, b)| [a.as_str(), b]))
        {
            hash.update((part.len() as u64).to_le_bytes());
            hash.update(part);
        }
        hash.finalize().iter().map(|byte| format!("{byte:02x}")).collect()
    }

    /// The first thing in which `there` is of another run.
    fn differs(&self, there: &Self) -> Option<(String, String, String)> {
        let texts = |m: &Self| [m.program.clone(), m.from.clone()];
        for ((key, there), here) in ["program", "start"].into_iter().zip(texts(there)).zip(texts(self)) {
            if there != here {
                return Some((key.into(), there, here));
            }
        }
        for (key, there, here) in
            [("estimator", &there.estimator, &self.estimator), ("source", &there.source, &self.source)]
        {
            if let Some((path, there, here)) = difference(key, there, here) {
                return Some((path, there, here));
            }
        }
        self.inputs.iter().find_map(|(name, here)| {
            let there = there.inputs.get(name).filter(|there| *there != here)?;
            Some((format!("input of {name}"), there.clone(), here.clone()))
        })
    }
}

/// The first place in which two values differ.
fn difference(
    path: &str,
    there: &serde_json::Value,
    here: &serde_json::Value,
) -> Option<(String, String, String)> {
    use serde_json::Value::Object;
    match (there, here) {
        (Object(a), Object(b)) => {
            let keys = a.keys().chain(b.keys());
            let null = serde_json::Value::Null;
            keys.into_iter().find_map(|key| {
                let (a, b) = (a.get(key).unwrap_or(&null), b.get(key).unwrap_or(&null));
                difference(&format!("{path}.{key}"), a, b)
            })
        }
        _ if there == here => None,
        _ => Some((path.to_owned(), there.to_string(), here.to_string())),
    }
}

/// A sweep's folder, open.
#[derive(Debug)]
pub struct Store {
    dir: PathBuf,
    rows: Vec<Row>,
    file: File,
    /// The folder was made by this run, or at least what lies in it.
    created: Option<Created>,
}

/// What a run that comes to nothing takes away again.
#[derive(Debug, Clone, Copy)]
struct Created {
    folder: bool,
}

impl Store {
    /// Opens `dir` for the run of `manifest`, made where it is not there; rows that fit are kept.
    ///
    /// # Errors
    /// A folder that cannot be made or written to, or holds another run; a row that does not read.
    pub fn open(dir: &Path, manifest: &Manifest) -> Result<Self, ClosedLoopError> {
        let path = dir.join("run.json");
        let created = (!path.exists()).then(|| Created { folder: !dir.exists() });
        let mut manifest = manifest.clone();
        match std::fs::read(&path) {
            Ok(bytes) => {
                let bad = |e: serde_json::Error| ClosedLoopError::BadRow {
                    path: path.clone(),
                    line: e.line(),
                    message: e.to_string(),
                };
                let there: Manifest = serde_json::from_slice(&bytes).map_err(bad)?;
                if let Some((key, there, here)) = manifest.differs(&there) {
                    return Err(ClosedLoopError::OtherRun { dir: dir.to_path_buf(), key, there, here });
                }
                for (name, sum) in there.inputs {
                    manifest.inputs.entry(name).or_insert(sum);
                }
            }
            Err(error) if error.kind() == std::io::ErrorKind::NotFound => {}
            Err(source) => return Err(IoError::Read { path, source }.into()),
        }
        let text = serde_json::to_string_pretty(&manifest).expect("texts and JSON values") + "\n";
        atomic_write(&path, |out| out.write_all(text.as_bytes()))?;
        let path = dir.join("rows.jsonl");
        let rows = read_rows(&path)?;
        // What was cut in the middle of a line must not be appended to.
        write_rows(&path, rows.iter())?;
        let file = OpenOptions::new().append(true).open(&path);
        let file = file.map_err(|source| IoError::Write { path, source })?;
        Ok(Self { dir: dir.to_path_buf(), rows, file, created })
    }

    /// The rows that were there, by cell; of two of one cell, the later one.
    pub fn rows(&self) -> HashMap<CellKey, Row> {
        self.rows.iter().map(|row| (row.key(), row.clone())).collect()
    }

    /// Takes away what [`open`](Self::open) made, where no row has come since: a run that was refused leaves nothing behind.
    pub fn abandon(self) {
        let Some(Created { folder }) = self.created else { return };
        let rows = self.dir.join("rows.jsonl");
        if std::fs::metadata(&rows).is_ok_and(|rows| rows.len() > 0) {
            return;
        }
        // The error that led here matters more than one about what it left.
        let _ = std::fs::remove_file(rows);
        let _ = std::fs::remove_file(self.dir.join("run.json"));
        if folder {
            let _ = std::fs::remove_dir(&self.dir);
        }
    }

    /// Appends one row.
    ///
    /// # Errors
    /// A file that cannot be written to.
    pub fn append(&mut self, row: &Row) -> Result<(), ClosedLoopError> {
        let written = self.file.write_all(line(row).as_bytes()).and_then(|()| self.file.flush());
        Ok(written.map_err(|source| IoError::Write { path: self.dir.join("rows.jsonl"), source })?)
    }

    /// Writes the file anew: `ordered`, then what was there of other cells.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub fn finish(self, ordered: &[Row]) -> Result<(), ClosedLoopError> {
        let keys: std::collections::HashSet<CellKey> = ordered.iter().map(Row::key).collect();
        let others = self.rows.iter().filter(|row| !keys.contains(&row.key()));
        write_rows(&self.dir.join("rows.jsonl"), ordered.iter().chain(others))
    }
}

/// The rows of a file, none where it is not there; a last line that was cut is left out.
fn read_rows(path: &Path) -> Result<Vec<Row>, ClosedLoopError> {
    let text = match std::fs::read_to_string(path) {
        Ok(text) => text,
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => return Ok(Vec::new()),
        Err(source) => return Err(IoError::Read { path: path.to_path_buf(), source }.into()),
    };
    let whole = &text[..text.rfind('\n').map_or(0, |end| end + 1)];
    let read = |(line, text): (usize, &str)| {
        serde_json::from_str(text).map_err(|error| ClosedLoopError::BadRow {
            path: path.to_path_buf(),
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

fn write_rows<'a>(path: &Path, rows: impl Iterator<Item = &'a Row>) -> Result<(), ClosedLoopError> {
    let mut text = String::new();
    for row in rows {
        text.push_str(&line(row));
    }
    Ok(atomic_write(path, |out| out.write_all(text.as_bytes()))?)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::closed_loop::row::testing::row;
    use serde_json::json;

    fn manifest() -> Manifest {
        Manifest {
            program: "dpn 1".into(),
            estimator: json!({ "window": { "key_frames": 10, "loss": "huber" } }),
            source: json!({ "tracks": "given" }),
            from: "table".into(),
            inputs: BTreeMap::from([("MH_01".to_owned(), "aa".to_owned())]),
            cells: json!({ "seeds": [0] }),
        }
    }

    #[test]
    fn rows_survive_a_cut_line_and_are_ordered_at_the_end() {
        let tmp = tempfile::tempdir().unwrap();
        let rows: Vec<Row> = ["x1", "x2", "x4"].map(|noise| row("MH_01", noise, 0, Some(0.1 / 3.0))).to_vec();
        let mut store = Store::open(tmp.path(), &manifest()).unwrap();
        store.append(&rows[2]).unwrap();
        store.append(&rows[0]).unwrap();
        drop(store);
        let path = tmp.path().join("rows.jsonl");
        let mut text = std::fs::read_to_string(&path).unwrap();
        text.push_str(&serde_json::to_string(&rows[1]).unwrap()[..40]);
        std::fs::write(&path, text).unwrap();

        let mut store = Store::open(tmp.path(), &manifest()).unwrap();
        assert_eq!(store.rows().len(), 2);
        assert_eq!(store.rows()[&rows[0].key()], rows[0]);
        store.append(&rows[1]).unwrap();
        store.finish(&rows[..2]).unwrap();
        assert_eq!(read_rows(&path).unwrap(), rows);
    }

    #[test]
    fn another_run_is_refused_by_what_differs_and_more_sequences_are_none() {
        let tmp = tempfile::tempdir().unwrap();
        Store::open(tmp.path(), &manifest()).unwrap();
        let refused = |change: &dyn Fn(&mut Manifest)| {
            let mut other = manifest();
            change(&mut other);
            assert_ne!(other.fingerprint(), manifest().fingerprint());
            Store::open(tmp.path(), &other).unwrap_err().to_string()
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
        Store::open(tmp.path(), &more).unwrap();
        // Both sequences' sums are kept.
        let mut third = manifest();
        third.inputs = BTreeMap::from([("MH_02".to_owned(), "dd".to_owned())]);
        assert!(Store::open(tmp.path(), &third).is_err());
        assert!(Store::open(tmp.path(), &manifest()).is_ok());
    }

    #[test]
    fn what_came_to_nothing_leaves_nothing_and_rows_are_kept() {
        let tmp = tempfile::tempdir().unwrap();
        let new = tmp.path().join("new");
        Store::open(&new, &manifest()).unwrap().abandon();
        assert!(!new.exists());
        Store::open(tmp.path(), &manifest()).unwrap().abandon();
        assert_eq!(
            std::fs::read_dir(tmp.path()).unwrap().count(),
            0,
            "the folder that was there stays, empty"
        );
        let mut store = Store::open(&new, &manifest()).unwrap();
        store.append(&row("MH_01", "x1", 0, None)).unwrap();
        store.abandon();
        Store::open(&new, &manifest()).unwrap().abandon();
        assert_eq!(Store::open(&new, &manifest()).unwrap().rows().len(), 1);
    }

    #[test]
    fn a_line_that_is_no_row_is_named() {
        let tmp = tempfile::tempdir().unwrap();
        let good = serde_json::to_string(&row("MH_01", "x1", 0, None)).unwrap();
        std::fs::write(tmp.path().join("rows.jsonl"), format!("{good}\n{{\"sequence\":1}}\n")).unwrap();
        let text = Store::open(tmp.path(), &manifest()).unwrap_err().to_string();
        assert!(text.contains("rows.jsonl:2: not a row of results"), "{text}");
    }
}
