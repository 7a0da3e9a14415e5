//! Both networks as one causal source of noise.

use crate::predictor::Predictor;
use crate::range::{Quietest, TrainedRange};
use crate::weights::Weights;
use dpn_core::imu::ImuSample;
use dpn_core::noise::{AccelSampleStd, GyroSampleStd, ImuNoise, NoiseModel};
use dpn_core::{SampleRate, Sensor};
use serde::Serialize;
use thiserror::Error;

/// Why two networks are no pair.
#[derive(Debug, Error, PartialEq)]
pub enum PairError {
    /// One of them is for the other sensor.
    #[error("a network for the {found} was given as the {wanted}'s; give the {wanted}'s weights there")]
    Sensor {
        /// What it is for.
        found: Sensor,
        /// What it was given as.
        wanted: Sensor,
    },
    /// Trained at different rates.
    #[error(
        "the accelerometer's network was trained at {accel_hz} Hz, the gyroscope's at {gyro_hz} Hz; give two of one rate"
    )]
    Rates {
        /// Rate of the accelerometer's windows \[Hz\].
        accel_hz: f64,
        /// Rate of the gyroscope's windows \[Hz\].
        gyro_hz: f64,
    },
    /// Never asked.
    #[error("a hop of 0 samples; the networks must be asked every 1 or more samples")]
    Hop,
}

/// How many windows were judged, and how many of them were unlike those of the training.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize)]
pub struct RangeCount {
    /// Windows judged, an axis each.
    pub windows: u64,
    /// Of these, outside the trained range, or answered by what is no number.
    pub outside: u64,
}

/// Accel-ProNet and Gyro-ProNet, asked every `hop` samples about the samples just past, held in between.
///
/// Until a sensor's first full window the paper's baseline constants are in force for it. The networks know samples, not
/// time: who feeds them brings samples to the training's rate, nothing is resampled here. A network's
/// deviation that is not above zero (some heads allow it) is taken as zero.
#[derive(Debug)]
pub struct DualProNet {
    name: String,
    hop: usize,
    rate: SampleRate,
    accel: Channel,
    gyro: Channel,
    fed: u64,
    noise: ImuNoise,
}

/// One sensor's network and what of the stream it needs.
#[derive(Debug)]
struct Channel {
    sensor: Sensor,
    predictor: Predictor,
    range: Option<TrainedRange>,
    /// Where the range has what it says.
    quietest: Option<Quietest>,
    window: usize,
    /// The last samples of every axis, twice over, so that any window of them is contiguous.
    past: [Vec<f32>; 3],
    windows: Vec<f32>,
    count: RangeCount,
    /// Axes that were answered by a deviation.
    answered: [bool; 3],
    /// Of the last answers' logarithms, where the network says it and was asked.
    spread: Option<[f64; 3]>,
}

impl DualProNet {
    /// The paper's hop: one camera frame at 20 Hz, with samples at 200 Hz.
    pub const HOP: usize = 10;

    /// Largest share by which the rate of the samples may differ from that of the training.
    pub const RATE_TOLERANCE: f64 = 0.05;

    /// The pair of these weights, asked every `hop` samples.
    ///
    /// # Errors
    /// Weights given as the other sensor's, rates that differ by more than a thousandth, a hop of zero.
    pub fn new(
        name: impl Into<String>,
        accel: &Weights,
        gyro: &Weights,
        hop: usize,
    ) -> Result<Self, PairError> {
        for (weights, wanted) in [(accel, Sensor::Accel), (gyro, Sensor::Gyro)] {
            if weights.sensor() != wanted {
                return Err(PairError::Sensor { found: weights.sensor(), wanted });
            }
        }
        let (accel_hz, gyro_hz) = (accel.card().rate.hz(), gyro.card().rate.hz());
        if (accel_hz / gyro_hz - 1.0).abs() > 1e-3 {
            return Err(PairError::Rates { accel_hz, gyro_hz });
        }
        if hop == 0 {
            return Err(PairError::Hop);
        }
        Ok(Self {
            name: name.into(),
            hop,
            rate: accel.card().rate,
            accel: Channel::new(accel),
            gyro: Channel::new(gyro),
            fed: 0,
            noise: ImuNoise::baseline(),
        })
    }

    /// Sampling rate of the windows the networks were trained on.
    pub fn trained_rate(&self) -> SampleRate {
        self.rate
    }

    /// Windows of `sensor` judged since the last reset, and those outside the trained range.
    pub fn range_count(&self, sensor: Sensor) -> RangeCount {
        match sensor {
            Sensor::Accel => self.accel.count,
            Sensor::Gyro => self.gyro.count,
        }
    }

    /// Whether the network of `sensor` has answered with a deviation on every axis since the last reset; what it has not is a constant.
    pub fn has_answered(&self, sensor: Sensor) -> bool {
        let channel = if sensor == Sensor::Accel { &self.accel } else { &self.gyro };
        channel.answered == [true; 3]
    }

    /// How far off the network of `sensor` takes its last answer to be, axis by axis: the deviation of that answer's logarithm, .1 for 10 %. None
    /// of a network that does not say it, and before its first full window. It knows windows like those of its training alone: outside
    /// ([`range_count`](Self::range_count)) it is no more to be trusted than the answer.
    pub fn spread(&self, sensor: Sensor) -> Option<[f64; 3]> {
        match sensor {
            Sensor::Accel => self.accel.spread,
            Sensor::Gyro => self.gyro.spread,
        }
    }
}

impl Channel {
    fn new(weights: &Weights) -> Self {
        let (window, range) = (weights.config().window, weights.card().range);
        Self {
            sensor: weights.sensor(),
            predictor: Predictor::new(weights),
            range,
            quietest: range.and_then(|range| range.quietest).and_then(|_| Quietest::new(window)),
            window,
            past: std::array::from_fn(|_| vec![0.0; 2 * window]),
            windows: vec![0.0; 3 * window],
            count: RangeCount::default(),
            answered: [false; 3],
            spread: None,
        }
    }

    /// Keeps sample number `index` (from 0).
    fn keep(&mut self, sample: &ImuSample, index: u64) {
        let at = (index % self.window as u64) as usize;
        for (past, value) in self.past.iter_mut().zip(sample.of(self.sensor)) {
            past[at] = value as f32;
            past[at + self.window] = value as f32;
        }
    }

    /// The deviations by the last full window, which ends with sample number `index`; none before the first.
    fn judge(&mut self, index: u64) -> Option<[f64; 3]> {
        let window = self.window;
        if index + 1 < window as u64 {
            return None;
        }
        let from = ((index + 1) % window as u64) as usize;
        for (to, past) in self.windows.chunks_exact_mut(window).zip(&self.past) {
            to.copy_from_slice(&past[from..from + window]);
        }
        let mut sigma = [0.0f32; 3];
        if self.predictor.says_spread() {
            let mut spread = [0.0f32; 3];
            self.predictor.predict_with_spread(&self.windows, &mut sigma, &mut spread);
            self.spread = Some(spread.map(f64::from));
        } else {
            self.predictor.predict(&self.windows, &mut sigma);
        }
        for ((axis, sigma), answered) in self.windows.chunks_exact(window).zip(sigma).zip(&mut self.answered)
        {
            self.count.windows += 1;
            let quietest = self.quietest.as_ref();
            let outside = self.range.is_some_and(|range| range.is_outside(axis, f64::from(sigma), quietest));
            // A network that answers no deviation was asked what it does not know.
            self.count.outside += u64::from(outside || !sigma.is_finite());
            *answered |= sigma.is_finite();
        }
        // NaN stays NaN: a sample beyond single precision must not pass for one without noise.
        Some(sigma.map(|s| if s < 0.0 { 0.0 } else { f64::from(s) }))
    }

    fn reset(&mut self) {
        self.past.iter_mut().for_each(|p| p.fill(0.0));
        self.count = RangeCount::default();
        self.answered = [false; 3];
        self.spread = None;
    }
}

impl NoiseModel for DualProNet {
    fn name(&self) -> &str {
        &self.name
    }

    fn feed(&mut self, sample: &ImuSample) -> ImuNoise {
        let index = self.fed;
        self.fed += 1;
        self.accel.keep(sample, index);
        self.gyro.keep(sample, index);
        // Each network is asked at its first full window, and every `hop` samples from there.
        let due = |channel: &Channel| {
            (index + 1).checked_sub(channel.window as u64).is_some_and(|d| d % self.hop as u64 == 0)
        };
        if due(&self.accel)
            && let Some(sigma) = self.accel.judge(index)
        {
            for (noise, s) in self.noise.accel.iter_mut().zip(sigma) {
                // What is no deviation (a sample beyond single precision) leaves the last one in force.
                *noise = AccelSampleStd::new(s).unwrap_or(*noise);
            }
        }
        if due(&self.gyro)
            && let Some(sigma) = self.gyro.judge(index)
        {
            for (noise, s) in self.noise.gyro.iter_mut().zip(sigma) {
                *noise = GyroSampleStd::new(s).unwrap_or(*noise);
            }
        }
        self.noise
    }

    fn reset(&mut self) {
        self.accel.reset();
        self.gyro.reset();
        self.fed = 0;
        self.noise = ImuNoise::baseline();
    }
}

#[cfg(all(test, feature = "train"))]
mod tests {
    use super::*;
    use crate::config::ProNetConfig;
    use crate::init::initial_parameters;
    use crate::weights::Card;
    use dpn_core::random::Stream;
    use dpn_core::time::Stamp;
    use rand::Rng;

    fn weights(sensor: Sensor, range: Option<TrainedRange>) -> Weights {
        let config = ProNetConfig { window: 40, ..ProNetConfig::for_sensor(sensor) };
        let flat = initial_parameters(&config, &Stream::new(1).named(sensor.name()));
        Weights::new(&config, flat, Card { range, ..Card::default() })
    }

    fn samples(count: usize) -> Vec<ImuSample> {
        let mut rng = Stream::new(2).rng();
        let mut axes = |about: f64| [0; 3].map(|_| about + 0.1 * (rng.random::<f64>() - 0.5));
        (0..count)
            .map(|i| ImuSample {
                t: Stamp::from_ns(i as i64 * 5_000_000),
                gyro: axes(0.0),
                accel: axes(9.81),
            })
            .collect()
    }

    fn pair() -> DualProNet {
        DualProNet::new("pronet", &weights(Sensor::Accel, None), &weights(Sensor::Gyro, None), 10).unwrap()
    }

    #[test]
    fn the_baseline_holds_until_the_first_full_window_and_answers_change_every_hop() {
        let mut model = pair();
        let track: Vec<ImuNoise> = samples(100).iter().map(|s| model.feed(s)).collect();
        assert!(track[..39].iter().all(|n| *n == ImuNoise::baseline()));
        let changes: Vec<usize> = (1..100).filter(|i| track[*i] != track[i - 1]).collect();
        assert_eq!(changes, [39, 49, 59, 69, 79, 89, 99]);
    }

    #[test]
    fn the_answer_is_the_networks_on_the_last_window_of_that_axis() {
        let samples = samples(77);
        let mut model = pair();
        let mut noise = ImuNoise::baseline();
        for s in &samples {
            noise = model.feed(s);
        }
        // Sample 69 was the last at which the networks were asked: 40 + 3 * 10 samples.
        for (sensor, got) in
            [(Sensor::Accel, noise.of(Sensor::Accel)), (Sensor::Gyro, noise.of(Sensor::Gyro))]
        {
            let mut predictor = Predictor::new(&weights(sensor, None));
            for (axis, got) in got.into_iter().enumerate() {
                let window: Vec<f32> = samples[30..70].iter().map(|s| s.of(sensor)[axis] as f32).collect();
                let mut sigma = [0.0];
                predictor.predict(&window, &mut sigma);
                assert_eq!(got, f64::from(sigma[0]), "{sensor} {axis}");
            }
        }
    }

    #[test]
    fn a_sample_beyond_single_precision_leaves_the_last_noise_in_force_not_zero() {
        let (mut model, mut samples) = (pair(), samples(60));
        samples[55].accel = [1e300; 3];
        let track: Vec<ImuNoise> = samples.iter().map(|s| model.feed(s)).collect();
        assert_eq!(track[59].accel, track[58].accel);
        assert_ne!(track[59].gyro, track[58].gyro);
        // Windows of it are counted as outside, whatever range was trained on.
        assert_eq!(model.range_count(Sensor::Accel).outside, 3);
        assert_eq!(model.range_count(Sensor::Gyro).outside, 0);
    }

    #[test]
    fn weights_that_overflow_answer_nothing_and_that_is_counted_and_not_known() {
        let huge = |sensor| {
            let weights = weights(sensor, None);
            Weights::new(weights.config(), vec![1e38; weights.parameters().len()], Card::default())
        };
        let pair = DualProNet::new("p", &huge(Sensor::Accel), &huge(Sensor::Gyro), 10).unwrap();
        let mut stream = crate::stream::SampleStream::new(pair);
        samples(80).iter().for_each(|sample| stream.feed(*sample).unwrap());
        let sigma = stream.sigma();
        assert!(!sigma.known && sigma.out_of_range == [true; 2] && sigma.noise == ImuNoise::baseline());
    }

    #[test]
    fn samples_beyond_single_precision_are_never_known() {
        let mut stream = crate::stream::SampleStream::new(pair());
        for sample in samples(80) {
            stream.feed(ImuSample { accel: [1e308; 3], gyro: [-1e308; 3], ..sample }).unwrap();
        }
        assert!(!stream.sigma().known && stream.sigma().out_of_range == [true; 2]);
    }

    #[test]
    fn a_reset_model_repeats_itself_and_a_cut_recording_gives_the_same_bits() {
        let mut model = pair();
        let samples = samples(120);
        let first: Vec<ImuNoise> = samples.iter().map(|s| model.feed(s)).collect();
        model.reset();
        let cut: Vec<ImuNoise> = samples[..83].iter().map(|s| model.feed(s)).collect();
        assert_eq!(cut, first[..83]);
    }

    #[test]
    fn windows_outside_the_trained_range_are_counted() {
        let narrow = TrainedRange { roughness: [0.0, 1e-6], spread: [0.0, 1.0], quietest: None };
        let accel = weights(Sensor::Accel, Some(narrow));
        let mut model = DualProNet::new("p", &accel, &weights(Sensor::Gyro, None), 10).unwrap();
        for s in samples(60) {
            model.feed(&s);
        }
        assert_eq!(model.range_count(Sensor::Accel), RangeCount { windows: 9, outside: 9 });
        assert_eq!(model.range_count(Sensor::Gyro), RangeCount { windows: 9, outside: 0 });
        let accel = model.range_count(Sensor::Accel);
        assert!(accel.windows > 0 && accel.outside == accel.windows);
    }

    #[test]
    fn a_network_that_says_how_sure_it_is_is_heard_and_one_that_does_not_says_nothing() {
        let config = ProNetConfig {
            window: 40,
            head: crate::config::Head::LogSigmaAndSpread,
            ..ProNetConfig::for_sensor(Sensor::Accel)
        };
        let flat = initial_parameters(&config, &Stream::new(5));
        let accel = Weights::new(&config, flat, Card::default());
        let mut model = DualProNet::new("p", &accel, &weights(Sensor::Gyro, None), 10).unwrap();
        let samples = samples(70);
        for sample in &samples[..39] {
            model.feed(sample);
        }
        assert_eq!(model.spread(Sensor::Accel), None);
        let noise = samples[39..].iter().map(|sample| model.feed(sample)).last().unwrap();
        let (mut sigma, mut spread) = ([0.0], [0.0]);
        let window: Vec<f32> = samples[30..].iter().map(|s| s.accel[2] as f32).collect();
        Predictor::new(&accel).predict_with_spread(&window, &mut sigma, &mut spread);
        assert_eq!(noise.of(Sensor::Accel)[2], f64::from(sigma[0]));
        assert_eq!(model.spread(Sensor::Accel).unwrap()[2], f64::from(spread[0]));
        assert_eq!(model.spread(Sensor::Gyro), None);
        model.reset();
        assert_eq!(model.spread(Sensor::Accel), None);
    }

    #[test]
    fn swapped_weights_are_refused() {
        let (a, g) = (weights(Sensor::Accel, None), weights(Sensor::Gyro, None));
        let error = DualProNet::new("p", &g, &a, 10).unwrap_err();
        assert_eq!(error, PairError::Sensor { found: Sensor::Gyro, wanted: Sensor::Accel });
        assert_eq!(DualProNet::new("p", &a, &g, 0).unwrap_err(), PairError::Hop);
    }
}
