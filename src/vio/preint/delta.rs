//! The increments over an interval.

use nalgebra::{UnitQuaternion, Vector3};

/// What the samples say of the motion from body i to body j, free of gravity, in the frame of body i.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Delta {
    /// `body_i_from_body_j`.
    pub rotation: UnitQuaternion<f64>,
    /// Integral of the specific force \[m/s\].
    pub velocity: Vector3<f64>,
    /// Double integral of the specific force \[m\].
    pub position: Vector3<f64>,
}

impl Delta {
    /// Of an empty interval.
    pub fn identity() -> Self {
        Self { rotation: UnitQuaternion::identity(), velocity: Vector3::zeros(), position: Vector3::zeros() }
    }
}
