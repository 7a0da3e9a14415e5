//! Messages that a node sends, as their fields in plain CDR, without the four bytes in front.
//!
//! Source: nav_msgs/Odometry.msg, tf2_msgs/TFMessage.msg, sensor_msgs/Imu.msg, diagnostic_msgs/DiagnosticArray.msg.

use crate::cdr::Cdr;
use crate::incoming::Imu;
use dpn_core::{ImuNoise, Sensor, Stamp};
use nalgebra::{Isometry3, Matrix3, Matrix6, Vector3};

/// Types as ROS names them.
pub mod kind {
    /// [`odometry`](super::odometry()).
    pub const ODOMETRY: &str = "nav_msgs/msg/Odometry";
    /// [`transform`](super::transform()).
    pub const TRANSFORMS: &str = "tf2_msgs/msg/TFMessage";
    /// [`imu`](super::imu()).
    pub const IMU: &str = "sensor_msgs/msg/Imu";
    /// [`diagnostics`](super::diagnostics()).
    pub const DIAGNOSTICS: &str = "diagnostic_msgs/msg/DiagnosticArray";
}

/// A variance \[m^2, rad^2, (m/s)^2\] that says that nothing is known.
const UNKNOWN: f64 = 1e6;

/// A pose with its covariance, and the velocity at it.
#[derive(Debug, Clone, PartialEq)]
pub struct Odometry<'a> {
    /// When.
    pub t: Stamp,
    /// The world's frame.
    pub world: &'a str,
    /// The body's.
    pub body: &'a str,
    /// Points in the body's frame to the world.
    pub world_from_body: Isometry3<f64>,
    /// Position, then rotation on the right, as the odometry has it; none where it is not known.
    pub covariance: Option<Matrix6<f64>>,
    /// Velocity in the world's frame \[m/s\].
    pub vel_in_world: Vector3<f64>,
}

/// `nav_msgs/Odometry`: the pose's covariance about the world's axes, the velocity in the body's frame. The velocity's covariance is not known and the turn
/// rate not said: variances of 1e6, which a filter passes over.
pub fn odometry(odometry: &Odometry<'_>) -> Vec<u8> {
    let mut cdr = Cdr::default();
    cdr.header(odometry.t, odometry.world);
    cdr.text(odometry.body);
    cdr.pose(&odometry.world_from_body);
    let unknown = Matrix6::from_diagonal_element(UNKNOWN);
    let rotation = odometry.world_from_body.rotation.to_rotation_matrix();
    let covariance = odometry.covariance.map_or(unknown, |own| about_world(&own, rotation.matrix()));
    cdr.f64s(covariance.as_slice());
    cdr.vector(&(odometry.world_from_body.rotation.inverse() * odometry.vel_in_world));
    cdr.vector(&Vector3::zeros());
    cdr.f64s(unknown.as_slice());
    cdr.done()
}

/// A covariance whose rotation is turned on the right, with the rotation turned about the world's axes: R Exp(d) = Exp(R d) R.
fn about_world(own: &Matrix6<f64>, world_from_body: &Matrix3<f64>) -> Matrix6<f64> {
    let mut turn = Matrix6::identity();
    turn.fixed_view_mut::<3, 3>(3, 3).copy_from(world_from_body);
    turn * own * turn.transpose()
}

/// `tf2_msgs/TFMessage` of one transform: points in the frame `child` to `parent`.
pub fn transform(t: Stamp, parent: &str, child: &str, parent_from_child: &Isometry3<f64>) -> Vec<u8> {
    let mut cdr = Cdr::default();
    cdr.u32(1);
    cdr.header(t, parent);
    cdr.text(child);
    cdr.pose(parent_from_child);
    cdr.done()
}

/// `sensor_msgs/Imu`: the message that came, with the variances of one sample in force on the diagonals of both covariances.
pub fn imu(came: &Imu, noise: &ImuNoise) -> Vec<u8> {
    let mut values = came.values;
    for (first, sensor) in [(16, Sensor::Gyro), (28, Sensor::Accel)] {
        for (axis, sigma) in noise.of(sensor).into_iter().enumerate() {
            let row = first + 3 * axis;
            values[row..row + 3].fill(0.0);
            values[row + axis] = sigma * sigma;
        }
    }
    imu_as_it_came(&Imu { values, ..came.clone() })
}

/// `sensor_msgs/Imu` as it came.
pub fn imu_as_it_came(came: &Imu) -> Vec<u8> {
    let mut cdr = Cdr::default();
    cdr.header(came.t, &came.frame_id);
    cdr.f64s(&came.values);
    cdr.done()
}

/// How grave a status is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
#[repr(u8)]
pub enum Level {
    /// All is well.
    Ok = 0,
    /// Somebody should look.
    Warn = 1,
    /// It does not work.
    Error = 2,
    /// Nothing comes any more.
    Stale = 3,
}

/// `diagnostic_msgs/DiagnosticStatus`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Status {
    /// How grave.
    pub level: Level,
    /// Of what.
    pub name: String,
    /// In words.
    pub message: String,
    /// In numbers: keys and values.
    pub values: Vec<(String, String)>,
}

/// `diagnostic_msgs/DiagnosticArray`.
pub fn diagnostics(t: Stamp, statuses: &[Status]) -> Vec<u8> {
    let mut cdr = Cdr::default();
    cdr.header(t, "");
    cdr.u32(statuses.len() as u32);
    for status in statuses {
        cdr.u8(status.level as u8);
        cdr.text(&status.name);
        cdr.text(&status.message);
        cdr.text("");
        cdr.u32(status.values.len() as u32);
        for (key, value) in &status.values {
            cdr.text(key);
            cdr.text(value);
        }
    }
    cdr.done()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::incoming;
    use nalgebra::{Translation3, UnitQuaternion};

    fn pose() -> Isometry3<f64> {
        let turn = UnitQuaternion::from_euler_angles(0.3, -1.1, 2.0);
        Isometry3::from_parts(Translation3::new(1.0, -2.0, 3.0), turn)
    }

    /// As it would come in again.
    fn framed(body: &[u8]) -> Vec<u8> {
        [&[0, 1, 0, 0], body].concat()
    }

    #[test]
    fn a_transform_and_an_imu_come_back_as_they_were_sent() {
        let t = Stamp::from_ns(1_600_000_000_250_000_001);
        for child in ["cam", "camera", "cam0_optical_frame"] {
            let sent = framed(&transform(t, "imu", child, &pose()));
            let [back] = &incoming::transforms(&sent).unwrap()[..] else { panic!("one transform") };
            assert_eq!((back.parent.as_str(), back.child.as_str()), ("imu", child));
            assert!((back.parent_from_child.to_matrix() - pose().to_matrix()).amax() < 1e-15);
        }
        let values = std::array::from_fn(|i| i as f64 + 0.5);
        let came = Imu { t, frame_id: "imu_link".to_owned(), values };
        let noise = ImuNoise::from_values([1.0, 2.0, 3.0], [0.1, 0.2, 0.3]).unwrap();
        let back = Imu::read(&framed(&imu(&came, &noise))).unwrap();
        assert_eq!((back.t, back.frame_id.as_str()), (t, "imu_link"));
        assert_eq!(back.values[..16], values[..16]);
        assert_eq!(back.values[25..28], values[25..28]);
        assert_eq!(back.values[28..37], [1.0, 0.0, 0.0, 0.0, 4.0, 0.0, 0.0, 0.0, 9.0]);
        assert_eq!((back.values[16], back.values[20]), (0.1 * 0.1, 0.2 * 0.2));
    }

    #[test]
    fn a_covariance_is_turned_as_the_rotation_that_it_is_of() {
        // A small turn on the right, and the turn about the world's axes that does the same.
        let own = Matrix6::from_fn(|r, c| if r == c { 1.0 + r as f64 } else { 0.1 / (1.0 + (r + c) as f64) });
        let rotation = pose().rotation;
        let turned = about_world(&own, rotation.to_rotation_matrix().matrix());
        let step = Vector3::new(1e-6, 2e-6, -1e-6);
        let right = rotation * UnitQuaternion::new(step);
        let about = (right * rotation.inverse()).scaled_axis();
        let mut d = nalgebra::Vector6::zeros();
        d.fixed_rows_mut::<3>(3).copy_from(&step);
        let mut e = nalgebra::Vector6::zeros();
        e.fixed_rows_mut::<3>(3).copy_from(&about);
        // The same step is as likely told either way.
        let of = |m: &Matrix6<f64>, v: &nalgebra::Vector6<f64>| v.dot(&(m.try_inverse().unwrap() * v));
        assert!((of(&own, &d) / of(&turned, &e) - 1.0).abs() < 1e-5);
    }
}
