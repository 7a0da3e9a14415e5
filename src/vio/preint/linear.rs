//! One mid-point step: the mean, and its derivatives by what was before, by the biases and by the readings.
//!
//! `x = (position, rotation, velocity)`, in the order of [`crate::state`]; `b = (accelerometer bias, gyro bias)`.

use super::delta::Delta;
use crate::state::{ImuBias, POSITION, ROTATION, VELOCITY};
use dpn_core::ImuSample;
use dpn_core::geometry::so3;
use nalgebra::{Matrix3, SMatrix, UnitQuaternion, Vector3};

/// Rows of `x`.
pub(super) const MOTION_DIM: usize = 9;
/// Rows of `b`.
pub(super) const BIAS_DIM: usize = 6;
/// Where the accelerometer's bias stands in `b`.
pub(super) const ACCEL: usize = 0;
/// Where the gyro's bias stands in `b`.
pub(super) const GYRO: usize = 3;

/// `x <- F x + B b` over one step.
#[derive(Debug, Clone)]
pub(super) struct Transition {
    /// The step \[s\].
    pub(super) dt: f64,
    /// Rotation from rotation.
    rotation: Matrix3<f64>,
    /// Velocity increment from rotation.
    velocity_from_rotation: Matrix3<f64>,
    /// How much of a velocity increment the position gets \[s\]: half the step for the mid-point, nothing for Euler.
    position_share: f64,
    /// `B`.
    pub(super) d_motion_d_bias: SMatrix<f64, MOTION_DIM, BIAS_DIM>,
}

impl Transition {
    /// Replaces `x` by `F x`, for as many columns as there are.
    #[inline]
    pub(super) fn carry<const N: usize>(&self, x: &mut SMatrix<f64, MOTION_DIM, N>) {
        for mut column in x.column_iter_mut() {
            let rotation = Vector3::new(column[ROTATION], column[ROTATION + 1], column[ROTATION + 2]);
            let turned = self.rotation * rotation;
            let gained = self.velocity_from_rotation * rotation;
            for axis in 0..3 {
                column[POSITION + axis] +=
                    self.dt * column[VELOCITY + axis] + self.position_share * gained[axis];
                column[ROTATION + axis] = turned[axis];
                column[VELOCITY + axis] += gained[axis];
            }
        }
    }

    /// The continuous equations at one reading, stepped forward by `dt`: the paper's `I + F dt`.
    ///
    /// `rate` and `force` are the reading without the bias, `rotation` is `body_i_from_body_k`.
    pub(super) fn euler(dt: f64, rotation: &Matrix3<f64>, rate: &Vector3<f64>, force: &Vector3<f64>) -> Self {
        let mut d_motion_d_bias = SMatrix::<f64, MOTION_DIM, BIAS_DIM>::zeros();
        d_motion_d_bias.fixed_view_mut::<3, 3>(VELOCITY, ACCEL).copy_from(&(-dt * rotation));
        d_motion_d_bias.fixed_view_mut::<3, 3>(ROTATION, GYRO).fill_diagonal(-dt);
        Self {
            dt,
            rotation: Matrix3::identity() - dt * so3::hat(rate),
            velocity_from_rotation: -dt * rotation * so3::hat(force),
            position_share: 0.0,
            d_motion_d_bias,
        }
    }
}

/// One mid-point step.
#[derive(Debug, Clone)]
pub(super) struct Step {
    /// The increments after it.
    pub(super) after: Delta,
    /// Its derivatives.
    pub(super) transition: Transition,
    /// `body_i_from_body_k` at the first sample.
    pub(super) rotation_0: Matrix3<f64>,
    /// The same at the second.
    pub(super) rotation_1: Matrix3<f64>,
    /// Rate at the first sample without bias \[rad/s\].
    pub(super) rate_0: Vector3<f64>,
    /// Specific force at the first sample without bias \[m/s^2\].
    pub(super) force_0: Vector3<f64>,
}

impl Step {
    /// From `before`, over the time between two samples.
    pub(super) fn mid_point(
        before: &Delta,
        bias: &ImuBias,
        sample_0: &ImuSample,
        sample_1: &ImuSample,
    ) -> Self {
        let dt = sample_1.t.seconds_since(sample_0.t);
        let rate_0 = Vector3::from(sample_0.gyro) - bias.gyro;
        let rate_1 = Vector3::from(sample_1.gyro) - bias.gyro;
        let force_0 = Vector3::from(sample_0.accel) - bias.accel;
        let force_1 = Vector3::from(sample_1.accel) - bias.accel;

        let turn_vector = 0.5 * dt * (rate_0 + rate_1);
        let turn = so3::exp(&turn_vector);
        let rotation = UnitQuaternion::new_normalize((before.rotation * turn).into_inner());
        let rotation_0 = before.rotation.to_rotation_matrix().into_inner();
        let rotation_1 = rotation.to_rotation_matrix().into_inner();
        let mean_force = 0.5 * (rotation_0 * force_0 + rotation_1 * force_1);
        let after = Delta {
            rotation,
            velocity: before.velocity + dt * mean_force,
            position: before.position + dt * before.velocity + (0.5 * dt * dt) * mean_force,
        };

        let turned_back = turn.to_rotation_matrix().into_inner().transpose();
        let d_turn_d_rate = dt * so3::right_jacobian(&turn_vector);
        let lever_1 = rotation_1 * so3::hat(&force_1);
        let velocity_from_rotation = (-0.5 * dt) * (rotation_0 * so3::hat(&force_0) + lever_1 * turned_back);
        let velocity_from_accel = (-0.5 * dt) * (rotation_0 + rotation_1);
        let velocity_from_gyro = (0.5 * dt) * (lever_1 * d_turn_d_rate);
        let mut d_motion_d_bias = SMatrix::<f64, MOTION_DIM, BIAS_DIM>::zeros();
        let mut put = |row, column, block: Matrix3<f64>| {
            d_motion_d_bias.fixed_view_mut::<3, 3>(row, column).copy_from(&block);
        };
        put(POSITION, ACCEL, (0.5 * dt) * velocity_from_accel);
        put(VELOCITY, ACCEL, velocity_from_accel);
        put(POSITION, GYRO, (0.5 * dt) * velocity_from_gyro);
        put(ROTATION, GYRO, -d_turn_d_rate);
        put(VELOCITY, GYRO, velocity_from_gyro);
        let transition = Transition {
            dt,
            rotation: turned_back,
            velocity_from_rotation,
            position_share: 0.5 * dt,
            d_motion_d_bias,
        };
        Self { after, transition, rotation_0, rotation_1, rate_0, force_0 }
    }
}
