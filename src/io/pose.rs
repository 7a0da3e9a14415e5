//! Numbers of text to rotations and rigid motions.

use super::row_fault::RowFault;
use dpn_core::geometry;
use nalgebra::{Isometry3, Matrix3, Quaternion, Translation3, UnitQuaternion, Vector3};

/// How far a quaternion's norm may be from 1: files carry six digits or fewer (EuRoC's are off by up to 3.3e-4).
const NORM_TOLERANCE: f64 = 1e-2;

/// A norm this close to 1 is a written unit quaternion, not a rounded one.
const EXACT: f64 = 1e-12;

/// Farthest that a position may be from the origin along an axis \[m\]: squares of more leave no figures to an error, and no vehicle is there.
const FARTHEST: f64 = 1e9;

/// A position in metres; what is wrong with it where it is none.
pub(crate) fn position(xyz: [f64; 3]) -> Result<Translation3<f64>, RowFault> {
    match ["x", "y", "z"].into_iter().zip(xyz).find(|(_, value)| value.abs() > FARTHEST) {
        Some((column, value)) => Err(RowFault::TooFar { column, value }),
        None => Ok(Translation3::from(xyz)),
    }
}

/// The rotation of a quaternion given as w, x, y, z; the norm where it is none.
///
/// One that is already of length 1 keeps its bits, so that what was written is read back the same.
pub(crate) fn rotation([w, x, y, z]: [f64; 4]) -> Result<UnitQuaternion<f64>, f64> {
    let quaternion = Quaternion::new(w, x, y, z);
    let norm = quaternion.norm();
    if norm.is_nan() || (norm - 1.0).abs() > NORM_TOLERANCE {
        return Err(norm);
    }
    if (norm - 1.0).abs() <= EXACT {
        Ok(UnitQuaternion::new_unchecked(quaternion))
    } else {
        Ok(UnitQuaternion::new_normalize(quaternion))
    }
}

/// The rigid motion of a matrix of 4 (or 3) rows of 4; what is wrong with it where it is none.
pub(crate) fn rigid(m: &[f64]) -> Result<Isometry3<f64>, String> {
    let rows = match m.len() {
        _ if m.iter().any(|v| !v.is_finite()) => {
            return Err("holds a value that is not finite".to_owned());
        }
        16 if m[12..] == [0.0, 0.0, 0.0, 1.0] => &m[..12],
        16 => return Err(format!("ends with the row {:?}, not 0 0 0 1", &m[12..])),
        12 => m,
        n => return Err(format!("has {n} numbers; a pose has 4 rows of 4")),
    };
    let rotation = Matrix3::from_fn(|row, column| rows[4 * row + column]);
    turned(&rotation, Vector3::new(rows[3], rows[7], rows[11]))
}

/// The same of a rotation and a translation.
pub(crate) fn turned(rotation: &Matrix3<f64>, offset: Vector3<f64>) -> Result<Isometry3<f64>, String> {
    let motion = geometry::rigid::rigid(rotation, offset).map_err(|problem| problem.to_string())?;
    // The files carry a dozen digits; the quaternion is brought back to length 1.
    let rotation = UnitQuaternion::new_normalize(motion.rotation.into_inner());
    Ok(Isometry3::from_parts(motion.translation, rotation))
}
