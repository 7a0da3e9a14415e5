//! What ASL's `sensor.yaml` files have in common: reading, the pose `T_BS`, the rate.

use crate::pose::rigid;
use crate::row_fault::RowFault;
use crate::{IoError, printable};
use dpn_core::time::SampleRate;
use nalgebra::Isometry3;
use serde::Deserialize;
use serde::de::DeserializeOwned;
use std::path::Path;

/// A matrix as the files write it: row by row in `data`.
#[derive(Debug, Deserialize)]
pub(super) struct Matrix {
    data: Vec<f64>,
}

pub(super) fn parse<T: DeserializeOwned>(bytes: &[u8], path: &Path) -> Result<T, IoError> {
    let text = std::str::from_utf8(bytes).map_err(|error| {
        let line = 1 + memchr::memchr_iter(b'\n', &bytes[..error.valid_up_to()]).count();
        IoError::row(path, line, RowFault::NotUtf8)
    })?;
    serde_saphyr::from_str(text).map_err(|error| {
        let whole = error.without_snippet().to_string();
        let first = whole.lines().next().unwrap_or_default();
        IoError::BadYaml {
            path: path.to_path_buf(),
            line: error.location().and_then(|at| usize::try_from(at.line()).ok()).filter(|line| *line > 0),
            message: printable(
                first.split(" at line ").next().unwrap_or(first).trim_start_matches("error: "),
            ),
        }
    })
}

/// The `T_BS` of a sensor: maps points in the sensor's frame to the body's.
///
/// # Errors
/// No finite numbers of a rigid motion.
pub(super) fn body_from_sensor(matrix: &Matrix, path: &Path) -> Result<Isometry3<f64>, IoError> {
    let bad = |problem| IoError::BadKey { path: path.to_path_buf(), key: "T_BS", problem };
    rigid(&matrix.data).map_err(bad)
}

/// The key `rate_hz`.
///
/// # Errors
/// A rate that is not positive and finite.
pub(super) fn rate(hz: f64, path: &Path) -> Result<SampleRate, IoError> {
    SampleRate::from_hz(hz).ok_or_else(|| IoError::BadKey {
        path: path.to_path_buf(),
        key: "rate_hz",
        problem: format!("is {hz}; a rate is positive and finite"),
    })
}
