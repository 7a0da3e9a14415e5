//! Six numbers a sample: one part of what the IMU reads.

use dpn_core::Sensor;

/// One part of the reading at every sample: gyroscope \[rad/s\] and accelerometer \[m/s^2\].
#[derive(Debug, Clone, PartialEq, Default)]
pub struct ImuSeries {
    /// Gyroscope x, y, z \[rad/s\].
    pub gyro: Vec<[f64; 3]>,
    /// Accelerometer x, y, z \[m/s^2\].
    pub accel: Vec<[f64; 3]>,
}

impl ImuSeries {
    /// `n` samples of zero.
    pub fn zeros(n: usize) -> Self {
        Self { gyro: vec![[0.0; 3]; n], accel: vec![[0.0; 3]; n] }
    }

    /// Number of samples.
    pub(crate) fn len(&self) -> usize {
        self.gyro.len()
    }

    /// The samples of one sensor.
    pub fn of(&self, sensor: Sensor) -> &[[f64; 3]] {
        match sensor {
            Sensor::Accel => &self.accel,
            Sensor::Gyro => &self.gyro,
        }
    }

    pub(crate) fn of_mut(&mut self, sensor: Sensor) -> &mut [[f64; 3]] {
        match sensor {
            Sensor::Accel => &mut self.accel,
            Sensor::Gyro => &mut self.gyro,
        }
    }

    /// Sample `i` of axis `a` of six: accelerometer x, y, z, gyroscope x, y, z.
    pub(crate) fn value_mut(&mut self, a: usize, i: usize) -> &mut f64 {
        let sensor = if a < 3 { Sensor::Accel } else { Sensor::Gyro };
        &mut self.of_mut(sensor)[i][a % 3]
    }

    /// One axis (0, 1, 2) of one sensor as a contiguous signal.
    ///
    /// # Panics
    /// When `axis` is above 2.
    pub fn axis(&self, sensor: Sensor, axis: usize) -> Vec<f64> {
        assert!(axis < 3, "an IMU sensor has axes 0, 1, 2, not {axis}");
        self.of(sensor).iter().map(|v| v[axis]).collect()
    }
}
