//! Raw counts brought to units: by what one of them is, or by the sensor's name and range.

use dpn_core::ImuSample;
use dpn_io::SampleStore;
use std::io;
use std::str::FromStr;

const STANDARD_GRAVITY: f64 = 9.806_65;

/// A sensor of the table: counts to a g and to a deg/s at each range.
struct Entry {
    name: &'static str,
    /// Range \[g\] and counts to a g.
    accel: &'static [(u32, f64)],
    /// Range \[deg/s\] and counts to a deg/s; the first is the one after power-on.
    gyro: &'static [(u32, f64)],
}

/// Sources: InvenSense PS-MPU-6000A-00 rev. 3.4, 6.1 and 6.2; Bosch BST-BMI088-DS001 rev. 1.9, table 2 and 3; TDK DS-000189 rev. 1.5, table 1
/// and 2; Analog Devices ADIS16448 rev. G, table 1 (the upper 16 bits).
const SENSORS: [Entry; 4] = [
    Entry {
        name: "mpu6050",
        accel: &[(2, 16384.0), (4, 8192.0), (8, 4096.0), (16, 2048.0)],
        gyro: &[(250, 131.0), (500, 65.5), (1000, 32.8), (2000, 16.4)],
    },
    Entry {
        name: "bmi088",
        accel: &[(6, 5460.0), (3, 10920.0), (12, 2730.0), (24, 1365.0)],
        gyro: &[(2000, 16.384), (1000, 32.768), (500, 65.536), (250, 131.072), (125, 262.144)],
    },
    Entry {
        name: "icm20948",
        accel: &[(2, 16384.0), (4, 8192.0), (8, 4096.0), (16, 2048.0)],
        gyro: &[(250, 131.0), (500, 65.5), (1000, 32.8), (2000, 16.4)],
    },
    Entry { name: "adis16448", accel: &[(18, 1200.0)], gyro: &[(1000, 25.0), (500, 50.0), (250, 100.0)] },
];

/// What one of the log's numbers is, in SI units.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Scales {
    /// \[m/s^2\]
    pub accel: Option<f64>,
    /// \[rad/s\]
    pub gyro: Option<f64>,
}

/// `mpu6050-2g`, `bmi088-6g-2000dps`; a gyroscope's range that is not named is the one after power-on.
impl FromStr for Scales {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let lower = text.to_ascii_lowercase().replace("icm-", "icm");
        let known = || {
            let ranges = |all: &[(u32, f64)]| {
                all.iter().map(|(range, _)| range.to_string()).collect::<Vec<_>>().join("/")
            };
            let one = |e: &Entry| format!("{}-{{{}}}g-{{{}}}dps", e.name, ranges(e.accel), ranges(e.gyro));
            format!("known are {}", SENSORS.iter().map(one).collect::<Vec<_>>().join(", "))
        };
        let mut parts = lower.split('-');
        let name = parts.next().unwrap_or_default();
        let entry = SENSORS.iter().find(|entry| entry.name == name).ok_or_else(known)?;
        let (mut accel, mut gyro) = (entry.accel[0].1, entry.gyro[0].1);
        let find = |all: &[(u32, f64)], digits: &str| {
            let range = digits.parse::<u32>().ok()?;
            all.iter().find(|(one, _)| *one == range).map(|(_, counts)| *counts)
        };
        for part in parts {
            if let Some(digits) = part.strip_suffix("dps") {
                gyro = find(entry.gyro, digits).ok_or_else(known)?;
            } else {
                let digits = part.strip_suffix('g').ok_or_else(known)?;
                accel = find(entry.accel, digits).ok_or_else(known)?;
            }
        }
        Ok(Self { accel: Some(STANDARD_GRAVITY / accel), gyro: Some((1.0 / gyro).to_radians()) })
    }
}

impl Scales {
    /// Multiplies; what becomes infinite is left out.
    ///
    /// # Errors
    /// A temporary file that cannot be read or written.
    pub(crate) fn apply(self, samples: SampleStore) -> io::Result<SampleStore> {
        if self == Self::default() {
            return Ok(samples);
        }
        samples.changed(|s| Some(self.of(s)).filter(ImuSample::is_finite))
    }

    /// One sample, multiplied.
    pub(crate) fn of(self, sample: ImuSample) -> ImuSample {
        let (accel, gyro) = (self.accel.unwrap_or(1.0), self.gyro.unwrap_or(1.0));
        ImuSample { accel: sample.accel.map(|v| v * accel), gyro: sample.gyro.map(|v| v * gyro), ..sample }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sensors_range_gives_its_counts_and_what_is_unknown_names_what_is() {
        let of = |text: &str| text.parse::<Scales>().unwrap();
        assert_eq!(of("mpu6050-2g").accel, Some(9.80665 / 16384.0));
        assert_eq!(of("MPU6050-2g").gyro, of("mpu6050-2g-250dps").gyro);
        assert_eq!(of("bmi088-24g-125dps").gyro, Some((1.0f64 / 262.144).to_radians()));
        assert_eq!(of("icm-20948-16g"), of("icm20948-250dps-16g"));
        assert_eq!(of("adis16448").accel, Some(9.80665 / 1200.0));
        for bad in ["", "mpu9250", "mpu6050-3g", "mpu6050-2", "bmi088-2g", "mpu6050-2g-300dps"] {
            assert!(bad.parse::<Scales>().unwrap_err().contains("bmi088-{6/3/12/24}g-{2000/"), "{bad}");
        }
    }
}
