//! Estimators on all six axes as a noise model.

use super::{AxisSigma, Reading};
use crate::imu::{ImuSample, Sensor};
use crate::noise::{AccelSampleStd, GyroSampleStd, ImuNoise, NoiseModel};
use crate::time::SampleRate;

/// When estimators are asked: for how many samples, how often.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Schedule {
    /// Samples in a window; until so many have come, the baseline holds.
    pub window: usize,
    /// Samples from one question to the next.
    pub hop: usize,
    /// Rate of the samples: what is meant by seconds and Hertz.
    pub rate: SampleRate,
}

impl Default for Schedule {
    /// 1 s at 200 Hz, asked at 20 Hz, once a camera frame (decision 19).
    fn default() -> Self {
        Self { window: 200, hop: 10, rate: SampleRate::HZ_200 }
    }
}

/// Estimates below this share of EuRoC's data sheet are raised to it.
const FLOOR_SHARE: f64 = 0.01;
/// Deviation of one sample by EuRoC's data sheet: density times the root of 200 Hz, in m/s^2 and rad/s.
const DATA_SHEET: [f64; 2] = [2.0e-3 * ROOT_200, 1.6968e-4 * ROOT_200];
const ROOT_200: f64 = 14.142_135_623_730_951;

/// Smallest deviation an estimate may claim, in the sensor's unit: a hundredth of EuRoC's data-sheet deviation per
/// sample (2.8e-4 m/s^2, 2.4e-5 rad/s), below a tenth of what quantisation alone adds there.
///
/// A constant axis would otherwise get zero noise, whose information is infinite, and break what is fed with it.
pub(crate) fn sigma_floor(sensor: Sensor) -> f64 {
    FLOOR_SHARE
        * match sensor {
            Sensor::Accel => DATA_SHEET[0],
            Sensor::Gyro => DATA_SHEET[1],
        }
}

/// A noise with every deviation at least `sigma_floor`: a network may say zero, whose information is infinite.
pub fn raised_to_floor(noise: &ImuNoise) -> ImuNoise {
    let of = |sensor| noise.of(sensor).map(|sigma| sigma.max(sigma_floor(sensor)));
    ImuNoise::from_values(of(Sensor::Accel), of(Sensor::Gyro))
        .expect("deviations only grew, to a finite floor")
}

/// One source of deviation an axis, together a noise model.
///
/// Causal: the noise at a sample rests on that sample and those before. Until an axis has an estimate it answers with
/// the baseline, `ImuNoise::baseline()`, as it does where an estimate is not finite; estimates below [`sigma_floor`] are
/// raised to it; given figures are taken as they are. Samples are counted, not timed: a gap in the recording leaves
/// older samples in the window.
pub(crate) struct Windowed {
    name: String,
    accel: [Box<dyn AxisSigma>; 3],
    gyro: [Box<dyn AxisSigma>; 3],
}

impl Windowed {
    /// A model called `name` from one source an axis: x, y, z of both sensors.
    pub(crate) fn new(
        name: impl Into<String>,
        accel: [Box<dyn AxisSigma>; 3],
        gyro: [Box<dyn AxisSigma>; 3],
    ) -> Self {
        Self { name: name.into(), accel, gyro }
    }
}

/// What a reading says; nothing before the first estimate.
fn settled(reading: Reading, sensor: Sensor) -> Option<f64> {
    match reading {
        Reading::NotYet => None,
        Reading::Given(sigma) => Some(sigma),
        Reading::Estimate(sigma) if sigma < sigma_floor(sensor) => Some(sigma_floor(sensor)),
        Reading::Estimate(sigma) => Some(sigma),
    }
}

impl NoiseModel for Windowed {
    fn name(&self) -> &str {
        &self.name
    }

    fn feed(&mut self, sample: &ImuSample) -> ImuNoise {
        let mut noise = ImuNoise::baseline();
        // What is no deviation, from samples whose squares are beyond all numbers, leaves the baseline too.
        for axis in 0..3 {
            let sigma = settled(self.accel[axis].feed(sample.accel[axis]), Sensor::Accel);
            if let Some(Ok(sigma)) = sigma.map(AccelSampleStd::new) {
                noise.accel[axis] = sigma;
            }
            let sigma = settled(self.gyro[axis].feed(sample.gyro[axis]), Sensor::Gyro);
            if let Some(Ok(sigma)) = sigma.map(GyroSampleStd::new) {
                noise.gyro[axis] = sigma;
            }
        }
        noise
    }

    fn reset(&mut self) {
        self.accel.iter_mut().chain(&mut self.gyro).for_each(|axis| axis.reset());
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::estimate::NoiseSpec;
    use crate::noise::NoiseTrack;
    use crate::random::Stream;
    use crate::{ImuRecording, Stamp};
    use rand::Rng;
    use rand_distr::StandardNormal;

    fn recording(len: usize) -> ImuRecording {
        let mut rng = Stream::new(1).named("estimate").named("recording").rng();
        let mut draw = |sigma: f64| sigma * rng.sample::<f64, _>(StandardNormal);
        let samples = (0..len)
            .map(|i| ImuSample {
                t: Stamp::from_ns(i as i64 * 5_000_000),
                gyro: [draw(0.003), draw(0.004), 0.25],
                accel: [draw(0.1), draw(0.2), 9.81 + draw(0.05)],
            })
            .collect();
        ImuRecording::new(samples).unwrap()
    }

    fn model(spec: &str) -> Box<dyn NoiseModel> {
        let NoiseSpec::Sensors(pair) = spec.parse().unwrap() else { panic!("{spec} is made elsewhere") };
        pair.model(Schedule::default()).unwrap()
    }

    const EVERY_KIND: [&str; 13] = [
        "sg(11,2)",
        "diff1",
        "diff2",
        "diff3",
        "diff4",
        "mad2",
        "wavelet",
        "allan",
        "running",
        "sliding",
        "ewma",
        "kalman",
        "effective",
    ];

    #[test]
    fn the_track_of_a_cut_recording_is_the_prefix_of_the_whole_bit_for_bit() {
        let whole = recording(700);
        for spec in EVERY_KIND {
            let mut model = model(spec);
            let full = NoiseTrack::of(model.as_mut(), &whole);
            for cut in [2, 199, 200, 201, 455] {
                let part = ImuRecording::new(whole.samples()[..cut].to_vec()).unwrap();
                let track = NoiseTrack::of(model.as_mut(), &part);
                assert_eq!(track.noises(), &full.noises()[..cut], "{spec} cut at {cut}");
            }
        }
    }

    #[test]
    fn the_baseline_holds_until_the_first_window_is_full() {
        for spec in EVERY_KIND {
            let mut model = model(spec);
            let track = NoiseTrack::of(model.as_mut(), &recording(300));
            assert!(track.noises()[..199].iter().all(|n| *n == ImuNoise::baseline()), "{spec}");
            assert_ne!(track.noises()[199], ImuNoise::baseline(), "{spec}");
        }
    }

    #[test]
    fn a_constant_axis_gets_the_floor_and_the_others_their_own_deviation() {
        for spec in EVERY_KIND {
            let mut model = model(spec);
            let track = NoiseTrack::of(model.as_mut(), &recording(400));
            let last = track.noises()[399];
            assert_eq!(last.of(Sensor::Gyro)[2], sigma_floor(Sensor::Gyro), "{spec}");
            for (sigma, truth) in last.of(Sensor::Accel).iter().zip([0.1, 0.2, 0.05]) {
                assert!((sigma / truth - 1.0).abs() < 0.5, "{spec}: {sigma} for {truth}");
            }
        }
    }

    #[test]
    fn a_pair_gives_each_sensor_its_own_source() {
        let both = NoiseTrack::of(model("diff2,x2").as_mut(), &recording(400));
        let one = NoiseTrack::of(model("diff2").as_mut(), &recording(400));
        for (a, b) in both.noises().iter().zip(one.noises()) {
            assert_eq!(a.accel, b.accel);
            assert_eq!(a.of(Sensor::Gyro), [0.008; 3]);
        }
    }

    #[test]
    fn given_figures_are_not_raised_to_the_floor() {
        let noise = model("const(1e-6,1e-8)").feed(&recording(2).samples()[0]);
        assert_eq!((noise.of(Sensor::Accel), noise.of(Sensor::Gyro)), ([1e-6; 3], [1e-8; 3]));
    }
}
