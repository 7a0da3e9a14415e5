//! Readings that no inertial sensor gives.

use dpn_core::ImuSample;
use dpn_core::imu::Sensor;

/// So many in a row are passed over; more are what the sensor says, in whatever unit.
const LONGEST_SPIKE: usize = 3;

/// The most that a sensor's axis reads. Gyroscopes end at 4000 deg/s (70 rad/s), accelerometers for vehicles at 200 g.
fn most(sensor: Sensor) -> f64 {
    match sensor {
        Sensor::Accel => 2000.0,
        Sensor::Gyro => 100.0,
    }
}

/// Passes over single readings beyond any range: a failed transfer, a flipped bit. One of 1000 rad/s turns the world by five.
#[derive(Debug, Clone, Default)]
pub(super) struct SpikeFilter {
    in_a_row: usize,
}

impl SpikeFilter {
    /// The sensor and its reading that make `sample` one to pass over.
    pub(super) fn spike(&mut self, sample: &ImuSample) -> Option<(Sensor, f64)> {
        let beyond = |sensor: Sensor| {
            let reading = sample.of(sensor).into_iter().find(|v| v.abs() > most(sensor))?;
            Some((sensor, reading))
        };
        let found = Sensor::ALL.into_iter().find_map(beyond);
        self.in_a_row = if found.is_some() { self.in_a_row + 1 } else { 0 };
        found.filter(|_| self.in_a_row <= LONGEST_SPIKE)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use dpn_core::Stamp;

    #[test]
    fn single_readings_beyond_any_range_are_spikes_and_a_log_in_another_unit_is_none() {
        let sample = |gyro: f64, accel: f64| ImuSample {
            t: Stamp::from_ns(0),
            gyro: [0.0, -gyro, 0.0],
            accel: [0.0, 0.0, accel],
        };
        let mut filter = SpikeFilter::default();
        let mut told = |gyro, accel| filter.spike(&sample(gyro, accel));
        assert_eq!(told(70.0, 1900.0), None);
        assert_eq!(told(1000.0, 9.81), Some((Sensor::Gyro, -1000.0)));
        assert_eq!(told(0.1, 1e30), Some((Sensor::Accel, 1e30)));
        assert_eq!(told(0.1, 9.81), None);
        // mg for m/s^2: the first three are passed over, then it is the sensor's word.
        let answers: Vec<bool> = (0..6).map(|_| told(0.1, 9810.0).is_some()).collect();
        assert_eq!(answers, [true, true, true, false, false, false]);
    }
}
