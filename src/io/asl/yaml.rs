//! What ASL's `sensor.yaml` files have in common: reading, the pose `T_BS`, the rate.

use crate::{IoError, printable};
use dpn_core::time::SampleRate;
use nalgebra::{Isometry3, Matrix3, Rotation3, Translation3, UnitQuaternion, Vector3};
use serde::Deserialize;
use serde::de::DeserializeOwned;
use std::path::Path;

/// A matrix as the files write it: row by row in `data`.
#[derive(Debug, Deserialize)]
pub(super) struct Matrix {
    data: Vec<f64>,
}

pub(super) fn parse<T: DeserializeOwned>(bytes: &[u8], path: &Path) -> Result<T, IoError> {
    let text = std::str::from_utf8(bytes).map_err(|error| IoError::NotUtf8 {
        path: path.to_path_buf(),
        line: 1 + memchr::memchr_iter(b'\n', &bytes[..error.valid_up_to()]).count(),
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
/// Not 16 finite numbers, a last row other than 0 0 0 1, a rotation that is none within 1e-3.
pub(super) fn body_from_sensor(matrix: &Matrix, path: &Path) -> Result<Isometry3<f64>, IoError> {
    let bad = |problem: String| IoError::BadKey { path: path.to_path_buf(), key: "T_BS", problem };
    let Ok(m) = <&[f64; 16]>::try_from(matrix.data.as_slice()) else {
        return Err(bad(format!("has {} numbers; a pose has 4 rows of 4", matrix.data.len())));
    };
    if m.iter().any(|v| !v.is_finite()) {
        return Err(bad("holds a value that is not finite".to_owned()));
    }
    if m[12..] != [0.0, 0.0, 0.0, 1.0] {
        return Err(bad(format!("ends with the row {:?}, not 0 0 0 1", &m[12..])));
    }
    let rotation = Matrix3::new(m[0], m[1], m[2], m[4], m[5], m[6], m[8], m[9], m[10]);
    let off = (rotation.transpose() * rotation - Matrix3::identity()).abs().max();
    if off > 1e-3 || rotation.determinant() < 0.0 {
        return Err(bad(format!("has no rotation in its upper left corner (off by {off:.2e})")));
    }
    // The files carry a dozen digits; the quaternion is brought back to length 1.
    let near = UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(rotation));
    let rotation = UnitQuaternion::new_normalize(near.into_inner());
    let translation = Translation3::from(Vector3::new(m[3], m[7], m[11]));
    Ok(Isometry3::from_parts(translation, rotation))
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
