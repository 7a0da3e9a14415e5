//! What can be wrong with a file of columns.

use std::path::PathBuf;
use thiserror::Error;

/// Why a file of columns, or a column of it, cannot be used.
#[derive(Debug, Error)]
pub enum ColumnFileError {
    /// A file of another program, or none of this container at all.
    #[error("{}: {found}, where a {wanted} is needed", path.display())]
    Foreign {
        /// The file.
        path: PathBuf,
        /// What it is.
        found: String,
        /// What it should be.
        wanted: &'static str,
    },
    /// Of another version of the layout.
    #[error("{}: a {format} written as version {found}, and this program reads version {wanted}", path.display())]
    Version {
        /// The file.
        path: PathBuf,
        /// What it is.
        format: &'static str,
        /// Its version.
        found: u64,
        /// The one that is read.
        wanted: u64,
    },
    /// Fewer or more bytes than its header says.
    #[error("{}: cut off: {found} of {wanted} bytes are there", path.display())]
    Length {
        /// The file.
        path: PathBuf,
        /// Bytes that are there.
        found: u64,
        /// Bytes that should be.
        wanted: u64,
    },
    /// A header that does not fit its checksum, or cannot be understood.
    #[error("{}: its header is damaged ({what})", path.display())]
    Header {
        /// The file.
        path: PathBuf,
        /// What is wrong with it.
        what: String,
    },
    /// A column that is missing, has another shape, or does not fit its checksum.
    #[error("{}: `{column}` {what}", path.display())]
    Column {
        /// The file.
        path: PathBuf,
        /// The column.
        column: String,
        /// What is wrong with it.
        what: String,
    },
    /// Columns that do not fit into a file.
    #[error("{}: cannot be put into one file ({what})", path.display())]
    Unwritable {
        /// The file.
        path: PathBuf,
        /// Why.
        what: String,
    },
}

impl ColumnFileError {
    /// What to do about it.
    pub fn hint(&self) -> &'static str {
        match self {
            Self::Foreign { .. } => "name a folder of sequences, or a file that `dpn data pack` wrote",
            Self::Version { .. } => "pack the data again with this program",
            Self::Length { .. } | Self::Header { .. } | Self::Column { .. } => {
                "copy the file again, or pack the data again; `dpn data check FILE` says what is whole"
            }
            Self::Unwritable { .. } => "pack fewer sequences into one file",
        }
    }
}
