//! A bag of any kind, read once through for whoever wants its messages.

use crate::messages::Messages;
use crate::packed::{Packing, Unpacked};
use crate::read::headed;
use crate::{Kind, LogError, mcap, rosbag1, rosbag2, sqlite};
use dpn_io::{IoError, scratch_file};
use std::fs::File;
use std::io::{BufReader, Read};
use std::path::Path;

/// Reads the bag at `path`, a rosbag2 folder, a file, packed or not, a pipe, or stdin for `-`; `most` as in [`crate::LogOptions::max_uncompressed`].
/// Returns what it is and what was wrong where it ended early.
///
/// # Errors
/// Nothing there; no bag.
pub(crate) fn read(
    path: &Path,
    most: Option<u64>,
    messages: &mut dyn Messages,
) -> Result<(Kind, Option<String>), LogError> {
    let reading = |e| IoError::reading(path, e);
    if path == Path::new("-") {
        return stream(std::io::stdin().lock(), Path::new("stdin"), most, messages);
    }
    if path.is_dir() {
        return match Kind::of(path)? {
            Kind::Rosbag2 => Ok((Kind::Rosbag2, rosbag2::read(path, messages)?)),
            kind => Err(LogError::NoBag { path: path.to_path_buf(), kind: kind.name() }),
        };
    }
    stream(File::open(path).map_err(reading)?, path, most, messages)
}

/// The same from bytes as they come.
pub(crate) fn stream(
    source: impl Read,
    path: &Path,
    most: Option<u64>,
    messages: &mut dyn Messages,
) -> Result<(Kind, Option<String>), LogError> {
    let (head, source) = headed(source, path)?;
    let Some(packing) = Packing::of(&head) else {
        return plain(&head, source, path, path.is_file(), messages);
    };
    let mut unpacked = Unpacked::new(packing, source, most);
    let (head, source) = headed(&mut unpacked, path)?;
    let (kind, damage) = plain(&head, source, path, false, messages)?;
    Ok((kind, unpacked.damage().or(damage)))
}

fn plain(
    head: &[u8],
    source: impl Read,
    path: &Path,
    is_file: bool,
    messages: &mut dyn Messages,
) -> Result<(Kind, Option<String>), LogError> {
    let reading = |e| IoError::reading(path, e);
    let mut source = BufReader::new(source);
    let kind = Kind::of_head(head, path)?;
    let damage = match kind {
        Kind::Rosbag1 => rosbag1::read(source, messages).map_err(reading)?,
        Kind::Mcap => mcap::read(source, messages).map_err(reading)?,
        Kind::Sqlite if is_file => sqlite::read(path, messages),
        Kind::Sqlite => {
            let mut copy = scratch_file().map_err(reading)?;
            std::io::copy(&mut source, &mut copy).map_err(reading)?;
            sqlite::read(copy.path(), messages)
        }
        kind => return Err(LogError::NoBag { path: path.to_path_buf(), kind: kind.name() }),
    };
    Ok((kind, damage))
}
