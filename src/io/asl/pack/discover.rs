//! Sequences of a pack, found as those of a folder are.

use super::super::sequence::{IMU_DATA, Sequence};
use super::{DataPack, Packed};
use crate::IoError;
use crate::column_file::ColumnFile;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// The pack that `path` is or leads into, and the rest of the path behind it; `None` of folders, and of what is not there at all.
///
/// A file that is no pack is taken for one: opening it says what it is.
pub(in super::super) fn split(path: &Path) -> Option<(PathBuf, String)> {
    if path.is_file() {
        return Some((path.to_path_buf(), String::new()));
    }
    if path.exists() {
        return None;
    }
    let file = path.ancestors().skip(1).find(|above| above.is_file())?;
    let below = path.strip_prefix(file).ok()?;
    ColumnFile::is_one(file).then(|| (file.to_path_buf(), in_pack(below)))
}

/// Whether there is such a folder, in a data pack too: `PACK/euroc`.
pub fn is_there(path: &Path) -> bool {
    path.is_dir()
        || split(path).is_some_and(|(file, below)| {
            ColumnFile::is_one(&file)
                && (below.is_empty()
                    || DataPack::open(&file).is_ok_and(|pack| !all(&Arc::new(pack), &below).is_empty()))
        })
}

/// Name of the folder of sequences at `path`, that which was packed too.
pub fn set_name(path: &Path) -> Option<String> {
    match split(path) {
        Some((file, below)) if below.is_empty() => Some(DataPack::open(&file).ok()?.manifest.name),
        _ => path.file_name().map(|name| name.to_string_lossy().into_owned()),
    }
}

/// A relative path as a pack spells it.
pub(super) fn in_pack(path: &Path) -> String {
    let parts: Vec<_> = path.components().map(|part| part.as_os_str().to_string_lossy()).collect();
    parts.join("/")
}

/// The sequences of `pack` that are at or below a path in it.
pub(super) fn all(pack: &Arc<DataPack>, below: &str) -> Vec<Sequence> {
    let wanted = |key: &str| {
        let rest = key.strip_prefix(below);
        below.is_empty() || rest.is_some_and(|rest| rest.is_empty() || rest.starts_with('/'))
    };
    let of = |(key, sequence): (&String, &super::manifest::PackedSequence)| {
        let path = pack.file.path();
        let root = path.join(&sequence.root);
        Sequence::of_pack(sequence.name.clone(), path.join(key), root, Packed::new(pack, key))
    };
    let mut found: Vec<_> = pack.manifest.sequences.iter().filter(|(key, _)| wanted(key)).map(of).collect();
    found.sort_by(|a, b| (a.name(), a.dir()).cmp(&(b.name(), b.dir())));
    found
}

/// As [`super::super::discover()`].
pub(in super::super) fn discover(file: &Path, below: &str) -> Result<Vec<Sequence>, IoError> {
    let pack = Arc::new(DataPack::open(file)?);
    let found = all(&pack, below);
    if found.is_empty() { Err(none(&pack, below)) } else { Ok(found) }
}

/// As [`Sequence::open`].
pub(in super::super) fn open(file: &Path, below: &str) -> Result<Sequence, IoError> {
    let pack = Arc::new(DataPack::open(file)?);
    match &all(&pack, below)[..] {
        [one] => Ok(one.clone()),
        _ => Err(none(&pack, below)),
    }
}

fn none(pack: &DataPack, below: &str) -> IoError {
    let all: Vec<_> = pack.manifest.sequences.keys().map(|key| crate::printable(key)).collect();
    let what = if below.is_empty() { "one sequence".to_owned() } else { format!("{below}/{IMU_DATA}") };
    IoError::NoSequence {
        dir: pack.file.path().join(below),
        looked_for: format!("{what}; the pack holds {}", all.join(", ")),
    }
}
