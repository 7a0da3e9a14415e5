//! What is kept of an open loop under way: a file a set of windows, so that one that was broken off goes on.

use super::rows::Row;
use dpn_io::{IoError, ResultPath, write_json};

/// A folder of cells, the rows of a set of windows each, named by the checksum of all that they are a function of.
#[derive(Debug)]
pub(super) struct Cells {
    dir: ResultPath,
}

impl Cells {
    /// Cells in `dir`, which is made with the first of them.
    pub(super) fn new(dir: &ResultPath) -> Self {
        Self { dir: dir.clone() }
    }

    fn path(&self, content: &str) -> ResultPath {
        self.dir.join(format!("{content}.json"))
    }

    /// The cell, if it is there; one that does not read is made again.
    pub(super) fn read(&self, content: &str) -> Option<Vec<Row>> {
        serde_json::from_slice(&self.path(content).read().ok()??).ok()
    }

    /// Keeps a cell.
    ///
    /// # Errors
    /// A folder that cannot be written to.
    pub(super) fn write(&self, content: &str, rows: &[Row]) -> Result<(), IoError> {
        write_json(self.path(content), rows)
    }
}
