//! `imu0/sensor.yaml`: the IMU's rate and the noise its data sheet promises.

use super::yaml::{self, Matrix};
use crate::IoError;
use dpn_core::noise::units::BadNoise;
use dpn_core::noise::{AccelBiasWalkDensity, AccelNoiseDensity, GyroBiasWalkDensity, GyroNoiseDensity};
use dpn_core::time::SampleRate;
use nalgebra::Isometry3;
use serde::Deserialize;
use std::path::Path;

/// An IMU as its `sensor.yaml` describes it.
#[derive(Debug, Clone, PartialEq)]
pub struct ImuConfig {
    /// Samples a second.
    pub rate: SampleRate,
    /// Gyroscope's white noise \[rad/s/sqrt(Hz)\].
    pub gyro_noise: GyroNoiseDensity,
    /// Gyroscope's bias walk \[rad/s^2/sqrt(Hz)\].
    pub gyro_walk: GyroBiasWalkDensity,
    /// Accelerometer's white noise \[m/s^2/sqrt(Hz)\].
    pub accel_noise: AccelNoiseDensity,
    /// Accelerometer's bias walk \[m/s^3/sqrt(Hz)\].
    pub accel_walk: AccelBiasWalkDensity,
    /// `T_BS`: points in the IMU's frame to the body's; the identity where the IMU is the body.
    pub body_from_imu: Isometry3<f64>,
}

#[derive(Deserialize)]
struct Raw {
    rate_hz: f64,
    gyroscope_noise_density: f64,
    gyroscope_random_walk: f64,
    accelerometer_noise_density: f64,
    accelerometer_random_walk: f64,
    #[serde(rename = "T_BS")]
    t_bs: Option<Matrix>,
}

pub(super) fn read(path: &Path) -> Result<ImuConfig, IoError> {
    parse(&crate::small::read_config(path)?, path)
}

/// Reads an `imu0/sensor.yaml` from bytes at hand; `path` is for messages. Keys it does not know are passed over.
pub(crate) fn parse(bytes: &[u8], path: &Path) -> Result<ImuConfig, IoError> {
    let raw: Raw = yaml::parse(bytes, path)?;
    let bad = |key| {
        move |BadNoise(value): BadNoise| IoError::BadKey {
            path: path.to_path_buf(),
            key,
            problem: format!("is {value}; a noise figure is finite and not negative"),
        }
    };
    Ok(ImuConfig {
        rate: yaml::rate(raw.rate_hz, path)?,
        gyro_noise: GyroNoiseDensity::new(raw.gyroscope_noise_density)
            .map_err(bad("gyroscope_noise_density"))?,
        gyro_walk: GyroBiasWalkDensity::new(raw.gyroscope_random_walk)
            .map_err(bad("gyroscope_random_walk"))?,
        accel_noise: AccelNoiseDensity::new(raw.accelerometer_noise_density)
            .map_err(bad("accelerometer_noise_density"))?,
        accel_walk: AccelBiasWalkDensity::new(raw.accelerometer_random_walk)
            .map_err(bad("accelerometer_random_walk"))?,
        body_from_imu: match &raw.t_bs {
            Some(matrix) => yaml::body_from_sensor(matrix, path)?,
            None => Isometry3::identity(),
        },
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    const GOOD: &str = "sensor_type: imu\nrate_hz: 200\ngyroscope_noise_density: 1.6968e-04 # [ rad / s / sqrt(Hz) ]\n\
        gyroscope_random_walk: 1.9393e-05\naccelerometer_noise_density: 2.0000e-3\naccelerometer_random_walk: 3.0000e-3\n";

    fn error(text: &str) -> String {
        parse(text.as_bytes(), Path::new("sensor.yaml")).unwrap_err().to_string()
    }

    #[test]
    fn densities_land_in_their_own_types() {
        let config = parse(GOOD.as_bytes(), Path::new("sensor.yaml")).unwrap();
        assert_eq!(config.rate, SampleRate::HZ_200);
        assert_eq!(config.gyro_noise.get(), 1.6968e-4);
        assert_eq!(config.gyro_walk.get(), 1.9393e-5);
        assert_eq!(config.accel_noise.get(), 2e-3);
        assert_eq!(config.accel_walk.get(), 3e-3);
        assert_eq!(config.body_from_imu, Isometry3::identity());
    }

    #[test]
    fn what_is_wrong_is_named_with_its_key_or_line() {
        let missing = error(&GOOD.replace("gyroscope_random_walk: 1.9393e-05\n", ""));
        assert!(missing.contains("gyroscope_random_walk"), "{missing}");
        let text = error(&GOOD.replace("rate_hz: 200", "rate_hz: fast"));
        assert!(text.starts_with("sensor.yaml:2: "), "{text}");
        assert_eq!(
            error(&GOOD.replace("2.0000e-3", "-1")),
            "sensor.yaml: `accelerometer_noise_density` is -1; a noise figure is finite and not negative"
        );
        assert!(error(&GOOD.replace("200", "0")).contains("`rate_hz` is 0"));
        assert!(error(&GOOD.replace("200", ".nan")).contains("`rate_hz` is NaN"));
        let pose = error(&format!("{GOOD}T_BS:\n  data: [1, 0, 0]\n"));
        assert_eq!(pose, "sensor.yaml: `T_BS` has 3 numbers; a pose has 4 rows of 4");
    }
}
