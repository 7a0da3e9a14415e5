//! What ASL's `sensor.yaml` files have in common: reading, the pose `T_BS`, the rate.

use crate::IoError;
use crate::pose::rigid;
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
    let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    crate::yaml::parse(&crate::yaml::without_directives(crate::yaml::text(bytes, path)?), path)
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
