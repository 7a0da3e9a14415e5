//! What stands for the reader of databases where the feature `sqlite` is off.

use crate::LogError;
use crate::messages::Messages;
use std::io::Read;
use std::path::Path;

/// A database cannot be read.
pub(crate) fn read(path: &Path, _: &mut dyn Messages) -> Result<Option<String>, LogError> {
    Err(LogError::NoSqlite { path: path.to_path_buf() })
}

/// The same of one that comes through a pipe.
pub(crate) fn read_stream(
    _: impl Read,
    path: &Path,
    topics: &mut dyn Messages,
) -> Result<Option<String>, LogError> {
    read(path, topics)
}
