//! Columns out of a file, one at a time.

use super::{Body, ColumnFileError, Description, Format, KEY};
use crate::IoError;
use dpn_core::checksum::of_bytes;
use safetensors::tensor::{Dtype, Metadata};
use serde::de::DeserializeOwned;
use std::collections::BTreeMap;
use std::fs::File;
use std::io::{Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};

/// The container's own bound on headers \[bytes\].
const LARGEST_HEADER: u64 = 100_000_000;

/// A file of columns, its header read.
#[derive(Debug, Clone)]
pub struct ColumnFile {
    path: PathBuf,
    columns: BTreeMap<String, Place>,
}

/// Where a column is and what it should be.
#[derive(Debug, Clone)]
struct Place {
    dtype: Dtype,
    shape: Vec<usize>,
    from: u64,
    len: usize,
    sha256: String,
}

impl ColumnFile {
    /// Whether a file begins as one of this container does: the length of a header, and the header's first sign.
    pub fn is_one(path: &Path) -> bool {
        let mut head = [0; 9];
        // Opening a pipe would wait for a writer.
        let whole =
            path.is_file() && File::open(path).and_then(|mut file| file.read_exact(&mut head)).is_ok();
        let [len @ .., brace] = head;
        whole && brace == b'{' && u64::from_le_bytes(len) <= LARGEST_HEADER
    }

    /// Reads a header: the columns there are, and what the format says of itself.
    ///
    /// # Errors
    /// A file that cannot be read, is cut off, is of another format or version, or whose header is damaged.
    pub fn open<T: DeserializeOwned>(path: &Path, format: Format) -> Result<(Self, T), IoError> {
        let reading = |e| IoError::reading(path, e);
        let foreign = |found: &str| ColumnFileError::Foreign {
            path: path.to_path_buf(),
            found: found.to_owned(),
            wanted: format.name,
        };
        let damaged = |what: String| ColumnFileError::Header { path: path.to_path_buf(), what };
        let cut = |found, wanted| ColumnFileError::Length { path: path.to_path_buf(), found, wanted };
        let mut file = File::open(path).map_err(reading)?;
        let found = file.metadata().map_err(reading)?.len();
        let mut len = [0; 8];
        if found < 9 {
            return Err(foreign(&format!("a file of {found} bytes")).into());
        }
        file.read_exact(&mut len).map_err(reading)?;
        let len = u64::from_le_bytes(len);
        if len > LARGEST_HEADER {
            return Err(foreign("a file of another kind").into());
        }
        if len + 8 > found {
            return Err(cut(found, len + 8).into());
        }
        let mut header = Vec::new();
        file.take(len).read_to_end(&mut header).map_err(reading)?;
        if header.first() != Some(&b'{') {
            return Err(foreign("a file of another kind").into());
        }
        let metadata: Metadata = serde_json::from_slice(&header).map_err(|e| damaged(e.to_string()))?;
        let text = metadata.metadata().as_ref().and_then(|all| all.get(KEY));
        let text = text.ok_or_else(|| foreign("a safetensors file without dpn's description"))?;
        let description: Description = serde_json::from_str(text).map_err(|e| damaged(e.to_string()))?;
        if description.format != format.name {
            return Err(foreign(&format!("a {}", crate::printable(&description.format))).into());
        }
        if description.version != format.version {
            return Err(ColumnFileError::Version {
                path: path.to_path_buf(),
                format: format.name,
                found: description.version,
                wanted: format.version,
            }
            .into());
        }
        if of_bytes(description.body.as_bytes()) != description.sha256 {
            return Err(damaged("its checksum does not fit".to_owned()).into());
        }
        let wanted = len + 8 + metadata.data_len() as u64;
        if wanted != found {
            return Err(cut(found, wanted).into());
        }
        let body: Body<T> = serde_json::from_str(&description.body).map_err(|e| damaged(e.to_string()))?;
        let mut there = metadata.tensors();
        let mut columns = BTreeMap::new();
        for (name, sha256) in body.sums {
            let Some(info) = there.remove(&name) else {
                return Err(missing(path, &name).into());
            };
            let (from, to) = info.data_offsets;
            let place = Place {
                dtype: info.dtype,
                shape: info.shape.clone(),
                from: len + 8 + from as u64,
                len: to - from,
                sha256,
            };
            columns.insert(name, place);
        }
        if let Some(name) = there.keys().min() {
            return Err(damaged(format!("`{}` has no checksum", crate::printable(name))).into());
        }
        Ok((Self { path: path.to_path_buf(), columns }, body.content))
    }

    /// The file.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Names of the columns, sorted.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        self.columns.keys().map(String::as_str)
    }

    /// Bytes of a column; none where there is no such column.
    pub fn len_of(&self, name: &str) -> Option<usize> {
        self.columns.get(name).map(|place| place.len)
    }

    /// Reads a column and holds it to its checksum.
    ///
    /// # Errors
    /// No such column, one that cannot be read, or one that is damaged.
    pub fn check(&self, name: &str) -> Result<(), IoError> {
        self.raw(name).map(|_| ())
    }

    /// A column of whole numbers.
    ///
    /// # Errors
    /// As [`check`](Self::check); a column of another kind.
    pub fn i64s(&self, name: &str) -> Result<Vec<i64>, IoError> {
        let (place, bytes) = self.raw(name)?;
        if place.dtype != Dtype::I64 || place.shape.len() != 1 {
            return Err(self.other(name, place, "whole numbers are").into());
        }
        Ok(bytes.as_chunks::<8>().0.iter().map(|b| i64::from_le_bytes(*b)).collect())
    }

    /// A column of rows: how many numbers a row has, and the numbers, row by row.
    ///
    /// # Errors
    /// As [`check`](Self::check); a column of another kind.
    pub fn f64s(&self, name: &str) -> Result<(usize, Vec<f64>), IoError> {
        let (place, bytes) = self.raw(name)?;
        let &[_, width] = &place.shape[..] else {
            return Err(self.other(name, place, "rows of numbers are").into());
        };
        if place.dtype != Dtype::F64 {
            return Err(self.other(name, place, "rows of numbers are").into());
        }
        Ok((width, bytes.as_chunks::<8>().0.iter().map(|b| f64::from_le_bytes(*b)).collect()))
    }

    /// A column of bytes.
    ///
    /// # Errors
    /// As [`check`](Self::check); a column of another kind.
    pub fn bytes(&self, name: &str) -> Result<Vec<u8>, IoError> {
        let (place, bytes) = self.raw(name)?;
        if place.dtype != Dtype::U8 {
            return Err(self.other(name, place, "bytes are").into());
        }
        Ok(bytes)
    }

    fn raw(&self, name: &str) -> Result<(&Place, Vec<u8>), IoError> {
        let place = self.columns.get(name).ok_or_else(|| missing(&self.path, name))?;
        let reading = |e| IoError::reading(&self.path, e);
        let mut file = File::open(&self.path).map_err(reading)?;
        file.seek(SeekFrom::Start(place.from)).map_err(reading)?;
        let mut bytes = Vec::with_capacity(place.len);
        file.take(place.len as u64).read_to_end(&mut bytes).map_err(reading)?;
        if of_bytes(&bytes) != place.sha256 {
            return Err(self.column(name, "is damaged: its checksum does not fit".to_owned()).into());
        }
        Ok((place, bytes))
    }

    fn other(&self, name: &str, place: &Place, wanted: &str) -> ColumnFileError {
        self.column(name, format!("is {:?} {:?}, where {wanted} needed", place.dtype, place.shape))
    }

    /// A fault of a column that its format finds.
    pub fn column(&self, name: &str, what: String) -> ColumnFileError {
        ColumnFileError::Column { path: self.path.clone(), column: crate::printable(name), what }
    }
}

fn missing(path: &Path, name: &str) -> ColumnFileError {
    let column = crate::printable(name);
    ColumnFileError::Column { path: path.to_path_buf(), column, what: "is missing".to_owned() }
}
