//! What a path holds, by its first bytes or its files.

use crate::packed::Packing;
use crate::two_files::TwoFiles;
use crate::{Kind, LogError, ardupilot, json, rosbag2, ulog};
use dpn_io::asl::{Sequence, discover};
use dpn_io::{IoError, printable};
use std::fs::File;
use std::io::Read;
use std::path::Path;

/// Bytes that tell a file's kind.
pub(crate) const HEAD: u64 = 18;

/// Whether `head` begins an archive, of files or of none.
pub(crate) fn is_zip(head: &[u8]) -> bool {
    head.starts_with(b"PK\x03\x04") || head.starts_with(b"PK\x05\x06")
}

/// The first line of a blackbox's log.
pub(crate) const BLACKBOX: &[u8] = b"H Product:Blackbox";

/// First bytes of what other programs turn into a log, what it is, and how.
const FOREIGN: &[(&[u8], &str, &str)] = &[
    #[cfg(not(feature = "blackbox"))]
    (
        BLACKBOX,
        "a Betaflight blackbox log",
        "decode it by `blackbox_decode --unit-acceleration g FILE` of blackbox-tools, and give the CSV that it writes",
    ),
    (b"%PDF", "a PDF", "give the log itself"),
];

/// Whether `head` begins a video: MP4 and MOV, AVI, Matroska and WebM, MPEG.
fn is_video(head: &[u8]) -> bool {
    head.get(4..8) == Some(b"ftyp")
        || head.starts_with(b"RIFF") && head.get(8..12) == Some(b"AVI ")
        || head.starts_with(b"\x1aE\xdf\xa3")
        || head.starts_with(b"\0\0\x01\xba")
}

impl Kind {
    /// Looks at `path`.
    ///
    /// # Errors
    /// A path that is not there or cannot be read; a folder without a log, or with a compressed bag alone; a file that is packed as a whole.
    pub fn of(path: &Path) -> Result<Self, LogError> {
        if path.is_dir() {
            if Sequence::open(path).is_ok() {
                return Ok(Self::Asl);
            }
            let (bags, packed) = rosbag2::bags(path)?;
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
        } else if is_video(head) {
            Err(LogError::Video { path: path.to_owned() })
        } else if let Some((_, what, remedy)) = FOREIGN.iter().find(|(magic, ..)| is(magic)) {
            Err(LogError::Foreign { path: path.to_owned(), what, remedy })
        } else if json::is(head) {
            Ok(Self::Json)
        } else if json::is_echo(head) {
            Ok(Self::Echo)
        } else if is(BLACKBOX) {
            Ok(Self::Blackbox)
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
