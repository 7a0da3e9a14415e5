//! What is kept of an open loop under way: a file a set of windows, so that one that was broken off goes on.

use super::request::Drawn;
use super::rows::Row;
use dpn_io::{IoError, atomic_write};
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};

/// What came of one set of windows.
#[derive(Debug, Default, Serialize, Deserialize)]
pub(super) struct Judged {
    /// Its rows.
    pub(super) rows: Vec<Row>,
    /// Its predictions, where they are worth drawing.
    pub(super) drawn: Option<Drawn>,
}

/// A folder of cells, each named by the checksum of all that it is a function of.
#[derive(Debug)]
pub(super) struct Cells {
    dir: PathBuf,
}

impl Cells {
    /// Cells in `dir`, which is made with the first of them.
    pub(super) fn new(dir: &Path) -> Self {
        Self { dir: dir.to_path_buf() }
    }

    fn path(&self, content: &str) -> PathBuf {
        self.dir.join(format!("{content}.json"))
    }

    /// The cell, if it is there; one that does not read is made again.
    pub(super) fn read(&self, content: &str) -> Option<Judged> {
        serde_json::from_slice(&std::fs::read(self.path(content)).ok()?).ok()
    }

    /// Keeps a cell.
    ///
    /// # Errors
    /// A folder that cannot be written to.
    pub(super) fn write(&self, content: &str, judged: &Judged) -> Result<(), IoError> {
        let text = serde_json::to_string(judged).expect("numbers, texts and lists of them");
        atomic_write(&self.path(content), |out| out.write_all(text.as_bytes()))
    }
}
