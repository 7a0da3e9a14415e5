//! Samples in as they come, deviations out.

use crate::error::{Error, parsed, raise};
use crate::network::Network;
use dpn_core::{ImuNoise, ImuSample, NoiseModel, SampleRate, Sensor, Stamp};
use dpn_noise::{Feed, Judged};
use dpn_probe::log_noise::Plan;
use dpn_pronet::{DualProNet, SampleStream, StreamError};
use pyo3::prelude::*;
use std::sync::{Mutex, PoisonError};

/// Accelerometer, gyroscope; whether they are known, out of range by sensor, at a wrong rate, and contradicted by the spectrum by sensor.
type Answer = ([f64; 3], [f64; 3], bool, [bool; 2], bool, [bool; 2]);

/// Who is asked.
enum Asked {
    /// Two networks at their own rate.
    Networks(Box<SampleStream>),
    Any(Box<AtRate>),
}

/// A model beside running samples.
#[pyclass(module = "dpn._dpn")]
pub(crate) struct Stream {
    asked: Asked,
}

#[pymethods]
impl Stream {
    #[staticmethod]
    fn of_networks(accel: &Network, gyro: &Network, every: usize) -> PyResult<Self> {
        let pair = DualProNet::new("python", &accel.inner.weights, &gyro.inner.weights, every);
        let pair = pair.map_err(|e| Error::new_err(format!("accel, gyro: {e}")))?;
        Ok(Self { asked: Asked::Networks(Box::new(SampleStream::new(pair))) })
    }

    #[staticmethod]
    fn at_rate(model: Option<&str>, rate_hz: f64, every: usize) -> PyResult<Self> {
        Ok(Self { asked: Asked::Any(Box::new(AtRate::new(model, rate_hz, every)?)) })
    }

    fn feed(&mut self, t_ns: i64, gyro: [f64; 3], accel: [f64; 3]) -> PyResult<()> {
        let sample = ImuSample { t: Stamp::from_ns(t_ns), gyro, accel };
        match &mut self.asked {
            Asked::Networks(stream) => stream.feed(sample),
            Asked::Any(stream) => stream.feed(sample),
        }
        .map_err(|e| raise(&e))
    }

    fn sigma(&self) -> Answer {
        let found = match &self.asked {
            Asked::Networks(stream) => stream.sigma(),
            Asked::Any(stream) => return stream.sigma(),
        };
        let of = |sensor| found.noise.of(sensor);
        (
            of(Sensor::Accel),
            of(Sensor::Gyro),
            found.known,
            found.out_of_range,
            found.wrong_rate,
            found.contradicted,
        )
    }
}

/// Any model beside samples of any rate, as `dpn noise --follow` asks it.
struct AtRate {
    feed: Mutex<Feed>,
    rate: SampleRate,
    /// Samples until there is a full window, and those that came.
    unknown: u64,
    came: u64,
    last: Option<Stamp>,
    /// Running mean of the steps \[s\].
    step_s: f64,
    noise: ImuNoise,
    judged: Judged,
    out_of_range: [bool; 2],
    contradicted: [bool; 2],
}

impl AtRate {
    fn new(model: Option<&str>, rate_hz: f64, every: usize) -> PyResult<Self> {
        let rate = SampleRate::from_hz(rate_hz).expect("Python asks for more than zero");
        let networks = dpn_program::shipped().map_err(|e| raise(&e))?;
        let plan = match parsed("model", model)? {
            Some(spec) => Plan::new(&spec, rate, every, &networks),
            None => Plan::fitting(rate, every, &networks).map(|(plan, _)| plan),
        };
        let plan = plan.map_err(|e| raise(&e))?;
        let feed = plan.feed().map_err(|e| raise(&e))?;
        Ok(Self {
            feed: Mutex::new(feed.watched(plan.noise.spec(), rate)),
            rate,
            unknown: (plan.unknown_s() * rate.hz()).ceil() as u64,
            came: 0,
            last: None,
            step_s: rate.period(),
            noise: ImuNoise::baseline(),
            judged: Judged::default(),
            out_of_range: [false; 2],
            contradicted: [false; 2],
        })
    }

    fn feed(&mut self, sample: ImuSample) -> Result<(), StreamError> {
        let t = sample.t;
        if let Some(last) = self.last {
            if t <= last {
                return Err(StreamError::NotIncreasing { t_ns: t.ns(), last_ns: last.ns() });
            }
            self.step_s += 0.02 * (t.seconds_since(last) - self.step_s);
        }
        self.last = Some(t);
        self.came += 1;
        let feed = self.feed.get_mut().unwrap_or_else(PoisonError::into_inner);
        self.noise = feed.feed(&sample);
        let judged = feed.judged();
        let new = judged.since(&self.judged);
        for (out, sensor) in self.out_of_range.iter_mut().zip(Sensor::ALL) {
            let count = new.of(sensor);
            *out = if count.windows > 0 { count.outside > 0 } else { *out };
        }
        self.judged = judged;
        self.contradicted = feed.doubts().map(|doubt| doubt.is_some());
        Ok(())
    }

    fn sigma(&self) -> Answer {
        let of = |sensor| self.noise.of(sensor);
        let share = self.step_s * self.rate.hz();
        let wrong_rate = (share - 1.0).abs() > DualProNet::RATE_TOLERANCE;
        let known = self.came >= self.unknown.max(1);
        (of(Sensor::Accel), of(Sensor::Gyro), known, self.out_of_range, wrong_rate, self.contradicted)
    }
}
