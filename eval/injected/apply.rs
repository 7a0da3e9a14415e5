//! Adding it.

use super::config::Injection;
use super::course::Course;
use dpn_core::random::Stream;
use dpn_core::{ImuNoise, ImuRecording, ImuSample, NoiseTrack, Sensor};
use rand_distr::{Distribution, StandardNormal};
use std::f64::consts::{SQRT_2, TAU};

/// Frequency of the tone \[Hz\]: where EuRoC's rotors are.
pub const TONE_HZ: f64 = 90.0;
/// Why what is added leaves a recording a recording.
const BOUNDED: &str = "a checked injection adds finite noise to finite samples";

impl Injection {
    /// The samples with what is added, and what an oracle says: at every sample and axis the root of the sum of squares of the white
    /// noise added and of the recording's own deviation. Noise comes from the stream (seed, "injected", course, the samples, sensor, axis).
    ///
    /// # Panics
    /// When the injection has [faults](dpn_core::config::Validate::faults): strengths that are no numbers would leave no recording.
    pub fn apply(&self, imu: &ImuRecording, seed: u64) -> (ImuRecording, NoiseTrack) {
        let samples = imu.samples();
        let start = samples[0].t;
        let length = imu.duration();
        let shares: Vec<f64> = samples.iter().map(|s| s.t.seconds_since(start) / length).collect();
        let stream = Stream::new(seed).named("injected").named(self.course.name()).named(&imu.checksum());
        let mut values: [[Vec<f64>; 3]; 2] = Default::default();
        let mut true_std: [[Vec<f64>; 3]; 2] = Default::default();
        for (place, sensor) in Sensor::ALL.into_iter().enumerate() {
            let (unit, own) = match sensor {
                Sensor::Accel => (self.accel, self.own_accel),
                Sensor::Gyro => (self.gyro, self.own_gyro),
            };
            for axis in 0..3 {
                let mut rng = stream.named(sensor.name()).index(axis as u64).rng();
                for (sample, share) in samples.iter().zip(&shares) {
                    let sigma = unit * self.course.white(*share, axis, self.factor);
                    let normal: f64 = StandardNormal.sample(&mut rng);
                    let more = match self.course {
                        Course::Tone if self.course.is_up(*share) => {
                            let phase = TAU * TONE_HZ * sample.t.seconds_since(start) + axis as f64;
                            SQRT_2 * unit * self.factor * phase.sin()
                        }
                        Course::BiasJump if self.course.is_up(*share) => unit * self.factor,
                        _ => sigma * normal,
                    };
                    values[place][axis].push(sample.of(sensor)[axis] + more);
                    true_std[place][axis].push(sigma.hypot(own));
                }
            }
        }
        let at = |of: &[Vec<f64>; 3], i: usize| [of[0][i], of[1][i], of[2][i]];
        let noisy = samples.iter().enumerate().map(|(i, s)| ImuSample {
            t: s.t,
            accel: at(&values[0], i),
            gyro: at(&values[1], i),
        });
        let noises = (0..samples.len())
            .map(|i| ImuNoise::from_values(at(&true_std[0], i), at(&true_std[1], i)).expect(BOUNDED));
        let stamps = samples.iter().map(|s| s.t).collect();
        let recording = ImuRecording::new(noisy.collect()).expect(BOUNDED);
        let oracle = NoiseTrack::new(stamps, noises.collect()).expect("a recording's stamps increase");
        (recording, oracle)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use dpn_core::Stamp;
    use dpn_core::signal::stats::{Ddof, deviation, mean};

    fn still(count: i64) -> ImuRecording {
        let sample =
            |i| ImuSample { t: Stamp::from_ns(5_000_000 * i), gyro: [0.1, 0.2, 0.3], accel: [1.0, 2.0, 9.8] };
        ImuRecording::new((0..count).map(sample).collect()).unwrap()
    }

    fn axis(recording: &ImuRecording, sensor: Sensor, axis: usize, from: usize, to: usize) -> Vec<f64> {
        recording.samples()[from..to].iter().map(|s| s.of(sensor)[axis]).collect()
    }

    #[test]
    fn what_is_added_has_the_deviation_that_the_oracle_says() {
        let imu = still(30_001);
        let injection = Injection { own_accel: 0.3, own_gyro: 0.02, ..Injection::default() };
        let (noisy, oracle) = injection.apply(&imu, 3);
        for (sensor, unit, own) in
            [(Sensor::Accel, injection.accel, 0.3), (Sensor::Gyro, injection.gyro, 0.02)]
        {
            for i in 0..3 {
                for (from, to, factor) in [(0, 9_900, 1.0), (10_100, 19_900, 5.0), (20_100, 30_001, 1.0)] {
                    let found = deviation(&axis(&noisy, sensor, i, from, to), Ddof::One);
                    // 9,800 samples: one in 140 of relative spread.
                    assert!((found / (unit * factor) - 1.0).abs() < 0.03, "{sensor} {i} {factor}: {found}");
                    let told = oracle.noises()[from].of(sensor)[i];
                    assert!((told - f64::hypot(unit * factor, own)).abs() < 1e-12);
                }
            }
        }
        assert_eq!(injection.apply(&imu, 3).0, noisy);
        assert_ne!(injection.apply(&imu, 4).0, noisy);
        // Another recording is other chance.
        let added =
            |noisy: &ImuRecording, of: &ImuRecording| noisy.samples()[5].gyro[0] - of.samples()[5].gyro[0];
        let other = still(30_000);
        assert_ne!(added(&injection.apply(&other, 3).0, &other), added(&noisy, &imu));
    }

    #[test]
    #[should_panic(expected = "a checked injection")]
    fn an_injection_of_no_number_is_not_passed_off_as_the_recording_without_it() {
        Injection { accel: f64::NAN, ..Injection::default() }.apply(&still(100), 0);
    }

    #[test]
    fn tone_and_bias_add_no_white_noise_and_nothing_adds_nothing() {
        let imu = still(9_001);
        let base = Injection::default();
        let (same, told) = base.with(Course::None).apply(&imu, 0);
        assert_eq!(same, imu);
        assert!(told.noises().iter().all(|n| (n.of(Sensor::Accel)[0] - base.own_accel).abs() < 1e-15));
        let (tone, told) = base.with(Course::Tone).apply(&imu, 0);
        assert_eq!(tone.samples()[..3000], imu.samples()[..3000]);
        let found = deviation(&axis(&tone, Sensor::Gyro, 2, 3_100, 5_900), Ddof::Zero);
        assert!((found / (base.gyro * base.factor) - 1.0).abs() < 0.01, "{found}");
        assert!(told.noises().iter().all(|n| (n.of(Sensor::Gyro)[0] - base.own_gyro).abs() < 1e-15));
        let (jump, _) = base.with(Course::BiasJump).apply(&imu, 0);
        let moved = mean(&axis(&jump, Sensor::Accel, 1, 4_600, 9_000)) - 2.0;
        assert!((moved - base.accel * base.factor).abs() < 1e-9);
    }
}
