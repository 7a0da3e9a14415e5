//! What can be wrong with a configuration's noise figures, and what to do about it.

use super::format::Format;
use super::key_fault::KeyFault;
use super::quantity::QuantityError;
use crate::IoError;
use dpn_core::config::did_you_mean;
use dpn_core::noise::Figure;
use std::fmt;
use std::path::{Path, PathBuf};
use thiserror::Error;

/// A key that may be another one mistyped.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Slip {
    /// Where it stands.
    pub line: usize,
    /// As written.
    pub typed: String,
    /// What it may have meant.
    pub known: String,
}

impl fmt::Display for Slip {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "line {} has `{}`; {}", self.line, self.typed, did_you_mean(&self.known))
    }
}

/// Why noise figures could not be read or written. `Display` says what and where, [`FormatError::hint`] how to mend it.
#[derive(Debug, Error)]
pub enum FormatError {
    /// The file cannot be read.
    #[error(transparent)]
    Io(#[from] IoError),
    /// Text without a key.
    #[error("{}: holds no keys", path.display())]
    NoKeys {
        /// The file.
        path: PathBuf,
    },
    /// A file with the keys of no format.
    #[error("{}: no keys of a known format", path.display())]
    NoFormat {
        /// The file.
        path: PathBuf,
        /// A key that is nearly one of a format.
        nearest: Option<Box<Slip>>,
    },
    /// Keys of the format that are not in the file.
    #[error("{}: no {}, which {from} needs", path.display(), quoted(missing))]
    Missing {
        /// The file.
        path: PathBuf,
        /// The format it was read as.
        from: Format,
        /// The keys that are not there.
        missing: Vec<String>,
        /// Their figures.
        figures: Vec<Figure>,
        /// A key of the file that is nearly one of them.
        nearest: Option<Box<Slip>>,
        /// Another format whose keys the file has.
        rather: Option<Format>,
    },
    /// A key whose value cannot be, or that is none.
    #[error("{}: `{key}` {fault}", at(path, Some(*line)))]
    Key {
        /// The file.
        path: PathBuf,
        /// The line.
        line: usize,
        /// The key.
        key: String,
        /// What is wrong with it.
        fault: KeyFault,
    },
    /// A number with a unit that cannot be used.
    #[error("{place}: {problem}")]
    Quantity {
        /// File, line and key, or the flag.
        place: String,
        /// What is wrong with it.
        problem: QuantityError,
    },
    /// Numbers per sample without a rate.
    #[error("{format} has its figures per sample; the rate of the samples is needed")]
    NeedsRate {
        /// The format.
        format: Format,
    },
    /// Nothing to convert.
    #[error("no noise figure was given")]
    Nothing,
}

pub(super) fn at(path: &Path, line: Option<usize>) -> String {
    match line {
        Some(line) if line > 0 => format!("{}:{line}", path.display()),
        _ => path.display().to_string(),
    }
}

fn quoted(keys: &[String]) -> String {
    let keys: Vec<String> = keys.iter().map(|key| format!("`{key}`")).collect();
    keys.join(", ")
}

impl FormatError {
    pub(super) fn key(path: &Path, line: usize, key: &str, fault: KeyFault) -> Self {
        Self::Key { path: path.to_path_buf(), line, key: key.to_owned(), fault }
    }

    /// What to do about it.
    pub fn hint(&self) -> Option<String> {
        let text = match self {
            Self::Io(IoError::BadYaml { .. }) => {
                "a configuration is YAML or JSON; mend the line, or cut the file down to its IMU part"
                    .to_owned()
            }
            Self::Io(error) => return error.hint(),
            Self::NoKeys { .. } => format!("known formats are {}", Format::names()),
            Self::NoFormat { nearest: Some(slip), .. } => slip.to_string(),
            Self::NoFormat { .. } => format!("known are {}; name one with --from", Format::names()),
            Self::Missing { nearest: Some(slip), .. } => slip.to_string(),
            Self::Missing { rather: Some(rather), .. } => {
                format!("the file has the keys of {rather}: say --from {rather}")
            }
            Self::Missing { figures, .. } => {
                let flags: Vec<String> = figures.iter().map(|f| format!("--{} NUMBER", f.flag())).collect();
                format!("add the key, or give {} (densities, or with a unit)", flags.join(" "))
            }
            Self::Key { key, fault, .. } => fault.hint(key),
            Self::Quantity { problem, .. } => problem.hint().to_owned(),
            Self::NeedsRate { .. } => "add --rate HZ".to_owned(),
            Self::Nothing => {
                "name a file, or give --accel-noise, --gyro-noise, --accel-walk, --gyro-walk".to_owned()
            }
        };
        Some(text)
    }
}
