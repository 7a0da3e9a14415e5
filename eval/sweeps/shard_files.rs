//! Names of the files in a shard's folder.

use dpn_io::IoError;
use std::io::ErrorKind;
use std::path::Path;

/// A job's rows in its folder.
pub(super) const ROWS: &str = "rows.jsonl";
/// What cells cost.
pub(super) const COSTS: &str = "costs.jsonl";
/// Cells that could not be run.
pub(super) const FAILED: &str = "failed.jsonl";

/// The text of a file, empty where there is none.
pub(super) fn text_of(path: &Path) -> Result<String, IoError> {
    match std::fs::read(path) {
        // What is no text is damage, which its line's checksum tells.
        Ok(bytes) => Ok(String::from_utf8_lossy(&bytes).into_owned()),
        Err(error) if error.kind() == ErrorKind::NotFound => Ok(String::new()),
        Err(source) => Err(IoError::Read { path: path.to_path_buf(), source }),
    }
}
