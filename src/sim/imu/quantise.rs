//! Rounding to the sensor's counts.
//!
//! recorded = lsb round(x / lsb); the error recorded - x is kept, within half a count.

use super::series::ImuSeries;
use dpn_core::{GRAVITY, Sensor};

dpn_core::settings!(
    /// Resolution of a simulated IMU.
    pub struct QuantisationConfig {
        /// Whether readings are rounded to counts. Default true.
        pub enabled: bool = true,
        /// A gyroscope count \[deg/s\], 1e-6 to 10. Default .04, the ADIS16448's.
        pub gyro_lsb_deg_s: f64 = 0.04 => 1e-6..=10.0,
        /// Accelerometer counts in one g, 1 to 1e9. Default 1200, the ADIS16448's.
        pub accel_lsb_per_g: f64 = 1200.0 => 1.0..=1e9,
    }
);

impl QuantisationConfig {
    /// One count of `sensor` in its unit; a g is 9.80665 m/s^2 here as in the data sheet.
    pub(crate) fn lsb(&self, sensor: Sensor) -> f64 {
        match sensor {
            Sensor::Accel => STANDARD_GRAVITY / self.accel_lsb_per_g,
            Sensor::Gyro => self.gyro_lsb_deg_s.to_radians(),
        }
    }
}

/// The g of data sheets \[m/s^2\], not the gravity of the simulated world.
const STANDARD_GRAVITY: f64 = 9.80665;
const _: () = assert!(GRAVITY > STANDARD_GRAVITY);

/// Rounds `exact` in place and returns the error made, rounded minus exact.
pub(crate) fn round(config: &QuantisationConfig, exact: &mut ImuSeries) -> ImuSeries {
    let mut error = ImuSeries::zeros(exact.len());
    if config.enabled {
        for sensor in Sensor::ALL {
            let lsb = config.lsb(sensor);
            for (values, errors) in exact.of_mut(sensor).iter_mut().zip(error.of_mut(sensor)) {
                for (value, error) in values.iter_mut().zip(errors) {
                    let rounded = (*value / lsb).round() * lsb;
                    *error = rounded - *value;
                    *value = rounded;
                }
            }
        }
    }
    error
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn readings_become_whole_counts_within_half_of_one() {
        let config = QuantisationConfig::default();
        let mut series = ImuSeries::zeros(500);
        for i in 0..500 {
            let x = i as f64 * 0.031_7 - 8.0;
            series.accel[i] = [x, -x, 0.3 * x];
            series.gyro[i] = [0.1 * x, x, -0.7 * x];
        }
        let exact = series.clone();
        let error = round(&config, &mut series);
        for sensor in Sensor::ALL {
            let lsb = config.lsb(sensor);
            for i in 0..500 {
                for axis in 0..3 {
                    let (value, error) = (series.of(sensor)[i][axis], error.of(sensor)[i][axis]);
                    assert!((value / lsb - (value / lsb).round()).abs() < 1e-9);
                    assert!(error.abs() <= 0.5 * lsb * (1.0 + 1e-9));
                    assert!((exact.of(sensor)[i][axis] + error - value).abs() < 1e-15 * 16.0);
                }
            }
        }
    }

    #[test]
    fn the_counts_are_those_of_euroc() {
        let config = QuantisationConfig::default();
        assert!((config.lsb(Sensor::Gyro) - 6.981_317_007_977_318e-4).abs() < 1e-18);
        assert!((config.lsb(Sensor::Accel) - 0.008_172_208_333).abs() < 1e-12);
    }
}
