//! A data set in one read-only file: what thousands of processes open without parsing a row over a network's file system.
//!
//! A pack is a [column file](crate::column_file): of every sequence the samples, ground truth and stamps of the camera as columns of the numbers that the
//! readers here make of its files, calibrations as the text they are, and beside each the checksum of the file it was made of. So a sequence gives the
//! same bits from either, and results that are named by their inputs have the same names.
//!
//! Images are not in it, they stay in the folder that was packed: a PNG is one file that is read once through, so there is nothing to save, and a data set's
//! images are a thousand times the rest. The pack says where that folder is, relative to itself where it lies beside or above it.

mod discover;
mod faults;
mod manifest;
mod packed;
mod write;

pub(super) use discover::{discover, open, split};
pub use discover::{is_there, set_name};
pub use manifest::{DataPack, PackedPart};
pub(super) use packed::Packed;
pub use write::pack;

use crate::column_file::Format;

/// What a pack is.
const FORMAT: Format = Format { name: "data pack", version: 1 };
/// Column of stamps \[ns\].
const STAMPS: &str = "t_ns";
/// Column of numbers.
const VALUES: &str = "values";
/// Column of image files' names, a line each.
const NAMES: &str = "names";

#[cfg(test)]
mod tests;
