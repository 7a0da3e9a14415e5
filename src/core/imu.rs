//! IMU samples and recordings.

use crate::checksum::of_parts;
use crate::named;
use crate::time::{SampleRate, Stamp, median_step_ns};
use serde::{Deserialize, Serialize};
use thiserror::Error;

named!(
    /// Which of the two inertial sensors a thing speaks of.
    #[derive(PartialOrd, Ord, Serialize, Deserialize)]
    #[serde(rename_all = "lowercase")]
    pub enum Sensor {
        /// Accelerometer: specific force \[m/s^2\].
        Accel = "accel",
        /// Gyroscope: angular rate \[rad/s\].
        Gyro = "gyro",
    }
);

impl Sensor {
    /// Unit of a sample and of its standard deviation.
    pub fn unit(self) -> &'static str {
        match self {
            Self::Accel => "m/s^2",
            Self::Gyro => "rad/s",
        }
    }
}

/// One reading of all six axes, in the body frame (= IMU frame).
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct ImuSample {
    /// When it was taken.
    pub t: Stamp,
    /// Angular rate \[rad/s\].
    pub gyro: [f64; 3],
    /// Specific force \[m/s^2\]; `(0, 0, +9.81)` at rest and level.
    pub accel: [f64; 3],
}

impl ImuSample {
    /// The three axes of one sensor.
    pub fn of(&self, sensor: Sensor) -> [f64; 3] {
        match sensor {
            Sensor::Accel => self.accel,
            Sensor::Gyro => self.gyro,
        }
    }

    /// Whether all six values are finite.
    pub fn is_finite(&self) -> bool {
        self.gyro.iter().chain(&self.accel).all(|v| v.is_finite())
    }
}

/// Why samples are not a recording.
#[derive(Debug, Error, PartialEq)]
pub enum RecordingError {
    /// No sample, or one only.
    #[error("{found} samples; a recording needs at least 2")]
    TooShort {
        /// How many there are.
        found: usize,
    },
    /// Stamps that stand still or go back.
    #[error("time goes from {prev_ns} to {t_ns} ns at sample {index}; stamps must increase")]
    TimeNotIncreasing {
        /// Index of the offending sample.
        index: usize,
        /// Stamp before it.
        prev_ns: i64,
        /// Its stamp.
        t_ns: i64,
    },
    /// NaN or infinity.
    #[error("sample {index} holds a value that is not finite")]
    NotFinite {
        /// Index of the offending sample.
        index: usize,
    },
}

/// Samples in increasing time, finite, at least two: checked once, trusted afterwards.
#[derive(Debug, Clone, PartialEq)]
pub struct ImuRecording {
    samples: Vec<ImuSample>,
}

impl ImuRecording {
    /// Checks `samples` and takes them.
    ///
    /// # Errors
    /// Fewer than two samples, a stamp that does not increase, a value that is not finite.
    pub fn new(samples: Vec<ImuSample>) -> Result<Self, RecordingError> {
        if samples.len() < 2 {
            return Err(RecordingError::TooShort { found: samples.len() });
        }
        for (index, sample) in samples.iter().enumerate() {
            if !sample.is_finite() {
                return Err(RecordingError::NotFinite { index });
            }
            if index > 0 && samples[index - 1].t >= sample.t {
                return Err(RecordingError::TimeNotIncreasing {
                    index,
                    prev_ns: samples[index - 1].t.ns(),
                    t_ns: sample.t.ns(),
                });
            }
        }
        Ok(Self { samples })
    }

    /// The samples, oldest first.
    pub fn samples(&self) -> &[ImuSample] {
        &self.samples
    }

    /// SHA-256 over stamps and values.
    pub fn checksum(&self) -> String {
        of_parts(self.samples.iter().map(|sample| {
            let values = sample.accel.into_iter().chain(sample.gyro).flat_map(f64::to_le_bytes);
            sample.t.ns().to_le_bytes().into_iter().chain(values).collect::<Vec<u8>>()
        }))
    }

    /// Gives them away.
    pub fn into_samples(self) -> Vec<ImuSample> {
        self.samples
    }

    /// Number of samples.
    pub fn len(&self) -> usize {
        self.samples.len()
    }

    /// Never: a recording has at least two samples.
    pub fn is_empty(&self) -> bool {
        self.samples.is_empty()
    }

    /// From the first to the last stamp \[s\].
    pub fn duration(&self) -> f64 {
        self.samples[self.samples.len() - 1].t.seconds_since(self.samples[0].t)
    }

    /// The median rate: robust against gaps and jitter.
    pub fn rate(&self) -> SampleRate {
        let median = median_step_ns(self.samples.iter().map(|s| s.t)).expect("there are two samples");
        SampleRate::from_hz(1e9 / median as f64).expect("stamps increase: a step is a nanosecond or more")
    }

    /// One axis (0, 1, 2) of one sensor as a contiguous signal.
    ///
    /// # Panics
    /// When `axis` is above 2.
    pub fn axis(&self, sensor: Sensor, axis: usize) -> Vec<f64> {
        assert!(axis < 3, "an IMU sensor has axes 0, 1, 2, not {axis}");
        self.samples.iter().map(|s| s.of(sensor)[axis]).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sample(t: i64) -> ImuSample {
        ImuSample { t: Stamp::from_ns(t), gyro: [0.0; 3], accel: [0.0, 0.0, 9.81] }
    }

    #[test]
    fn a_stamp_that_stands_still_is_refused_with_its_index() {
        let error = ImuRecording::new(vec![sample(0), sample(5), sample(5)]).unwrap_err();
        assert_eq!(error, RecordingError::TimeNotIncreasing { index: 2, prev_ns: 5, t_ns: 5 });
    }

    #[test]
    fn nan_is_refused() {
        let mut bad = sample(5);
        bad.gyro[1] = f64::NAN;
        assert_eq!(
            ImuRecording::new(vec![sample(0), bad]).unwrap_err(),
            RecordingError::NotFinite { index: 1 }
        );
    }

    #[test]
    fn one_gap_does_not_move_the_rate() {
        let mut samples: Vec<_> = (0..100).map(|i| sample(i * 5_000_000)).collect();
        samples.push(sample(3_000_000_000));
        let rate = ImuRecording::new(samples).unwrap().rate();
        assert!((rate.hz() - 200.0).abs() < 1e-9);
    }
}
