//! Four numbers of text to a rotation.

use nalgebra::{Quaternion, UnitQuaternion};

/// How far a quaternion's norm may be from 1: files carry six digits or fewer (EuRoC's are off by up to 3.3e-4).
const NORM_TOLERANCE: f64 = 1e-2;

/// A norm this close to 1 is a written unit quaternion, not a rounded one.
const EXACT: f64 = 1e-12;

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
