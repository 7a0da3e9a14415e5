//! What the window estimates of the body at one instant, and the order of its fifteen unknowns.
//!
//! ```text
//! position 0..3   rotation 3..6   velocity 6..9   accelerometer bias 9..12   gyro bias 12..15
//! ```
//! Position and velocity are added to, in the world frame; the rotation is perturbed on the right.

use dpn_core::geometry::so3;
use nalgebra::{Isometry3, SVector, Vector3};

/// Unknowns of one state.
pub const STATE_DIM: usize = 15;
/// Where the position stands.
pub const POSITION: usize = 0;
/// Where the rotation stands; with the position before it, the pose's six.
pub const ROTATION: usize = 3;
/// Unknowns of a pose.
pub const POSE_DIM: usize = 6;
/// Where the velocity stands.
pub const VELOCITY: usize = 6;
/// Where the accelerometer's bias stands.
pub const ACCEL_BIAS: usize = 9;
/// Where the gyro's bias stands.
pub const GYRO_BIAS: usize = 12;

/// What the sensors read at rest and in free fall: reading = truth + bias + noise.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ImuBias {
    /// Of the accelerometer, body frame \[m/s^2\].
    pub accel: Vector3<f64>,
    /// Of the gyro, body frame \[rad/s\].
    pub gyro: Vector3<f64>,
}

impl ImuBias {
    /// None.
    pub fn zero() -> Self {
        Self { accel: Vector3::zeros(), gyro: Vector3::zeros() }
    }
}

/// The body at one instant.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NavState {
    /// Points in the body frame to the world \[m\].
    pub world_from_body: Isometry3<f64>,
    /// Velocity in the world frame \[m/s\].
    pub vel_in_world: Vector3<f64>,
    /// The IMU's biases.
    pub bias: ImuBias,
}

impl NavState {
    /// At the world's origin, at rest, level, without bias.
    pub fn identity() -> Self {
        Self { world_from_body: Isometry3::identity(), vel_in_world: Vector3::zeros(), bias: ImuBias::zero() }
    }

    /// The state moved by `d`, in the order of this module.
    #[must_use]
    pub fn plus(&self, d: &SVector<f64, STATE_DIM>) -> Self {
        Self {
            world_from_body: pose_plus(
                &self.world_from_body,
                &d.fixed_rows::<POSE_DIM>(POSITION).into_owned(),
            ),
            vel_in_world: self.vel_in_world + d.fixed_rows::<3>(VELOCITY),
            bias: ImuBias {
                accel: self.bias.accel + d.fixed_rows::<3>(ACCEL_BIAS),
                gyro: self.bias.gyro + d.fixed_rows::<3>(GYRO_BIAS),
            },
        }
    }

    /// The `d` for which `origin.plus(d)` is this state.
    pub fn minus(&self, origin: &Self) -> SVector<f64, STATE_DIM> {
        let mut d = SVector::<f64, STATE_DIM>::zeros();
        d.fixed_rows_mut::<POSE_DIM>(POSITION)
            .copy_from(&pose_minus(&self.world_from_body, &origin.world_from_body));
        d.fixed_rows_mut::<3>(VELOCITY).copy_from(&(self.vel_in_world - origin.vel_in_world));
        d.fixed_rows_mut::<3>(ACCEL_BIAS).copy_from(&(self.bias.accel - origin.bias.accel));
        d.fixed_rows_mut::<3>(GYRO_BIAS).copy_from(&(self.bias.gyro - origin.bias.gyro));
        d
    }

    /// Whether every number is one.
    pub fn is_finite(&self) -> bool {
        let finite = |v: &Vector3<f64>| v.iter().all(|x| x.is_finite());
        finite(&self.world_from_body.translation.vector)
            && self.world_from_body.rotation.coords.iter().all(|x| x.is_finite())
            && finite(&self.vel_in_world)
            && finite(&self.bias.accel)
            && finite(&self.bias.gyro)
    }
}

/// A pose moved by `d`: position, then rotation on the right.
pub(crate) fn pose_plus(pose: &Isometry3<f64>, d: &SVector<f64, POSE_DIM>) -> Isometry3<f64> {
    let rotation = pose.rotation * so3::exp(&d.fixed_rows::<3>(ROTATION).into_owned());
    // A product of unit quaternions drifts from length 1 by one rounding a step; thousands of steps would show.
    let rotation = nalgebra::UnitQuaternion::new_normalize(rotation.into_inner());
    Isometry3::from_parts((pose.translation.vector + d.fixed_rows::<3>(POSITION)).into(), rotation)
}

/// The `d` for which `pose_plus(origin, d)` is `pose`.
pub(crate) fn pose_minus(pose: &Isometry3<f64>, origin: &Isometry3<f64>) -> SVector<f64, POSE_DIM> {
    let mut d = SVector::<f64, POSE_DIM>::zeros();
    d.fixed_rows_mut::<3>(POSITION).copy_from(&(pose.translation.vector - origin.translation.vector));
    d.fixed_rows_mut::<3>(ROTATION).copy_from(&so3::log(&(origin.rotation.inverse() * pose.rotation)));
    d
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn minus_undoes_plus(a in prop::array::uniform15(-1.0..1.0f64), d in prop::array::uniform15(-1.0..1.0f64)) {
            let origin = NavState::identity().plus(&SVector::from(a));
            let d = SVector::from(d);
            prop_assert!((origin.plus(&d).minus(&origin) - d).norm() < 1e-12);
        }
    }

    #[test]
    fn a_state_with_nan_is_not_finite() {
        let mut state = NavState::identity();
        assert!(state.is_finite());
        state.bias.gyro.y = f64::NAN;
        assert!(!state.is_finite());
    }
}
