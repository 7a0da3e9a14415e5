//! The parts an IMU recording was put together from.
//!
//! recording = clean + vibration + bias + white, added in this order, then + quantisation error. With quantisation
//! switched off the sum is the recording bit for bit; with it, to the rounding of one more addition (4e-15 of a value).

use super::series::ImuSeries;
use dpn_core::noise::TrackError;
use dpn_core::{ImuNoise, ImuRecording, NoiseTrack, Sensor};

/// Every part of a recording, on its samples.
#[derive(Debug, Clone, PartialEq)]
pub struct ImuTruth {
    /// What an ideal IMU reads, the frame's shaking included: it is motion.
    pub clean: ImuSeries,
    /// The rotors' tones, sampled too slowly.
    pub vibration: ImuSeries,
    /// Biases.
    pub bias: ImuSeries,
    /// White noise.
    pub white: ImuSeries,
    /// Standard deviation each sample of the white noise was drawn with.
    pub white_sigma: ImuSeries,
    /// Rounded reading minus exact reading.
    pub quantisation: ImuSeries,
}

impl ImuTruth {
    /// All parts but the last together: the reading before rounding.
    pub(crate) fn unrounded(&self) -> ImuSeries {
        let mut sum = self.clean.clone();
        for sensor in Sensor::ALL {
            for part in [&self.vibration, &self.bias, &self.white] {
                for (total, value) in sum.of_mut(sensor).iter_mut().zip(part.of(sensor)) {
                    for axis in 0..3 {
                        total[axis] += value[axis];
                    }
                }
            }
        }
        sum
    }

    /// The deviation of the white noise as a noise track on the recording's stamps: what an oracle says.
    ///
    /// # Errors
    /// `recording` is not the one these parts belong to (another length).
    pub fn oracle(&self, recording: &ImuRecording) -> Result<NoiseTrack, TrackError> {
        let stamps = recording.samples().iter().map(|s| s.t).collect();
        let sigmas = self.white_sigma.accel.iter().zip(&self.white_sigma.gyro);
        let noise = |(&accel, &gyro)| {
            ImuNoise::from_values(accel, gyro).expect("noise was drawn with a finite deviation of 0 or more")
        };
        NoiseTrack::new(stamps, sigmas.map(noise).collect())
    }
}
