//! By what the noise told is multiplied: one factor a component, each a source of noise of its own.

use dpn_core::{ImuNoise, Sensor};
use nalgebra::Vector3;

/// Sources of noise of an interval: accelerometer x, y, z, gyroscope x, y, z, walk of the accelerometer's bias, walk of the gyroscope's.
pub const COMPONENTS: usize = 8;
/// Where the walk of the accelerometer's bias stands among them.
pub(crate) const ACCEL_WALK: usize = 6;
/// Where the walk of the gyroscope's bias stands.
pub(crate) const GYRO_WALK: usize = 7;

/// Factors on the deviations told, in the order of [`COMPONENTS`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NoiseLevels(pub [f64; COMPONENTS]);

impl NoiseLevels {
    /// What was told.
    pub const TOLD: Self = Self([1.0; COMPONENTS]);

    /// The same of one component, none of the others.
    pub(super) fn only(&self, component: usize) -> Self {
        Self(std::array::from_fn(|k| if k == component { self.0[k] } else { 0.0 }))
    }

    /// The factors of one sensor's axes.
    pub(crate) fn of(&self, sensor: Sensor) -> [f64; 3] {
        let first = match sensor {
            Sensor::Accel => 0,
            Sensor::Gyro => 3,
        };
        std::array::from_fn(|axis| self.0[first + axis])
    }

    /// The noise in force where `told` is told; `None` where a product is no number.
    pub fn applied_to(&self, told: &ImuNoise) -> Option<ImuNoise> {
        let of = |sensor| {
            let (told, levels) = (told.of(sensor), self.of(sensor));
            std::array::from_fn(|axis| told[axis] * levels[axis])
        };
        ImuNoise::from_values(of(Sensor::Accel), of(Sensor::Gyro)).ok()
    }

    /// Variances in force of accelerometer and gyroscope.
    pub(super) fn variances(&self, told: &ImuNoise) -> (Vector3<f64>, Vector3<f64>) {
        let of = |sensor| {
            let (told, levels) = (told.of(sensor), self.of(sensor));
            Vector3::from_fn(|axis, _| (told[axis] * levels[axis]).powi(2))
        };
        (of(Sensor::Accel), of(Sensor::Gyro))
    }
}
