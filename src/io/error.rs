//! What can be wrong with a file, and what to do about it.

use crate::printable;
use crate::row_fault::RowFault;
use std::io;
use std::path::{Path, PathBuf};
use thiserror::Error;

/// Why a file or a folder could not be read or written. `Display` says what and where, [`IoError::hint`] how to mend it.
///
/// Lines are counted from 1, as editors do.
#[derive(Debug, Error)]
pub enum IoError {
    /// The operating system refused to read.
    #[error("cannot read {}", path.display())]
    Read {
        /// File or folder.
        path: PathBuf,
        /// The system's reason.
        source: io::Error,
    },
    /// The operating system refused to write; nothing half-written is left.
    #[error("cannot write {}", path.display())]
    Write {
        /// The file that should have come to be.
        path: PathBuf,
        /// The system's reason.
        source: io::Error,
    },
    /// A link, or what is no regular file, where a file or folder of results is or should be.
    #[error("{}: {what}, and results are neither read nor written through one", path.display())]
    InTheWay {
        /// It.
        path: PathBuf,
        /// What it is.
        what: &'static str,
    },
    /// A name of a file of results that is not below its folder.
    #[error("{} is not below {}, where results lie", path.display(), dir.display())]
    LeadsOut {
        /// The name.
        path: PathBuf,
        /// The folder.
        dir: PathBuf,
    },
    /// A folder, or a file of it, that is not there.
    #[error("{} does not exist", path.display())]
    Missing {
        /// What was looked for.
        path: PathBuf,
    },
    /// No sequence where some were looked for.
    #[error("no ASL sequence in {}: looked for {looked_for}", dir.display())]
    NoSequence {
        /// Where.
        dir: PathBuf,
        /// The patterns tried, relative to `dir`.
        looked_for: String,
    },
    /// A file without one row of data.
    #[error("{}: no row of data", path.display())]
    Empty {
        /// The file.
        path: PathBuf,
    },
    /// A recording of one sample.
    #[error("{}: {found} sample; a recording needs at least 2", path.display())]
    TooShort {
        /// The file.
        path: PathBuf,
        /// How many samples it holds.
        found: usize,
    },
    /// A recording whose samples share one stamp.
    #[error("{}: {found} samples have one stamp", path.display())]
    OneStamp {
        /// The file.
        path: PathBuf,
        /// How many samples.
        found: usize,
    },
    /// A recording of hardly a sample whose values are measurements.
    #[error("{}: {left} samples have NaN, infinite or absurd values, and {found} is left", path.display())]
    NoValues {
        /// The file.
        path: PathBuf,
        /// How many samples are left out.
        left: usize,
        /// How many samples it holds else.
        found: usize,
    },
    /// A row or a header that cannot be.
    #[error("{}:{line}: {fault}", path.display())]
    Row {
        /// The file.
        path: PathBuf,
        /// The line.
        line: usize,
        /// What is wrong with it.
        fault: RowFault,
    },
    /// Stamps that go back again and again.
    #[error("{}: time goes back at {count} of {of} samples, first at line {line}", path.display())]
    GoesBack {
        /// The file.
        path: PathBuf,
        /// How many samples.
        count: usize,
        /// Of how many.
        of: usize,
        /// The first one's line.
        line: u64,
    },
    /// Neither the header nor the stamps' size tell their unit.
    #[error("{}: the unit of time cannot be told: stamps from {first}, median step {step}", path.display())]
    UnknownTimeUnit {
        /// The file.
        path: PathBuf,
        /// The first stamp, as a number.
        first: f64,
        /// The median step between stamps, as a number.
        step: f64,
    },
    /// Stamps that could count in one unit or another, or that count rows.
    #[error("{}: stamps from {first} in steps of {step} could be {readings}", path.display())]
    SeveralTimeUnits {
        /// The file.
        path: PathBuf,
        /// The first stamp, as a number.
        first: f64,
        /// The median step between stamps, as a number.
        step: f64,
        /// What they could be, each with its rate.
        readings: String,
    },
    /// A file that is too large for what it should be.
    #[error("{}: more than {most} bytes; no {what} is as large", path.display())]
    TooLarge {
        /// The file.
        path: PathBuf,
        /// What it should be.
        what: &'static str,
        /// Bytes that are read.
        most: u64,
    },
    /// A YAML file that cannot be read or lacks a key.
    #[error("{}: {message}", at(path, *line))]
    BadYaml {
        /// The file.
        path: PathBuf,
        /// The line, where the parser knows one.
        line: Option<usize>,
        /// What is wrong, without the place.
        message: String,
    },
    /// An image that is not the camera's.
    #[error("{} {problem}", path.display())]
    BadImage {
        /// The file.
        path: PathBuf,
        /// What is wrong with it.
        problem: String,
    },
    /// A list of images that is longer or shorter than the folder beside it.
    #[error("{} lists {listed} images, and images/ beside it holds {found}", path.display())]
    TimesDiffer {
        /// The list.
        path: PathBuf,
        /// How many it lists.
        listed: usize,
        /// How many images there are.
        found: usize,
    },
    /// A key of a YAML file with a value that cannot be.
    #[error("{}: `{key}` {problem}", path.display())]
    BadKey {
        /// The file.
        path: PathBuf,
        /// The key.
        key: &'static str,
        /// What is wrong with its value.
        problem: String,
    },
}

fn at(path: &Path, line: Option<usize>) -> String {
    match line {
        Some(line) => format!("{}:{line}", path.display()),
        None => path.display().to_string(),
    }
}

/// What is wrong and what it comes from, in one line.
pub fn in_full(error: &dyn std::error::Error) -> String {
    let mut text = error.to_string();
    let mut cause = error.source();
    while let Some(inner) = cause {
        let more = inner.to_string();
        if !text.contains(&more) {
            text = format!("{text}: {more}");
        }
        cause = inner.source();
    }
    text
}

impl IoError {
    /// What is wrong with line `line` of `path`.
    pub(crate) fn row(path: &Path, line: usize, fault: RowFault) -> Self {
        Self::Row { path: path.to_path_buf(), line, fault }
    }

    /// Wraps a failure to read: a thing that is not there is [`IoError::Missing`], all else [`IoError::Read`].
    pub fn reading(path: &Path, source: io::Error) -> Self {
        let path = path.to_path_buf();
        if source.kind() == io::ErrorKind::NotFound {
            Self::Missing { path }
        } else {
            Self::Read { path, source }
        }
    }

    /// What to do about it, where there is more to say than the message itself does.
    pub fn hint(&self) -> Option<String> {
        let text = match self {
            Self::Read { path, source } => match source.kind() {
                io::ErrorKind::NotADirectory => {
                    let file = path.ancestors().find(|part| part.is_file())?;
                    let file = printable(&file.display().to_string());
                    return Some(format!("{file} is a file; name a folder in which the file above lies"));
                }
                io::ErrorKind::PermissionDenied => "you lack the right to read it; see its owner and mode",
                io::ErrorKind::IsADirectory => "this is a folder; name a file in it",
                _ => return None,
            },
            Self::Write { source, .. } => match source.kind() {
                io::ErrorKind::StorageFull => "the disk is full; free some space or write elsewhere",
                io::ErrorKind::PermissionDenied | io::ErrorKind::ReadOnlyFilesystem => {
                    "you lack the right to write there; choose another folder"
                }
                _ => return None,
            },
            Self::InTheWay { .. } => "see who put it there; remove it and run the same again",
            Self::LeadsOut { .. } => {
                "see who wrote that name; remove the file that holds it and make it again"
            }
            Self::Missing { path } => return missing_hint(path),
            Self::NoSequence { .. } => {
                "give the folder of one sequence (it holds `mav0` or `imu0`) or one that holds sequences; a folder of images needs `times.txt` (id and timestamp a line) and `imu.txt` or `imu.csv`"
            }
            Self::Empty { .. } => "the download or export may have been cut off; make the file again",
            Self::TooShort { .. } => "record for longer, or look whether the file was cut off",
            Self::NoValues { .. } => {
                "look at what wrote them, and say which columns are meant: --columns T,GX,GY,GZ,AX,AY,AZ"
            }
            Self::OneStamp { .. } => "write stamps with more digits, or count the samples: --rate HZ",
            Self::GoesBack { .. } => {
                "sort the rows by time, or cut the log where its clock was set; or count the samples (--rate HZ)"
            }
            Self::Row { fault, .. } => fault.hint(),
            Self::UnknownTimeUnit { .. } => {
                "name the stamps' unit (--time-unit s, ms, us, ns), or their column: --columns T,GX,GY,GZ,AX,AY,AZ"
            }
            Self::SeveralTimeUnits { .. } => {
                "name the stamps' unit: --time-unit; of a log whose stamps count rows its rate: --rate HZ"
            }
            Self::BadImage { .. } => {
                "unpack or record the image again, or convert it to PNG or JPEG of the calibration's size"
            }
            Self::TimesDiffer { .. } => {
                "take the list that belongs to these images, unpack the rest, or use what both have with --skip-missing"
            }
            Self::TooLarge { .. } => "name the configuration itself, not a log or a bag",
            Self::BadYaml { .. } | Self::BadKey { .. } => {
                "compare with an ASL sensor.yaml; without the file the caller's defaults hold"
            }
        };
        Some(text.to_owned())
    }
}

/// Names the nearest folder above `path` that is there.
fn missing_hint(path: &Path) -> Option<String> {
    let there = path.ancestors().skip(1).find(|p| !p.as_os_str().is_empty() && p.exists());
    Some(match there {
        Some(there) => format!("{} is there; look at the rest of the path", there.display()),
        None => {
            "it is looked for in the folder you are in; look at its name, or give the whole path".to_owned()
        }
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_path_that_is_not_there_names_the_part_that_is() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("no").join("such");
        let error = IoError::reading(&path, io::ErrorKind::NotFound.into());
        assert!(error.to_string().ends_with("no/such does not exist"), "{error}");
        let hint = error.hint().unwrap();
        assert!(hint.starts_with(&format!("{} is there", dir.path().display())), "{hint}");
    }

    #[test]
    fn a_file_that_is_taken_for_a_folder_is_named() {
        let dir = tempfile::tempdir().unwrap();
        let file = dir.path().join("truth.csv");
        std::fs::write(&file, "t").unwrap();
        let within = file.join("MH_01.csv");
        let error = IoError::reading(&within, std::fs::read(&within).unwrap_err());
        let hint = error.hint().unwrap();
        assert!(hint.starts_with(&format!("{} is a file", file.display())), "{hint}");
    }

    #[test]
    fn a_full_disk_is_told_from_a_missing_right() {
        let path = PathBuf::from("out.csv");
        let full = IoError::Write { path: path.clone(), source: io::ErrorKind::StorageFull.into() };
        let denied = IoError::Write { path, source: io::ErrorKind::PermissionDenied.into() };
        assert!(full.hint().unwrap().contains("disk is full"));
        assert!(denied.hint().unwrap().contains("right to write"));
    }
}
