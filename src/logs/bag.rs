//! A bag of any kind, read once through for whoever wants its messages.

use crate::detect::HEAD;
use crate::messages::Messages;
use crate::packed::{Packing, Unpacked};
#[cfg(feature = "images")]
use crate::rosbag2;
use crate::{Kind, LogError, mcap, rosbag1, sqlite};
use dpn_io::IoError;
use std::io::{BufRead, Read};
use std::path::Path;
#[cfg(feature = "images")]
use std::{fs::File, io::BufReader};

/// Reads the bag at `path`, a rosbag2 folder, a file, packed or not, a pipe, or stdin for `-`; `most` as in [`crate::LogOptions::max_uncompressed`].
/// Returns what it is and what was wrong where it ended early.
///
/// # Errors
/// Nothing there; no bag.
#[cfg(feature = "images")]
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
#[cfg(feature = "images")]
pub(crate) fn stream(
    source: impl Read,
    path: &Path,
    most: Option<u64>,
    messages: &mut dyn Messages,
) -> Result<(Kind, Option<String>), LogError> {
    let ((kind, damage), packing) = unpacked(source, path, most, |head, plain, is_file| {
        let kind = Kind::of_head(head, path)?;
        Ok((kind, plainly(kind, BufReader::new(plain), path, is_file, messages)?))
    })?;
    Ok((kind, packing.or(damage)))
}

/// Reads a bag that is not packed; `is_file` where these bytes lie at `path`. Returns what was wrong where it ended early.
///
/// # Errors
/// No bag; a source that cannot be read.
pub(crate) fn plainly(
    kind: Kind,
    source: impl BufRead,
    path: &Path,
    is_file: bool,
    messages: &mut dyn Messages,
) -> Result<Option<String>, LogError> {
    let reading = |e| IoError::reading(path, e);
    match kind {
        Kind::Rosbag1 => Ok(rosbag1::read(source, messages).map_err(reading)?),
        Kind::Mcap => Ok(mcap::read(source, messages).map_err(reading)?),
        Kind::Sqlite if is_file => sqlite::read(path, messages),
        Kind::Sqlite => sqlite::read_stream(source, path, messages),
        kind => Err(LogError::NoBag { path: path.to_path_buf(), kind: kind.name() }),
    }
}

/// Hands `take` the bytes of a source, unpacked where it is packed: its first ones, all of them, and whether they lie at `path` as they are.
/// Returns beside what it made of them why unpacking ended early.
///
/// # Errors
/// `take`'s own; that the packing is damaged, where nothing could be made of what was left.
pub(crate) fn unpacked<T>(
    source: impl Read,
    path: &Path,
    most: Option<u64>,
    take: impl FnOnce(&[u8], &mut dyn Read, bool) -> Result<T, LogError>,
) -> Result<(T, Option<String>), LogError> {
    let (head, mut source) = headed(source, path)?;
    if head.is_empty() {
        return Err(LogError::Empty { path: path.to_path_buf() });
    }
    let Some(packing) = Packing::of(&head) else {
        return Ok((take(&head, &mut source, path.is_file())?, None));
    };
    let mut unpacked = Unpacked::new(packing, source, most);
    let (head, mut plain) = headed(&mut unpacked, path)?;
    let taken = take(&head, &mut plain, false);
    drop(plain);
    match (taken, unpacked.damage()) {
        (Err(_), Some(what)) => Err(LogError::Damaged { path: path.to_path_buf(), what }),
        (taken, damage) => Ok((taken?, damage)),
    }
}

/// The first bytes of a source, and all of it.
pub(crate) fn headed<'a>(
    mut source: impl Read + 'a,
    path: &Path,
) -> Result<(Vec<u8>, impl Read + 'a), LogError> {
    let mut head = Vec::new();
    source.by_ref().take(HEAD).read_to_end(&mut head).map_err(|e| IoError::reading(path, e))?;
    Ok((head.clone(), std::io::Cursor::new(head).chain(source)))
}
