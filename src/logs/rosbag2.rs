//! A rosbag2 folder: its files one after the other, as one bag.

use crate::messages::Messages;
use crate::{LogError, mcap, sqlite};
use dpn_io::{IoError, printable};
use std::fs::File;
use std::io::BufReader;
use std::path::{Path, PathBuf};

/// Reads all files of a folder; returns what was wrong with the first damaged one. The files behind it are read all the same: they are
/// whole recordings of their own.
pub(crate) fn read(dir: &Path, topics: &mut dyn Messages) -> Result<Option<String>, LogError> {
    let mut damage = None;
    for file in bags(dir)?.0 {
        if topics.is_done() {
            break;
        }
        topics.next_file();
        let found = match file.extension().and_then(|e| e.to_str()) {
            Some("mcap") => {
                let opened = File::open(&file).map_err(|e| IoError::reading(&file, e))?;
                mcap::read(BufReader::new(opened), topics).map_err(|e| IoError::reading(&file, e))?
            }
            _ => sqlite::read(&file, topics)?,
        };
        if let Some(found) = found {
            let name = printable(&file.file_name().unwrap_or_default().to_string_lossy());
            damage.get_or_insert(format!("{name}: {found}"));
        }
    }
    Ok(damage)
}

/// The bag files of a folder in the order in which they were written, and one that is packed.
pub(crate) fn bags(dir: &Path) -> Result<(Vec<PathBuf>, Option<PathBuf>), IoError> {
    let reading = |e| IoError::reading(dir, e);
    let (mut files, mut packed) = (Vec::new(), None);
    for entry in std::fs::read_dir(dir).map_err(reading)? {
        let path = entry.map_err(reading)?.path();
        // A pipe is waited for, and for ever.
        if !path.is_file() {
            continue;
        }
        match path.extension().and_then(|e| e.to_str()) {
            Some("mcap" | "db3") => files.push(path),
            Some("zstd" | "zst") => packed = Some(path),
            _ => {}
        }
    }
    // NAME_0, NAME_1, ..., NAME_10.
    let number = |path: &PathBuf| {
        let stem = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        stem.rsplit('_').next().and_then(|n| n.parse::<u64>().ok())
    };
    files.sort_by_key(|path| (number(path), path.clone()));
    Ok((files, packed))
}
