//! From a file to figures.

use super::calibration::{Given, NoiseCalibration};
use super::error::FormatError;
use super::format::Format;
use super::tree::Tree;
use super::{datasheet, imu_utils, kalibr_results, keyed, ros, vins, xrslam};
use crate::small::{read_config, read_config_from};
use std::path::Path;

/// Reads the configuration at `path`, or on stdin for `-`; without a format, by the keys it has.
///
/// # Errors
/// A file that cannot be read or is no YAML or JSON; keys that are missing; numbers that no noise has; per-sample numbers without a rate.
pub fn read(path: &Path, format: Option<Format>, given: &Given) -> Result<NoiseCalibration, FormatError> {
    if path == Path::new("-") {
        let stdin = Path::new("stdin");
        return parse(&read_config_from(std::io::stdin().lock(), stdin)?, stdin, format, given);
    }
    parse(&read_config(path)?, path, format, given)
}

/// The same from bytes at hand; `path` is for messages.
///
/// # Errors
/// As [`read`].
pub fn parse(
    bytes: &[u8],
    path: &Path,
    format: Option<Format>,
    given: &Given,
) -> Result<NoiseCalibration, FormatError> {
    let results = kalibr_results::as_yaml(bytes);
    let tree = Tree::parse(results.as_ref().map_or(bytes, |text| text.as_bytes()), path)?;
    let known = imu_utils::read(&tree, path, given)?
        .map_or_else(|| xrslam::read(&tree, path, given), |known| Ok(Some(known)))?;
    if let Some(mut source) = known {
        source.take(given)?;
        return Ok(source);
    }
    let Some(format) = format.or_else(|| Format::of(&tree)) else {
        let known: Vec<&str> = Format::ALL.into_iter().flat_map(Format::own_keys).collect();
        return Err(FormatError::NoFormat {
            path: path.to_path_buf(),
            nearest: keyed::slip(&tree, known.iter().copied(), &known),
        });
    };
    let read = match (format, format.layout()) {
        (_, Some(layout)) => keyed::read(&tree, format, layout, path, given),
        (Format::Ros, None) => ros::read(&tree, path, given),
        (_, None) => datasheet::read(&tree, path, given),
    };
    let mut source = read.map_err(|error| rather(error, &format.own_keys(), Format::of(&tree)))?;
    if format == Format::Vins {
        source.remarks.extend(vins::was_read(&source.figures));
    }
    source.take(given)?;
    Ok(source)
}

/// An error that names `other`, whose keys the file has, where it has none of `own`.
fn rather(error: FormatError, own: &[&str], other: Option<Format>) -> FormatError {
    match error {
        FormatError::Missing { path, from, missing, figures, .. }
            if missing.len() == own.len() && other.is_some_and(|other| other != from) =>
        {
            FormatError::Missing { path, from, missing, figures, nearest: None, rather: other }
        }
        error => error,
    }
}
