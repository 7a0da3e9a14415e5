//! Names of the files of a sweep and of its shards.

use dpn_io::IoError;
use std::io::ErrorKind;
use std::path::Path;

/// A job's rows in its folder.
pub(super) const ROWS: &str = "rows.jsonl";
/// Cells that could not be run.
pub(super) const FAILED: &str = "failed.jsonl";

/// Reconciled ground truth that was made for the sweep, a folder a job; in the sweep's folder.
pub const TRUTH: &str = "truth";

/// The text of a file, empty where there is none.
pub(super) fn text_of(path: &Path) -> Result<String, IoError> {
    match std::fs::read(path) {
        // What is no text is damage, which its line's checksum tells.
        Ok(bytes) => Ok(String::from_utf8_lossy(&bytes).into_owned()),
        Err(error) if error.kind() == ErrorKind::NotFound => Ok(String::new()),
        Err(source) => Err(IoError::Read { path: path.to_path_buf(), source }),
    }
}
