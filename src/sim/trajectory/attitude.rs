//! Attitude and body rate of a multirotor from its acceleration and heading (differential flatness).
//!
//! Thrust is along body z, so z_b = f / |f| with f = a - g. With heading psi and x_c = (cos psi, sin psi, 0):
//! y_b = z_b x x_c / |z_b x x_c|, x_b = y_b x z_b. Differentiating R = \[x_b y_b z_b\] and R' = R \[w\]_x gives
//!
//! w_x = -y_b . z_b',   w_y = x_b . z_b',   w_z = -x_b . y_b'
//!
//! so body rates come from jerk and heading rate in closed form. Source: Mellinger and Kumar, "Minimum snap trajectory
//! generation and control for quadrotors", ICRA 2011, sec. III. Free fall (f = 0) and thrust along the heading have no
//! attitude; the flights stay far from both.

use nalgebra::{Matrix3, Vector3};

/// Orientation and what an ideal IMU reads.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Attitude {
    /// Rotation matrix; its columns are the body axes in the world.
    pub world_from_body: Matrix3<f64>,
    /// Angular rate \[rad/s\].
    pub gyro_in_body: Vector3<f64>,
    /// Specific force R_bw (a - g) \[m/s^2\].
    pub specific_force_in_body: Vector3<f64>,
}

/// Attitude of a vehicle with acceleration `acc_in_world` \[m/s^2\], jerk \[m/s^3\], heading `yaw` \[rad\] and its
/// rate \[rad/s\], under `gravity_in_world`.
pub(crate) fn attitude(
    acc_in_world: Vector3<f64>,
    jerk_in_world: Vector3<f64>,
    yaw: f64,
    yaw_rate: f64,
    gravity_in_world: Vector3<f64>,
) -> Attitude {
    let force = acc_in_world - gravity_in_world;
    let thrust = force.norm();
    let z = force / thrust;
    let z_dot = (jerk_in_world - z * z.dot(&jerk_in_world)) / thrust;

    let heading = Vector3::new(yaw.cos(), yaw.sin(), 0.0);
    let heading_dot = Vector3::new(-yaw.sin(), yaw.cos(), 0.0) * yaw_rate;
    let side = z.cross(&heading);
    let side_dot = z_dot.cross(&heading) + z.cross(&heading_dot);
    let y = side / side.norm();
    let y_dot = (side_dot - y * y.dot(&side_dot)) / side.norm();
    let x = y.cross(&z);

    Attitude {
        world_from_body: Matrix3::from_columns(&[x, y, z]),
        gyro_in_body: Vector3::new(-y.dot(&z_dot), x.dot(&z_dot), -x.dot(&y_dot)),
        specific_force_in_body: Vector3::new(x.dot(&force), y.dot(&force), z.dot(&force)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const GRAVITY: Vector3<f64> = Vector3::new(0.0, 0.0, -9.81);

    #[test]
    fn at_rest_the_sensor_reads_gravity_and_nothing_else() {
        for yaw in [0.0, 0.3, -2.9] {
            let a = attitude(Vector3::zeros(), Vector3::zeros(), yaw, 0.0, GRAVITY);
            assert_eq!(a.specific_force_in_body, Vector3::new(0.0, 0.0, 9.81));
            assert_eq!(a.gyro_in_body, Vector3::zeros());
        }
    }

    #[test]
    fn pure_heading_rate_is_the_z_rate_when_level() {
        let a = attitude(Vector3::zeros(), Vector3::zeros(), 1.0, 0.7, GRAVITY);
        assert!((a.gyro_in_body - Vector3::new(0.0, 0.0, 0.7)).norm() < 1e-15);
    }

    #[test]
    fn acceleration_ahead_pitches_the_nose_down() {
        // Heading along x, accelerating along x: thrust tips forward, so body x points below the horizon, and
        // rising acceleration is a positive rate about body y.
        let a = attitude(Vector3::x(), Vector3::x(), 0.0, 0.0, GRAVITY);
        assert!(a.world_from_body[(2, 0)] < 0.0);
        assert!(a.gyro_in_body.y > 0.0);
        assert!(a.gyro_in_body.x.abs() < 1e-15);
        assert!((a.world_from_body.determinant() - 1.0).abs() < 1e-14);
    }
}
