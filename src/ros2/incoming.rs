//! Messages that a node takes, from their bytes with the four in front that name their representation. Images are read by [`dpn_logs::ros::decode_image`].
//!
//! Source: sensor_msgs/Imu.msg, sensor_msgs/CameraInfo.msg, tf2_msgs/TFMessage.msg, rosgraph_msgs/Clock.msg.

use dpn_core::{ImuSample, Stamp};
use dpn_logs::ros::{Encoding, Fields, Undecodable};
use nalgebra::{Isometry3, Quaternion, Translation3, UnitQuaternion};

/// Types as ROS names them.
pub mod kind {
    /// [`Imu`](super::Imu).
    pub const IMU: &str = "sensor_msgs/msg/Imu";
    /// An image.
    pub const IMAGE: &str = "sensor_msgs/msg/Image";
    /// An image as PNG or JPEG.
    pub const COMPRESSED_IMAGE: &str = "sensor_msgs/msg/CompressedImage";
    /// [`CameraInfo`](super::CameraInfo).
    pub const CAMERA_INFO: &str = "sensor_msgs/msg/CameraInfo";
    /// [`transforms`](super::transforms()).
    pub const TRANSFORMS: &str = "tf2_msgs/msg/TFMessage";
    /// [`clock`](super::clock()).
    pub const CLOCK: &str = "rosgraph_msgs/msg/Clock";
}

/// More coefficients no lens has, more transforms no message.
const MOST: u32 = 10_000;

/// `sensor_msgs/Imu`.
#[derive(Debug, Clone, PartialEq)]
pub struct Imu {
    /// Its stamp.
    pub t: Stamp,
    /// The IMU's frame.
    pub frame_id: String,
    /// Orientation (x, y, z, w), its covariance, angular velocity, its, linear acceleration, its.
    pub values: [f64; 37],
}

impl Imu {
    /// Of a message.
    ///
    /// # Errors
    /// One that is too short or in no known representation.
    pub fn read(data: &[u8]) -> Result<Self, Undecodable> {
        read(data, |fields| {
            let header = fields.header()?;
            let mut values = [0.0; 37];
            for value in &mut values {
                *value = fields.f64()?;
            }
            Some(Self { t: Stamp::from_ns(header.t_ns), frame_id: header.frame_id(), values })
        })
    }

    /// What the odometry takes of it.
    pub fn sample(&self) -> ImuSample {
        let three = |first: usize| [self.values[first], self.values[first + 1], self.values[first + 2]];
        ImuSample { t: self.t, gyro: three(13), accel: three(25) }
    }
}

/// `sensor_msgs/CameraInfo`, as far as a lens is concerned: what was cut out of an image or put together is not.
#[derive(Debug, Clone, PartialEq)]
pub struct CameraInfo {
    /// The camera's frame.
    pub frame_id: String,
    /// Width and height \[px\].
    pub size: [u32; 2],
    /// The lens' model by name.
    pub model: String,
    /// Its coefficients.
    pub coefficients: Vec<f64>,
    /// The camera's matrix by rows; zeros where it is not calibrated.
    pub k: [f64; 9],
}

impl CameraInfo {
    /// Of a message.
    ///
    /// # Errors
    /// One that is too short or in no known representation.
    pub fn read(data: &[u8]) -> Result<Self, Undecodable> {
        read(data, |fields| {
            let header = fields.header()?;
            let (height, width) = (fields.u32()?, fields.u32()?);
            let model = fields.text()?;
            let count = fields.u32().filter(|count| *count <= MOST)?;
            let coefficients = (0..count).map(|_| fields.f64()).collect::<Option<_>>()?;
            let mut k = [0.0; 9];
            for value in &mut k {
                *value = fields.f64()?;
            }
            Some(Self { frame_id: header.frame_id(), size: [width, height], model, coefficients, k })
        })
    }
}

/// `geometry_msgs/TransformStamped` without its stamp.
#[derive(Debug, Clone, PartialEq)]
pub struct Transform {
    /// Where it leads.
    pub parent: String,
    /// From where.
    pub child: String,
    /// Points in the child's frame to the parent's.
    pub parent_from_child: Isometry3<f64>,
}

/// `tf2_msgs/TFMessage`; a transform that is none (no unit quaternion, no numbers) is left out.
///
/// # Errors
/// One that is too short or in no known representation.
pub fn transforms(data: &[u8]) -> Result<Vec<Transform>, Undecodable> {
    let all: Vec<Option<Transform>> = read(data, |fields| {
        let count = fields.u32().filter(|count| *count <= MOST)?;
        (0..count).map(|_| one(fields)).collect::<Option<_>>()
    })?;
    Ok(all.into_iter().flatten().collect())
}

/// None where the message ends, `Some(None)` where the transform is none.
fn one(fields: &mut Fields<'_>) -> Option<Option<Transform>> {
    let parent = fields.header()?.frame_id();
    let child = fields.text()?;
    let mut v = [0.0; 7];
    for value in &mut v {
        *value = fields.f64()?;
    }
    let quaternion = Quaternion::new(v[6], v[3], v[4], v[5]);
    let is_one = v.iter().all(|v| v.is_finite()) && (quaternion.norm() - 1.0).abs() < 1e-2;
    Some(is_one.then(|| Transform {
        parent,
        child,
        parent_from_child: Isometry3::from_parts(
            Translation3::new(v[0], v[1], v[2]),
            UnitQuaternion::from_quaternion(quaternion),
        ),
    }))
}

/// The stamp of a message that begins with a header.
///
/// # Errors
/// One that is too short or in no known representation.
pub fn stamp(data: &[u8]) -> Result<Stamp, Undecodable> {
    read(data, |fields| Some(Stamp::from_ns(fields.header()?.t_ns)))
}

/// `rosgraph_msgs/Clock`.
///
/// # Errors
/// One that is too short or in no known representation.
pub fn clock(data: &[u8]) -> Result<Stamp, Undecodable> {
    read(data, |fields| {
        let (seconds, nanos) = (fields.u32()?, fields.u32()?);
        Some(Stamp::from_ns(i64::from(seconds.cast_signed()) * 1_000_000_000 + i64::from(nanos)))
    })
}

fn read<T>(data: &[u8], of: impl FnOnce(&mut Fields<'_>) -> Option<T>) -> Result<T, Undecodable> {
    of(&mut Fields::new(data, Encoding::Cdr)?).ok_or(Undecodable::Short)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cdr::Cdr;

    #[test]
    fn what_is_cut_off_or_says_too_much_is_refused_and_a_transform_that_is_none_left_out() {
        let mut cdr = Cdr::default();
        cdr.header(Stamp::from_ns(5), "cam");
        cdr.u32(480);
        cdr.u32(752);
        cdr.text("plumb_bob");
        cdr.u32(5);
        cdr.f64s(&[0.1, 0.2, 0.3, 0.4, 0.0]);
        cdr.f64s(&[458.0, 0.0, 367.0, 0.0, 457.0, 248.0, 0.0, 0.0, 1.0]);
        let whole = [&[0, 1, 0, 0], &cdr.done()[..]].concat();
        let info = CameraInfo::read(&whole).unwrap();
        assert_eq!((info.size, info.model.as_str()), ([752, 480], "plumb_bob"));
        assert_eq!((info.coefficients.len(), info.k[5]), (5, 248.0));
        for end in [3, 4, 20, whole.len() - 1] {
            assert!(CameraInfo::read(&whole[..end]).is_err(), "{end}");
        }
        // A count that no message has room for is no reason to look for it.
        let mut many = Cdr::default();
        many.u32(u32::MAX);
        assert_eq!(transforms(&[&[0, 1, 0, 0], &many.done()[..]].concat()), Err(Undecodable::Short));
        let mut none = Cdr::default();
        none.u32(1);
        none.header(Stamp::from_ns(0), "a");
        none.text("b");
        none.f64s(&[0.0; 7]);
        assert_eq!(transforms(&[&[0, 1, 0, 0], &none.done()[..]].concat()), Ok(Vec::new()));
        assert_eq!(clock(&[0, 1, 0, 0, 2, 0, 0, 0, 3, 0, 0, 0]), Ok(Stamp::from_ns(2_000_000_003)));
    }
}
