//! Units of a log's columns, and which column is what.

use super::TimeUnit;
use super::unit::{DEGREE, FOOT, STANDARD_GRAVITY, TURN};
use dpn_core::named;
use serde::{Deserialize, Serialize};

/// Three columns of a header, `name_x [unit],name_y [unit],name_z [unit]`.
pub fn axis_columns(name: &str, unit: &str) -> String {
    ["x", "y", "z"].map(|axis| format!("{name}_{axis} [{unit}]")).join(",")
}

named!(
    /// Unit of a log's gyroscope columns.
    #[derive(Serialize, Deserialize)]
    pub enum GyroUnit {
        /// Radians a second.
        #[serde(rename = "rad/s")]
        RadPerSecond = "rad/s",
        /// Degrees a second.
        #[serde(rename = "deg/s", alias = "dps")]
        DegPerSecond = "deg/s",
        /// Thousandths of a degree a second.
        #[serde(rename = "mdeg/s", alias = "mdps")]
        MilliDegPerSecond = "mdeg/s",
        /// Degrees an hour.
        #[serde(rename = "deg/h")]
        DegPerHour = "deg/h",
        /// Turns a minute.
        #[serde(rename = "rpm")]
        TurnPerMinute = "rpm",
    }
);

impl GyroUnit {
    /// One of these in rad/s.
    pub fn factor(self) -> f64 {
        match self {
            Self::RadPerSecond => 1.0,
            Self::DegPerSecond => DEGREE,
            Self::MilliDegPerSecond => DEGREE * 1e-3,
            Self::DegPerHour => DEGREE / 3600.0,
            Self::TurnPerMinute => TURN / 60.0,
        }
    }
}

named!(
    /// Unit of a log's accelerometer columns.
    #[derive(Serialize, Deserialize)]
    pub enum AccelUnit {
        /// Metres a second squared.
        #[serde(rename = "m/s^2", alias = "m/s2")]
        MetrePerSecond2 = "m/s^2",
        /// Standard gravity, 9.80665 m/s^2.
        #[serde(rename = "g")]
        StandardGravity = "g",
        /// A thousandth of standard gravity.
        #[serde(rename = "mg")]
        MilliGravity = "mg",
        /// A hundredth of a metre a second squared, a gal.
        #[serde(rename = "cm/s^2", alias = "cm/s2")]
        CentimetrePerSecond2 = "cm/s^2",
        /// A foot a second squared, 0.3048 m/s^2.
        #[serde(rename = "ft/s^2", alias = "ft/s2")]
        FootPerSecond2 = "ft/s^2",
    }
);

impl AccelUnit {
    /// One of these in m/s^2.
    pub fn factor(self) -> f64 {
        match self {
            Self::MetrePerSecond2 => 1.0,
            Self::StandardGravity => STANDARD_GRAVITY,
            Self::MilliGravity => STANDARD_GRAVITY * 1e-3,
            Self::CentimetrePerSecond2 => 1e-2,
            Self::FootPerSecond2 => FOOT,
        }
    }
}

/// Where a log keeps its stamps and its six axes: column indices from 0.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct ImuColumns {
    /// The stamp; whole seconds where `fraction` has the rest.
    pub time: usize,
    /// What goes on a stamp of whole seconds, in its unit.
    pub fraction: Option<(usize, TimeUnit)>,
    /// Gyroscope x, y, z.
    pub gyro: [usize; 3],
    /// Accelerometer x, y, z.
    pub accel: [usize; 3],
    /// Where the axes hold angles and velocities gained: columns of the times over which they were, of gyroscope and accelerometer.
    pub intervals: [Option<usize>; 2],
    /// Where gravity was taken from the accelerometer: its x, y, z, to be added.
    pub gravity: Option<[usize; 3]>,
}

impl ImuColumns {
    /// ASL's order: stamp, gyroscope x y z, accelerometer x y z.
    pub const ASL: Self = Self::new(0, [1, 2, 3], [4, 5, 6]);
    /// `ros2 topic echo --csv` of a `sensor_msgs/msg/Imu`: stamp in two, frame, orientation, then each triple with its nine covariances.
    pub const ROS2_ECHO: Self =
        Self { fraction: Some((1, TimeUnit::Nanos)), ..Self::new(0, [16, 17, 18], [28, 29, 30]) };

    /// Stamps in one column, rates and specific forces in six.
    pub const fn new(time: usize, gyro: [usize; 3], accel: [usize; 3]) -> Self {
        Self { time, fraction: None, gyro, accel, intervals: [None; 2], gravity: None }
    }
}

/// What the seven columns are called in messages.
pub(crate) const SLOTS: [&str; 7] = ["time", "gyro_x", "gyro_y", "gyro_z", "accel_x", "accel_y", "accel_z"];
