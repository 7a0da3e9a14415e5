//! What a pack says of itself.

use super::{FORMAT, STAMPS};
use crate::IoError;
use crate::column_file::ColumnFile;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// The description of a pack.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(super) struct Manifest {
    /// Name of the folder it was made of.
    pub(super) name: String,
    /// That folder: relative to the pack's own, or from the root.
    pub(super) folder: PathBuf,
    /// The sequences by their paths in the folder.
    pub(super) sequences: BTreeMap<String, PackedSequence>,
}

/// One sequence.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(super) struct PackedSequence {
    /// Its name.
    pub(super) name: String,
    /// Its root in the folder: its own path, or `mav0` below it.
    pub(super) root: String,
    /// SHA-256 of the files it was made of, by their paths below the root.
    pub(super) files: BTreeMap<String, String>,
}

/// A part of a pack and what is the matter with it.
#[derive(Debug)]
pub struct PackedPart {
    /// Path of the sequence in the folder that was packed.
    pub sequence: String,
    /// The file of it that this part was made of.
    pub file: String,
    /// Rows, where it has any.
    pub rows: Option<usize>,
    /// Bytes in the pack.
    pub bytes: usize,
}

/// An open pack.
#[derive(Debug)]
pub struct DataPack {
    pub(super) file: ColumnFile,
    pub(super) manifest: Manifest,
}

impl DataPack {
    /// Reads a pack's header.
    ///
    /// # Errors
    /// A file that cannot be read, is cut off, is no pack or one of another version, or whose header is damaged.
    pub fn open(path: &Path) -> Result<Self, IoError> {
        let (file, manifest) = ColumnFile::open(path, FORMAT)?;
        Ok(Self { file, manifest })
    }

    /// The folder that was packed, where its images are.
    pub fn folder(&self) -> PathBuf {
        let own = self.file.path().parent().unwrap_or(Path::new(""));
        own.join(&self.manifest.folder)
    }

    /// Its parts, sorted.
    pub fn parts(&self) -> Vec<PackedPart> {
        let mut parts = Vec::new();
        for (key, sequence) in &self.manifest.sequences {
            for file in sequence.files.keys() {
                let begin = format!("{key}/{file}");
                let own = |name: &&str| {
                    name.strip_prefix(&begin).is_some_and(|rest| rest.is_empty() || rest.starts_with('/'))
                };
                let bytes = self.file.names().filter(own).filter_map(|name| self.file.len_of(name)).sum();
                let rows = self.file.len_of(&format!("{begin}/{STAMPS}")).map(|bytes| bytes / 8);
                parts.push(PackedPart { sequence: key.clone(), file: file.clone(), rows, bytes });
            }
        }
        parts
    }
}
