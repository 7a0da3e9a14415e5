//! Recordings at the rate that is trained for.
//!
//! Means over blocks where the ratio of the rates is whole: of white noise they are exactly white, with the density it had. Else the low pass of
//! [`resampled`], behind which the last tenth below half the rate holds less than white noise. A rate within 5 % is left as it is, as when networks are asked.

use dpn_core::check::CheckOptions;
use dpn_core::imu::RecordingError;
use dpn_core::signal::resample::resampled;
use dpn_core::signal::{BlockLength, block_means};
use dpn_core::{ImuRecording, SampleRate};
use thiserror::Error;

/// Why a recording cannot be brought to a rate.
#[derive(Debug, Error, PartialEq)]
pub enum RateError {
    /// It is slower.
    #[error(
        "it has {found_hz:.1} Hz, and windows of {wanted_hz:.1} Hz are asked for; what was not sampled cannot be made"
    )]
    Slower {
        /// Its rate \[Hz\].
        found_hz: f64,
        /// The rate asked for \[Hz\].
        wanted_hz: f64,
    },
    /// Too few samples are left at that rate.
    #[error("too short to be brought to {wanted_hz:.1} Hz: {source}")]
    Short {
        /// The rate asked for \[Hz\].
        wanted_hz: f64,
        /// What is missing.
        source: RecordingError,
    },
}

/// `recording` at `rate`.
///
/// # Errors
/// One that is more than 5 % slower, or too short.
pub fn at_rate(recording: ImuRecording, rate: SampleRate) -> Result<ImuRecording, RateError> {
    let (own, wanted_hz) = (recording.rate(), rate.hz());
    let length = BlockLength::of(own, rate).ok_or(RateError::Slower { found_hz: own.hz(), wanted_hz })?;
    let samples = if length.meets(own, rate) {
        if length == BlockLength::ONE {
            return Ok(recording);
        }
        let gap_s = CheckOptions::default().gap_periods * own.period();
        block_means(recording.samples(), length, gap_s)
    } else {
        resampled(recording.samples(), own, rate)
    };
    ImuRecording::new(samples).map_err(|source| RateError::Short { wanted_hz, source })
}

#[cfg(test)]
mod tests {
    use super::*;
    use dpn_core::random::Stream;
    use dpn_core::signal::stats::{Ddof, deviation};
    use dpn_core::{ImuSample, Sensor, Stamp};
    use rand::Rng;
    use rand_distr::StandardNormal;

    fn noise(hz: f64, samples: i64) -> ImuRecording {
        let mut rng = Stream::new(1).named("rate").rng();
        let mut axes = |about: f64| [0; 3].map(|_| about + rng.sample::<f64, _>(StandardNormal));
        let sample = |i: i64| ImuSample {
            t: Stamp::from_ns((1e9 / hz * i as f64) as i64),
            gyro: axes(0.0),
            accel: axes(9.8),
        };
        ImuRecording::new((0..samples).map(sample).collect()).unwrap()
    }

    fn to(hz: f64) -> SampleRate {
        SampleRate::from_hz(hz).unwrap()
    }

    #[test]
    fn white_noise_keeps_its_density_at_every_lower_rate() {
        // At a whole ratio all of it, else nine tenths of what lies below half the rate.
        for (from, rate, passes) in
            [(200.0, 100.0, 1.0), (200.0, 50.0, 1.0), (199.4, 100.0, 1.0), (125.0, 100.0, 0.9)]
        {
            let found = at_rate(noise(from, 40_000), to(rate)).unwrap();
            assert!((found.rate().hz() / rate - 1.0).abs() < 0.01, "{from} to {rate}: {}", found.rate().hz());
            let sigma = deviation(&found.axis(Sensor::Accel, 1), Ddof::One);
            let expected = (passes * rate / from).sqrt();
            assert!((sigma / expected - 1.0).abs() < 0.03, "{from} to {rate}: {sigma} {expected}");
        }
        let same = noise(205.0, 300);
        assert_eq!(at_rate(same.clone(), to(200.0)).unwrap().samples(), same.samples());
    }

    #[test]
    fn a_slower_recording_and_one_that_is_too_short_are_refused() {
        let slower = at_rate(noise(100.0, 400), to(200.0)).unwrap_err();
        assert!(matches!(slower, RateError::Slower { .. }), "{slower}");
        assert!(matches!(at_rate(noise(200.0, 3), to(50.0)).unwrap_err(), RateError::Short { .. }));
    }
}
