//! What a trajectory says of one instant.

use nalgebra::{UnitQuaternion, Vector3};

/// Everything known about the body at one instant.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct State {
    /// Position \[m\].
    pub position_in_world: Vector3<f64>,
    /// Velocity \[m/s\].
    pub vel_in_world: Vector3<f64>,
    /// Acceleration \[m/s^2\].
    pub acc_in_world: Vector3<f64>,
    /// Orientation.
    pub world_from_body: UnitQuaternion<f64>,
    /// Angular rate \[rad/s\]: what an ideal gyroscope reads.
    pub gyro_in_body: Vector3<f64>,
    /// Specific force \[m/s^2\]: what an ideal accelerometer reads.
    pub specific_force_in_body: Vector3<f64>,
}
