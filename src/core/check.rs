//! The health of a recording that could be read: rate, gaps, clipped and dead axes, length.
//!
//! Nothing here is an error by itself. A caller knows what it needs and decides which faults are fatal.

use crate::imu::{ImuRecording, Sensor};
use crate::plateaus::{Plateau, extremes};
use crate::samples::Samples;
use crate::signal::stats::median_of;
use crate::time::{SampleRate, Stamp};
use std::io;
use thiserror::Error;

/// What a recording is held against.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CheckOptions {
    /// The rate it should have; `None` asks for none.
    pub expected_rate: Option<SampleRate>,
    /// How far the median rate may be off, relative; from 0.
    pub rate_tolerance: f64,
    /// The fewest samples of use.
    pub min_samples: usize,
    /// A step longer than this many median periods is a gap; above 1.
    pub gap_periods: f64,
}

impl Default for CheckOptions {
    /// No expected rate (1 % once one is set), two samples, gaps from 1.5 periods on.
    fn default() -> Self {
        Self { expected_rate: None, rate_tolerance: 0.01, min_samples: 2, gap_periods: 1.5 }
    }
}

/// A hole in a recording.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Gap {
    /// Index of the last sample before it.
    pub index: usize,
    /// Stamp of that sample.
    pub after: Stamp,
    /// From that sample to the next \[s\].
    pub seconds: f64,
}

/// What a check found.
#[derive(Debug, Clone, PartialEq)]
pub struct Findings {
    /// The median rate.
    pub rate: SampleRate,
    /// Every gap, oldest first.
    pub gaps: Vec<Gap>,
    /// What is wrong, in the order of [`RecordingFault`]'s variants.
    pub faults: Vec<RecordingFault>,
}

/// Something a caller may not want to work with. `Display` says what and where, [`RecordingFault::hint`] what to do.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum RecordingFault {
    /// Fewer samples than needed.
    #[error("{found} samples; at least {needed} are needed")]
    TooShort {
        /// How many there are.
        found: usize,
        /// How many are needed.
        needed: usize,
    },
    /// Another rate than expected.
    #[error("the rate is {found_hz:.2} Hz; {expected_hz:.2} Hz is expected")]
    WrongRate {
        /// Median rate \[Hz\].
        found_hz: f64,
        /// Expected rate \[Hz\].
        expected_hz: f64,
    },
    /// Steps much longer than the median one.
    #[error(
        "{count} gap(s), {total_s:.3} s in all; the longest lasts {longest_s:.3} s after {} ns",
        longest_after.ns()
    )]
    Gaps {
        /// How many.
        count: usize,
        /// Their lengths together \[s\].
        total_s: f64,
        /// The longest \[s\].
        longest_s: f64,
        /// Stamp before the longest.
        longest_after: Stamp,
    },
    /// An axis that stays at its extreme value.
    #[error(
        "{sensor} {} is saturated: it stays at {value} {} for {longest} samples, first at {} ns",
        axis_name(*axis), sensor.unit(), first.ns()
    )]
    Saturated {
        /// The sensor.
        sensor: Sensor,
        /// 0, 1, 2 for x, y, z.
        axis: usize,
        /// The extreme value, in the sensor's unit.
        value: f64,
        /// Length of the longest plateau \[samples\].
        longest: usize,
        /// Stamp at which the first plateau begins.
        first: Stamp,
    },
    /// An axis that never changes.
    #[error("{sensor} {} is dead: it reads {value} {} throughout", axis_name(*axis), sensor.unit())]
    Constant {
        /// The sensor.
        sensor: Sensor,
        /// 0, 1, 2 for x, y, z.
        axis: usize,
        /// Its only value, in the sensor's unit.
        value: f64,
    },
}

impl RecordingFault {
    /// What to do about it.
    pub fn hint(&self) -> Option<String> {
        let text = match self {
            Self::TooShort { .. } => "record for longer",
            Self::WrongRate { .. } => {
                "look at the unit of the stamps, or resample a faster log (dpn convert --to-rate HZ); noise per sample depends on the rate"
            }
            Self::Gaps { .. } => "cut the log at the gaps, or look for dropped messages in its driver",
            Self::Saturated { .. } => {
                "choose a larger measuring range, or cut these parts; noise cannot be told there"
            }
            Self::Constant { .. } => "look at the wiring or the column; a live sensor is never without noise",
        };
        Some(text.to_owned())
    }
}

impl RecordingFault {
    /// Gaps in one sentence; `None` where there are none.
    pub fn of_gaps(gaps: &[Gap]) -> Option<Self> {
        let longest = gaps.iter().max_by(|a, b| a.seconds.total_cmp(&b.seconds))?;
        Some(Self::Gaps {
            count: gaps.len(),
            total_s: gaps.iter().map(|gap| gap.seconds).sum(),
            longest_s: longest.seconds,
            longest_after: longest.after,
        })
    }
}

fn axis_name(axis: usize) -> &'static str {
    ["x", "y", "z"][axis]
}

/// Looks at a recording as a whole.
pub fn check(recording: &ImuRecording, options: &CheckOptions) -> Findings {
    let rate = recording.rate();
    let mut faults = Vec::new();
    if recording.len() < options.min_samples {
        faults.push(RecordingFault::TooShort { found: recording.len(), needed: options.min_samples });
    }
    if let Some(expected) = options.expected_rate
        && (rate.hz() / expected.hz() - 1.0).abs() > options.rate_tolerance
    {
        faults.push(RecordingFault::WrongRate { found_hz: rate.hz(), expected_hz: expected.hz() });
    }
    let gaps = gaps(recording, rate.period() * options.gap_periods);
    faults.extend(RecordingFault::of_gaps(&gaps));
    faults.extend(stuck(recording).expect("a recording lies in memory"));
    Findings { rate, gaps, faults }
}

/// Axes that stay at an extreme value, then those that never change.
///
/// # Errors
/// As [`Samples::piece`].
pub fn stuck(samples: &dyn Samples) -> io::Result<Vec<RecordingFault>> {
    let (mut saturated, mut constant) = (Vec::new(), Vec::new());
    for found in extremes(samples)? {
        let (sensor, axis) = (found.sensor, found.axis);
        constant.extend(found.constant().map(|value| RecordingFault::Constant { sensor, axis, value }));
        for Plateau { value, longest, first } in found.plateaus {
            let first = samples.at(first)?.t;
            saturated.push(RecordingFault::Saturated { sensor, axis, value, longest, first });
        }
    }
    saturated.extend(constant);
    Ok(saturated)
}

/// Steps from sample to sample that take more than so many seconds, oldest first.
pub fn gaps(recording: &ImuRecording, longer_than: f64) -> Vec<Gap> {
    let pairs = recording.samples().windows(2).enumerate();
    pairs
        .filter_map(|(index, pair)| {
            let seconds = pair[1].t.seconds_since(pair[0].t);
            (seconds > longer_than).then_some(Gap { index, after: pair[0].t, seconds })
        })
        .collect()
}

/// Whether the steps around the one behind the sample `index`, of `step` seconds, are as much shorter as that is longer than the `period`: stamps of arrival, and no sample
/// lost. The median over spans of several lengths, whose ends jitter too.
///
/// # Errors
/// As [`Samples::piece`].
pub fn is_made_up(samples: &dyn Samples, index: usize, step: f64, period: f64) -> io::Result<bool> {
    const ENDS: usize = 9;
    let reach = 2 * (step / period).round() as usize + 8;
    let (from, to) = (index.saturating_sub(reach + ENDS), (index + 1 + reach + ENDS).min(samples.len() - 1));
    let before = samples.piece(from..(from + ENDS).min(index + 1))?;
    let after = samples.piece((to + 1).saturating_sub(ENDS).max(index + 1)..to + 1)?;
    let missing = before
        .iter()
        .enumerate()
        .zip(after.iter().rev().enumerate())
        .map(|((i, a), (k, b))| b.t.seconds_since(a.t) / period - (to - k - (from + i)) as f64);
    let missing = median_of(missing).expect("a step has a sample on both sides");
    Ok(missing < 0.5 * ((step / period).round() - 1.0).max(1.0))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::imu::ImuSample;
    use crate::random::Stream;
    use rand::Rng;
    use rand_distr::{Distribution, StandardNormal};

    /// Ten seconds at 200 Hz: a slow turn with noise, in counts of the ADIS16448.
    fn healthy() -> Vec<ImuSample> {
        let mut rng = Stream::new(1).named("check").rng();
        let count = |value: f64, unit: f64| (value / unit).round() * unit;
        (0..2000)
            .map(|i| {
                let mut noise = |sigma: f64| {
                    sigma * <StandardNormal as Distribution<f64>>::sample(&StandardNormal, &mut rng)
                };
                let turn = (f64::from(i) * 0.005).sin();
                ImuSample {
                    t: Stamp::from_ns(i64::from(i) * 5_000_000),
                    gyro: [turn, -turn, 0.0].map(|v| count(v + noise(0.0024), 6.981_317e-4)),
                    accel: [turn, 0.0, 9.81].map(|v| count(v + noise(0.028), 8.172_208e-3)),
                }
            })
            .collect()
    }

    fn faults(samples: Vec<ImuSample>, options: &CheckOptions) -> Vec<RecordingFault> {
        check(&ImuRecording::new(samples).unwrap(), options).faults
    }

    #[test]
    fn a_healthy_recording_has_no_faults_moving_or_at_rest() {
        let options = CheckOptions {
            expected_rate: Some(SampleRate::HZ_200),
            min_samples: 200,
            ..CheckOptions::default()
        };
        assert_eq!(faults(healthy(), &options), []);
        // At rest with a coarse converter: a handful of counts, each repeated all the time.
        let mut rng = Stream::new(2).named("check").rng();
        let mut rest = healthy();
        for sample in &mut rest {
            sample.gyro = [0; 3].map(|_: i32| f64::from(rng.random_range(-1..=1)) * 0.01);
            sample.accel = [0; 3].map(|_: i32| f64::from(rng.random_range(-1..=1)) * 0.01);
        }
        assert_eq!(faults(rest, &options), []);
    }

    #[test]
    fn clipped_axes_are_found_with_value_and_place() {
        let mut samples = healthy();
        let limit = samples[0].gyro[1] - 300.0 * 6.981_317e-4;
        for sample in &mut samples {
            // A turn beyond the gyroscope's range: one long plateau, with noise of a few counts at its ends.
            sample.gyro[1] = sample.gyro[1].max(limit);
            // Vibration that hits the accelerometer's: many short ones.
            sample.accel[2] += 30.0 * (sample.t.ns() as f64 * 1e-9 * 40.0).sin();
            sample.accel[2] = sample.accel[2].min(20.0);
        }
        let said: Vec<_> =
            faults(samples, &CheckOptions::default()).iter().map(ToString::to_string).collect();
        assert_eq!(said.len(), 2, "{said:?}");
        assert!(said[0].starts_with("accel z is saturated: it stays at 20 m/s^2 for 1"), "{said:?}");
        assert!(said[0].ends_with("first at 10000000 ns"), "{said:?}");
        assert!(said[1].starts_with("gyro y is saturated: it stays at -0.2"), "{said:?}");
    }

    #[test]
    fn the_flat_top_of_a_slow_turn_without_noise_is_not_saturation() {
        let mut samples = healthy();
        for (i, sample) in samples.iter_mut().enumerate() {
            sample.gyro[0] = ((i as f64 * 0.005).sin() * 500.0).round() * 1e-3;
        }
        assert_eq!(faults(samples, &CheckOptions::default()), []);
    }

    #[test]
    fn gaps_rate_length_and_dead_axes_are_told() {
        let mut samples = healthy();
        samples.drain(100..104);
        samples.remove(500);
        for sample in &mut samples {
            sample.gyro[2] = 0.25;
        }
        let options = CheckOptions {
            expected_rate: SampleRate::from_hz(100.0),
            min_samples: 5000,
            ..CheckOptions::default()
        };
        let findings = check(&ImuRecording::new(samples).unwrap(), &options);
        assert_eq!(findings.gaps.len(), 2);
        assert_eq!(findings.gaps[0].index, 99);
        assert!((findings.gaps[0].seconds - 0.025).abs() < 1e-12);
        let said: Vec<_> = findings.faults.iter().map(ToString::to_string).collect();
        assert_eq!(
            said,
            [
                "1995 samples; at least 5000 are needed",
                "the rate is 200.00 Hz; 100.00 Hz is expected",
                "2 gap(s), 0.035 s in all; the longest lasts 0.025 s after 495000000 ns",
                "gyro z is dead: it reads 0.25 rad/s throughout",
            ]
        );
        assert!(findings.faults.iter().all(|f| f.hint().is_some()));
    }
}
