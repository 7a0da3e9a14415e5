//! The six deviations in force at one sample.

use super::units::{AccelSampleStd, BadNoise, GyroSampleStd};
use crate::imu::Sensor;
use serde::{Deserialize, Serialize};

/// Per-axis standard deviations of one IMU sample at the sensor's own rate.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct ImuNoise {
    /// Accelerometer x, y, z \[m/s^2\].
    pub accel: [AccelSampleStd; 3],
    /// Gyroscope x, y, z \[rad/s\].
    pub gyro: [GyroSampleStd; 3],
}

impl ImuNoise {
    /// The same accelerometer deviation on its three axes, the same gyroscope deviation on its.
    pub fn isotropic(accel: AccelSampleStd, gyro: GyroSampleStd) -> Self {
        Self { accel: [accel; 3], gyro: [gyro; 3] }
    }

    /// Takes bare deviations.
    ///
    /// # Errors
    /// A value that is negative or not finite.
    pub fn from_values(accel: [f64; 3], gyro: [f64; 3]) -> Result<Self, BadNoise> {
        Ok(Self {
            accel: [
                AccelSampleStd::new(accel[0])?,
                AccelSampleStd::new(accel[1])?,
                AccelSampleStd::new(accel[2])?,
            ],
            gyro: [GyroSampleStd::new(gyro[0])?, GyroSampleStd::new(gyro[1])?, GyroSampleStd::new(gyro[2])?],
        })
    }

    /// VINS-Mono's constants for EuRoC, the paper's baseline "x1": .08 m/s^2 and .004 rad/s per sample.
    pub fn baseline() -> Self {
        Self { accel: [AccelSampleStd::BASELINE; 3], gyro: [GyroSampleStd::BASELINE; 3] }
    }

    /// The deviations of one sensor as numbers in its unit.
    pub fn of(&self, sensor: Sensor) -> [f64; 3] {
        match sensor {
            Sensor::Accel => self.accel.map(AccelSampleStd::get),
            Sensor::Gyro => self.gyro.map(GyroSampleStd::get),
        }
    }
}
