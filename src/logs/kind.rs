//! What a path holds, by its first bytes or its files.

use crate::packed::Packing;
use crate::two_files::TwoFiles;
use crate::{LogError, ardupilot, ulog};
use dpn_io::asl::{Sequence, discover};
use dpn_io::{IoError, printable};
use serde::Serialize;
use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};

/// Bytes that tell a file's kind.
pub(crate) const HEAD: u64 = 18;

/// Whether `head` begins an archive, of files or of none.
pub(crate) fn is_zip(head: &[u8]) -> bool {
    head.starts_with(b"PK\x03\x04") || head.starts_with(b"PK\x05\x06")
}

/// A kind of log.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Kind {
    /// A folder with `imu0/data.csv`.
    Asl,
    /// A text file.
    Csv,
    /// A ROS 1 bag.
    Rosbag1,
    /// An MCAP file.
    Mcap,
    /// One of rosbag2's SQLite files.
    Sqlite,
    /// A rosbag2 folder.
    Rosbag2,
    /// A folder with a file for each sensor, as phones write them.
    TwoFiles,
    /// PX4's ULog.
    Ulog,
    /// ArduPilot's binary log.
    Ardupilot,
    /// ArduPilot's log as text.
    ArdupilotText,
}

impl Kind {
    /// Its name for people.
    pub fn name(self) -> &'static str {
        match self {
            Self::Asl => "ASL folder",
            Self::Csv => "CSV file",
            Self::Rosbag1 => "rosbag1",
            Self::Mcap => "MCAP file",
            Self::Sqlite => "rosbag2 SQLite file",
            Self::Rosbag2 => "rosbag2 folder",
            Self::TwoFiles => "folder of two files",
            Self::Ulog => "ULog",
            Self::Ardupilot => "ArduPilot log",
            Self::ArdupilotText => "ArduPilot text log",
        }
    }

    /// Looks at `path`.
    ///
    /// # Errors
    /// A path that is not there or cannot be read; a folder without a log, or with a compressed bag alone; a file that is packed as a whole.
    pub fn of(path: &Path) -> Result<Self, LogError> {
        if path.is_dir() {
            if Sequence::open(path).is_ok() {
                return Ok(Self::Asl);
            }
            let (bags, packed) = bags(path)?;
            return match (bags.first(), packed) {
                (Some(_), _) => Ok(Self::Rosbag2),
                (None, Some(path)) => Err(LogError::Packed { path }),
                (None, None) if TwoFiles::find(path)?.is_some() => Ok(Self::TwoFiles),
                (None, None) => Err(LogError::NoLog {
                    dir: path.to_owned(),
                    below: match discover(path) {
                        Ok(all) => all.iter().map(|s| s.dir().to_owned()).collect(),
                        Err(IoError::NoSequence { .. }) => Vec::new(),
                        Err(error) => return Err(error.into()),
                    },
                }),
            };
        }
        let mut head = Vec::new();
        let reading = |e| IoError::reading(path, e);
        File::open(path).map_err(reading)?.take(HEAD).read_to_end(&mut head).map_err(reading)?;
        Self::of_head(&head, path)
    }

    /// The same for a file or a stream by its first [`HEAD`] bytes; `path` is for messages and for the end of its name.
    pub(crate) fn of_head(head: &[u8], path: &Path) -> Result<Self, LogError> {
        let is = |magic: &[u8]| head.starts_with(magic);
        if is(b"#ROSBAG V2.0\n") {
            Ok(Self::Rosbag1)
        } else if is(b"\x89MCAP") {
            Ok(Self::Mcap)
        } else if is(b"SQLite format 3\0") {
            Ok(Self::Sqlite)
        } else if Packing::of(head).is_some() {
            Err(LogError::Packed { path: path.to_owned() })
        } else if is_zip(head) {
            Err(LogError::Zipped { path: path.to_owned() })
        } else if is(ulog::MAGIC) {
            Ok(Self::Ulog)
        } else if is(ardupilot::MAGIC) {
            Ok(Self::Ardupilot)
        } else if ardupilot::is_text(head) {
            Ok(Self::ArdupilotText)
        } else if is(b"#ROSBAG V") {
            let what = format!(
                "a bag of version {}; only 2.0 is known",
                printable(&String::from_utf8_lossy(head.get(9..12).unwrap_or_default()))
            );
            Err(LogError::Damaged { path: path.to_owned(), what })
        } else {
            match path.extension().and_then(|e| e.to_str()) {
                Some(end @ ("bag" | "mcap" | "db3" | "ulg")) => {
                    let what = format!("does not begin as a {end} file does");
                    Err(LogError::Damaged { path: path.to_owned(), what })
                }
                _ => Ok(Self::Csv),
            }
        }
    }
}

/// The bag files of a folder in the order in which they were written, and one that is packed.
pub(crate) fn bags(dir: &Path) -> Result<(Vec<PathBuf>, Option<PathBuf>), IoError> {
    let reading = |e| IoError::reading(dir, e);
    let (mut files, mut packed) = (Vec::new(), None);
    for entry in std::fs::read_dir(dir).map_err(reading)? {
        let path = entry.map_err(reading)?.path();
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
