//! The logs of a folder that is none itself.

use crate::{Kind, LogError};
use dpn_io::IoError;
use std::path::{Path, PathBuf};

/// Ends of names of logs.
const ENDS: [&str; 20] = [
    "csv", "txt", "tsv", "jsonl", "json", "bag", "mcap", "db3", "ulg", "bin", "log", "zip", "gz", "zst",
    "xz", "bz2", "bbl", "bfl", "tlog", "gcsv",
];

/// Folders in each other that are looked through.
const DEEPEST: usize = 4;

/// The logs at `path`: itself where it is one, else the files and folders in it that look like logs by their names and files, sorted; where there are
/// none, those of the folders in it.
///
/// # Errors
/// Nothing there; a folder that holds none.
pub fn logs_in(path: &Path) -> Result<Vec<PathBuf>, LogError> {
    logs_below(path, DEEPEST)
}

fn logs_below(path: &Path, deep: usize) -> Result<Vec<PathBuf>, LogError> {
    // Looking into a pipe would take from it.
    if !path.is_dir() {
        return Ok(vec![path.to_path_buf()]);
    }
    let Err(none @ LogError::NoLog { .. }) = Kind::of(path) else { return Ok(vec![path.to_path_buf()]) };
    if crate::imu_file::ImuFile::of(path).is_ok() {
        return Ok(vec![path.to_path_buf()]);
    }
    let is_log = |path: &PathBuf| {
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        // A pipe gives nothing until somebody writes.
        let ends = || {
            path.is_file()
                && path.extension().is_some_and(|e| ENDS.iter().any(|end| e.eq_ignore_ascii_case(end)))
        };
        !name.starts_with('.') && if path.is_dir() { Kind::of(path).is_ok() } else { ends() }
    };
    let entries = std::fs::read_dir(path).map_err(|e| IoError::reading(path, e))?;
    // A link may lead up again.
    let entries: Vec<_> = entries.flatten().collect();
    let folders: Vec<PathBuf> = entries
        .iter()
        .filter(|e| e.file_type().is_ok_and(|t| t.is_dir()))
        .map(std::fs::DirEntry::path)
        .collect();
    let mut found: Vec<PathBuf> = entries.iter().map(std::fs::DirEntry::path).filter(is_log).collect();
    if let (true, LogError::NoLog { below, .. }) = (found.is_empty(), &none) {
        found.clone_from(below);
    }
    if found.is_empty() && deep > 0 {
        let below = |dir: &PathBuf| match logs_below(dir, deep - 1) {
            Ok(logs) => logs,
            Err(LogError::NoLog { .. }) => Vec::new(),
            // Whoever reads it is told why not.
            Err(_) => vec![dir.clone()],
        };
        found = folders.iter().flat_map(below).collect();
    }
    found.sort();
    if found.is_empty() { Err(none) } else { Ok(found) }
}
