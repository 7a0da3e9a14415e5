//! Columns into a file.

use super::{Body, ColumnFileError, Description, Format, KEY};
use crate::{IoError, atomic_write};
use dpn_core::checksum::of_bytes;
use safetensors::tensor::{Dtype, TensorView};
use serde::Serialize;
use std::collections::BTreeMap;
use std::path::Path;

/// A column on its way into a file.
#[derive(Debug, Clone, PartialEq)]
pub enum Column {
    /// Whole numbers.
    I64(Vec<i64>),
    /// Rows of so many numbers, row by row.
    F64(usize, Vec<f64>),
    /// Text, or anything else.
    Bytes(Vec<u8>),
}

impl Column {
    fn encoded(&self) -> (Dtype, Vec<usize>, Vec<u8>) {
        match self {
            Self::I64(values) => {
                (Dtype::I64, vec![values.len()], values.iter().flat_map(|v| v.to_le_bytes()).collect())
            }
            Self::F64(width, values) => (
                Dtype::F64,
                vec![values.len() / width.max(&1), *width],
                values.iter().flat_map(|v| v.to_le_bytes()).collect(),
            ),
            Self::Bytes(bytes) => (Dtype::U8, vec![bytes.len()], bytes.clone()),
        }
    }
}

/// The bytes of a file with these columns; the same input gives the same bytes. `path` is for messages.
///
/// # Errors
/// Columns that the container does not take.
pub fn to_bytes<T: Serialize>(
    path: &Path,
    format: Format,
    content: &T,
    columns: &BTreeMap<String, Column>,
) -> Result<Vec<u8>, ColumnFileError> {
    let unwritable = |what: String| ColumnFileError::Unwritable { path: path.to_path_buf(), what };
    let encoded: BTreeMap<&str, _> =
        columns.iter().map(|(name, column)| (name.as_str(), column.encoded())).collect();
    let sums = encoded.iter().map(|(name, (_, _, bytes))| ((*name).to_owned(), of_bytes(bytes))).collect();
    let text = |e: serde_json::Error| unwritable(e.to_string());
    let body = serde_json::to_string(&Body { sums, content }).map_err(text)?;
    let description = Description {
        format: format.name.to_owned(),
        version: format.version,
        sha256: of_bytes(body.as_bytes()),
        body,
    };
    let description = serde_json::to_string(&description).map_err(text)?;
    let mut views = Vec::with_capacity(encoded.len());
    for (name, (dtype, shape, bytes)) in &encoded {
        let view = TensorView::new(*dtype, shape.clone(), bytes).map_err(|e| unwritable(e.to_string()))?;
        views.push((*name, view));
    }
    safetensors::serialize(views, Some([(KEY.to_owned(), description)].into_iter().collect()))
        .map_err(|e| unwritable(e.to_string()))
}

/// Writes them to `path`: whole or not at all.
///
/// # Errors
/// As [`to_bytes`] and [`atomic_write`].
pub fn write<T: Serialize>(
    path: &Path,
    format: Format,
    content: &T,
    columns: &BTreeMap<String, Column>,
) -> Result<(), IoError> {
    let bytes = to_bytes(path, format, content, columns)?;
    atomic_write(path, |out| out.write_all(&bytes))
}
