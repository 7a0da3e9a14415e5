//! Both networks beside running samples, with what a program that weighs its measurements by them must know: whether there is an answer yet, whether it is
//! extrapolated, whether samples come at the networks' rate. What C and Python call a stream.

use crate::model::DualProNet;
use dpn_core::estimate::Watch;
use dpn_core::{ImuNoise, ImuSample, NoiseModel, SampleRate, Sensor, Stamp};
use thiserror::Error;

/// The rate is that of so many seconds' samples.
const RATE_OVER_S: f64 = 1.0;

/// A sample that is not taken; it changes nothing.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
pub enum StreamError {
    /// Not later than the last.
    #[error("`t_ns` is {t_ns} after {last_ns}; stamps must increase")]
    NotIncreasing {
        /// Its stamp.
        t_ns: i64,
        /// The last one's.
        last_ns: i64,
    },
    /// A value that is no number.
    #[error("the sample of {t_ns} ns has a value that is not finite")]
    NotFinite {
        /// Its stamp.
        t_ns: i64,
    },
}

/// How noisy the IMU is at the newest sample.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StreamSigma {
    /// Deviations of one sample; VINS-Mono's constants until they are known.
    pub noise: ImuNoise,
    /// Whether both networks have answered with a deviation on every axis: after a full window, unless that was of what no sensor measures.
    pub known: bool,
    /// Whether the last window was unlike all of the training on any axis, accelerometer and gyroscope: its deviations are extrapolated.
    pub out_of_range: [bool; 2],
    /// How far off the networks take themselves to be, accelerometer and gyroscope, axis by axis: the deviation of the logarithm, .1 for 10 %; none of
    /// a network that does not say it, and until it is known.
    pub spread: [Option<[f64; 3]>; 2],
    /// Whether samples come at a rate more than 5 % off the networks'; nothing is resampled.
    pub wrong_rate: bool,
    /// Whether the spectrum of the last half to whole minute says another noise, accelerometer and gyroscope, as behind a low pass
    /// ([`Doubt`](dpn_core::estimate::Doubt)).
    pub contradicted: [bool; 2],
}

/// Running samples looked at one by one: what no network can take, and whether they come at the rate it was trained for.
#[derive(Debug, Clone)]
pub struct Gate {
    trained: SampleRate,
    last: Option<Stamp>,
    /// Where the present count of samples began, and how many came since.
    counted: (Stamp, u32),
    wrong_rate: bool,
}

impl Gate {
    /// Before samples for a network of this rate.
    pub fn new(trained: SampleRate) -> Self {
        Self { trained, last: None, counted: (Stamp::from_ns(0), 0), wrong_rate: false }
    }

    /// Takes the next sample; the stamp of the one before.
    ///
    /// # Errors
    /// One that is not later than the last, or not finite.
    pub fn take(&mut self, sample: &ImuSample) -> Result<Option<Stamp>, StreamError> {
        let (t, t_ns) = (sample.t, sample.t.ns());
        if let Some(last) = self.last.filter(|last| t <= *last) {
            return Err(StreamError::NotIncreasing { t_ns, last_ns: last.ns() });
        }
        if !sample.is_finite() {
            return Err(StreamError::NotFinite { t_ns });
        }
        let before = self.last.replace(t);
        let (from, count) = &mut self.counted;
        if before.is_none() {
            *from = t;
            return Ok(before);
        }
        *count += 1;
        let seconds = t.seconds_since(*from);
        if seconds >= RATE_OVER_S {
            let share = f64::from(*count) / seconds / self.trained.hz();
            self.wrong_rate = (share - 1.0).abs() > DualProNet::RATE_TOLERANCE;
            self.counted = (t, 0);
        }
        Ok(before)
    }

    /// Whether samples come at a rate more than 5 % off the network's.
    pub fn wrong_rate(&self) -> bool {
        self.wrong_rate
    }
}

/// A pair of networks that is fed samples.
#[derive(Debug)]
pub struct SampleStream {
    gate: Gate,
    networks: DualProNet,
    noise: ImuNoise,
    /// Windows judged so far and those out of range, accelerometer and gyroscope.
    judged: [(u64, u64); 2],
    out_of_range: [bool; 2],
    watch: Option<Watch>,
}

impl SampleStream {
    /// Of networks that have seen nothing.
    pub fn new(networks: DualProNet) -> Self {
        let watch = Watch::new(networks.trained_rate());
        Self {
            gate: Gate::new(networks.trained_rate()),
            networks,
            noise: ImuNoise::baseline(),
            judged: [(0, 0); 2],
            out_of_range: [false; 2],
            watch,
        }
    }

    /// Takes the next sample.
    ///
    /// # Errors
    /// One that is not later than the last, or not finite.
    pub fn feed(&mut self, sample: ImuSample) -> Result<(), StreamError> {
        self.gate.take(&sample)?;
        self.noise = self.networks.feed(&sample);
        let known = self.is_known();
        if let Some(watch) = &mut self.watch {
            watch.feed(&sample, known.then_some(&self.noise));
        }
        for (k, sensor) in Sensor::ALL.into_iter().enumerate() {
            let count = self.networks.range_count(sensor);
            let (windows, outside) = self.judged[k];
            if count.windows > windows {
                self.out_of_range[k] = count.outside > outside;
                self.judged[k] = (count.windows, count.outside);
            }
        }
        Ok(())
    }

    /// How noisy the IMU is at the newest sample.
    pub fn sigma(&self) -> StreamSigma {
        StreamSigma {
            noise: self.noise,
            known: self.is_known(),
            out_of_range: self.out_of_range,
            spread: Sensor::ALL.map(|sensor| self.networks.spread(sensor)),
            wrong_rate: self.gate.wrong_rate(),
            contradicted: self
                .watch
                .as_ref()
                .map_or([false; 2], |watch| watch.doubts().map(|doubt| doubt.is_some())),
        }
    }

    fn is_known(&self) -> bool {
        Sensor::ALL.iter().all(|sensor| self.networks.has_answered(*sensor))
    }
}

#[cfg(all(test, feature = "train"))]
mod tests {
    use super::*;
    use crate::config::ProNetConfig;
    use crate::init::initial_parameters;
    use crate::weights::{Card, Weights};
    use dpn_core::random;

    const WINDOW: usize = 40;

    fn stream() -> SampleStream {
        let weights = |sensor| {
            let config = ProNetConfig { window: WINDOW, ..ProNetConfig::for_sensor(sensor) };
            let flat = initial_parameters(&config, &random::Stream::new(1));
            Weights::new(&config, flat, Card::default())
        };
        SampleStream::new(DualProNet::new("p", &weights(Sensor::Accel), &weights(Sensor::Gyro), 10).unwrap())
    }

    fn sample(t_ns: i64) -> ImuSample {
        let value = (t_ns / 5_000_000 % 7) as f64 * 0.01;
        ImuSample { t: Stamp::from_ns(t_ns), gyro: [value; 3], accel: [value, 0.0, 9.81] }
    }

    #[test]
    fn a_refused_sample_changes_nothing_and_the_first_full_window_is_known() {
        let (mut one, mut other) = (stream(), stream());
        for i in 0..WINDOW as i64 {
            assert!(!one.sigma().known && one.sigma().noise == ImuNoise::baseline());
            let good = sample(5_000_000 * i);
            one.feed(good).unwrap();
            other.feed(good).unwrap();
            let nan = ImuSample { gyro: [f64::NAN; 3], ..sample(5_000_000 * i + 1) };
            assert_eq!(other.feed(nan), Err(StreamError::NotFinite { t_ns: 5_000_000 * i + 1 }));
            let again = StreamError::NotIncreasing { t_ns: good.t.ns(), last_ns: good.t.ns() };
            assert_eq!(other.feed(good), Err(again));
        }
        assert!(one.sigma().known && one.sigma().noise != ImuNoise::baseline());
        assert_eq!(one.sigma(), other.sigma());
    }

    #[test]
    fn half_the_rate_is_a_wrong_one_for_as_long_as_it_lasts() {
        let (mut stream, mut t_ns) = (stream(), 0);
        for (step_ns, wrong) in
            [(10_000_000, true), (5_000_000, false), (5_300_000, true), (5_100_000, false)]
        {
            // A second of the one may hold samples of the other: two of them.
            for _ in 0..2 * 1_000_000_000 / step_ns + 2 {
                t_ns += step_ns;
                stream.feed(sample(t_ns)).unwrap();
            }
            assert_eq!(stream.sigma().wrong_rate, wrong, "a sample each {step_ns} ns");
        }
    }
}
