//! Rigid motions from numbers that somebody wrote.

use nalgebra::{Isometry3, Matrix3, Rotation3, Translation3, UnitQuaternion, Vector3};
use thiserror::Error;

/// How far a written rotation may be from orthonormal; calibrations carry six digits or more.
pub const ROTATION_TOLERANCE: f64 = 1e-3;

/// A matrix or an offset that makes no rigid motion.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
#[error(
    "holds no rotation: its columns are off orthonormal by {off:.2e}, the determinant is {determinant:.3}"
)]
pub struct NotRigid {
    /// Largest entry of R^T R - I.
    pub off: f64,
    /// Determinant of R.
    pub determinant: f64,
}

/// The rigid motion `x -> R x + t`, R the rotation nearest to `rotation`.
///
/// # Errors
/// A matrix that is no rotation within [`ROTATION_TOLERANCE`]; values that are not finite.
pub fn rigid(rotation: &Matrix3<f64>, offset: Vector3<f64>) -> Result<Isometry3<f64>, NotRigid> {
    let off = (rotation.transpose() * rotation - Matrix3::identity()).amax();
    let determinant = rotation.determinant();
    if !(off <= ROTATION_TOLERANCE && determinant > 0.0 && offset.iter().all(|v| v.is_finite())) {
        return Err(NotRigid { off, determinant });
    }
    let rotation = UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(*rotation));
    Ok(Isometry3::from_parts(Translation3::from(offset), rotation))
}
