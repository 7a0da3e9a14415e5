//! What is asked along a log, and how often.

use super::LogNoiseError;
use dpn_core::SampleRate;
use dpn_core::estimate::{FLIGHT_TAG, NoiseSpec};
use dpn_noise::{Causal, CausalError, Feed};
use dpn_pronet::network::Network;

/// Window of a simple estimator \[s\].
const WINDOW_S: f64 = 1.0;
/// The same in samples, at most: the deviation of so many is sure to half a per cent.
const WINDOW_MOST: usize = 20_000;
/// A window longer than so many samples is asked for that share of its length apart, or time would grow with the rate squared.
const OFTEN: (usize, usize) = (1000, 200);
/// No IMU is faster: whoever is has stamps in another unit than was thought \[Hz\].
const FASTEST_HZ: f64 = 1e5;
/// What stands in for the networks where they cannot be asked.
const SIMPLE: &str = "diff2";

/// What is asked, how often, and of which samples.
#[derive(Debug, Clone)]
pub struct Plan<'a> {
    /// The spec, with its networks.
    pub noise: Causal<'a>,
    every: usize,
}

impl<'a> Plan<'a> {
    /// A plan for logs of `rate` with an answer `every` so many samples, at least 1.
    ///
    /// # Errors
    /// As [`Causal::new`] and [`Causal::feed`]; a rate that no IMU has.
    pub fn new(
        spec: &NoiseSpec,
        rate: SampleRate,
        every: usize,
        networks: &'a [Network],
    ) -> Result<Self, LogNoiseError> {
        if rate.hz() > FASTEST_HZ {
            return Err(LogNoiseError::TooFast { found_hz: rate.hz() });
        }
        let plan = Self { noise: Causal::new(spec, rate, networks)?, every: every.max(1) };
        // What cannot be made should be said now, not at the first sample.
        plan.feed()?;
        Ok(plan)
    }

    /// The networks for raw flights, or where there are none of that name the paper's, where the rate is theirs, and a simple estimator where it is not; then a line says so.
    ///
    /// # Errors
    /// As [`Plan::new`], but for a rate that is not theirs.
    pub fn fitting(
        rate: SampleRate,
        every: usize,
        networks: &'a [Network],
    ) -> Result<(Self, Option<String>), LogNoiseError> {
        let of = |spec: &str| Self::new(&spec.parse().expect("a noise spec"), rate, every, networks);
        let flight = networks.iter().any(|network| network.tag() == FLIGHT_TAG);
        match of(&if flight { format!("dualpronet({FLIGHT_TAG})") } else { "dualpronet".to_owned() }) {
            Err(LogNoiseError::Noise(CausalError::Rate { found_hz, trained_hz, .. })) => {
                let note = format!(
                    "the log has {found_hz:.1} Hz and the networks know {trained_hz:.0} Hz and faster: the simple estimator {SIMPLE} is asked instead; \
                     dpn train --rate {found_hz:.0} makes networks of its rate"
                );
                Ok((of(SIMPLE)?, Some(note)))
            }
            other => Ok((other?, None)),
        }
    }

    /// Samples from one answer to the next.
    pub fn every(&self) -> usize {
        self.every
    }

    /// Samples that the model sees from one question to the next.
    pub(super) fn hop(&self) -> usize {
        let window = self.window();
        match self.noise.memory() {
            None if window > OFTEN.0 => self.every.max(window / OFTEN.1),
            _ => (self.every / self.noise.block()).max(1),
        }
    }

    /// Seconds until there is a full window: the answers before it are constants.
    pub fn unknown_s(&self) -> f64 {
        let rate = self.noise.rate();
        match self.noise.memory() {
            Some(memory) => memory as f64 * rate.period(),
            None if self.noise.spec().is_constant() => 0.0,
            None if self.window() == (rate.hz() * WINDOW_S).round() as usize => WINDOW_S,
            None => self.window() as f64 * rate.period(),
        }
    }

    /// Samples in the window of a simple estimator.
    fn window(&self) -> usize {
        ((self.noise.rate().hz() * WINDOW_S).round() as usize).clamp(8, WINDOW_MOST)
    }

    /// A fresh feed.
    ///
    /// # Errors
    /// As [`Causal::feed`].
    pub fn feed(&self) -> Result<Feed, LogNoiseError> {
        Ok(self.noise.feed(self.window(), self.hop())?)
    }
}
