//! From a spec to something that is fed samples one by one.

use super::{Judged, LogNoiseError};
use dpn_core::estimate::{NoiseSpec, Schedule, raised_to_floor};
use dpn_core::{ImuNoise, ImuSample, NoiseModel, SampleRate, Sensor};
use dpn_pronet::DualProNet;
use dpn_pronet::network::{Network, select};
use dpn_pronet::range::TrainedRange;

/// Largest share by which a thinned log's rate may differ from that of the networks' training.
const RATE_TOLERANCE: f64 = 0.05;
/// Window of a simple estimator \[s\].
const WINDOW_S: f64 = 1.0;
/// The same in samples, at most: the deviation of so many is sure to half a per cent.
const WINDOW_MOST: usize = 20_000;
/// A window longer than so many samples is asked for that share of its length apart, or time would grow with the rate squared.
const OFTEN: (usize, usize) = (1000, 200);
/// No IMU is faster: whoever is has stamps in another unit than was thought \[Hz\].
const FASTEST_HZ: f64 = 1e5;

/// What is asked, how often, and of which samples.
#[derive(Debug, Clone)]
pub struct Plan<'a> {
    spec: NoiseSpec,
    networks: Option<(&'a Network, &'a Network)>,
    /// Every how many samples the networks see one.
    thin: usize,
    every: usize,
    rate: SampleRate,
}

impl<'a> Plan<'a> {
    /// A plan for logs of `rate` with an answer `every` so many samples, at least 1.
    ///
    /// Networks see a log of twice their rate as every second sample, and so on: thinning leaves the deviation of a sample as it is, as
    /// long as its noise is white.
    ///
    /// # Errors
    /// A spec that is not causal (`file`, `oracle`, the controls), networks that are not there, a rate that is no multiple of theirs or no IMU's.
    pub fn new(
        spec: &NoiseSpec,
        rate: SampleRate,
        every: usize,
        networks: &'a [Network],
    ) -> Result<Self, LogNoiseError> {
        if rate.hz() > FASTEST_HZ {
            return Err(LogNoiseError::TooFast { found_hz: rate.hz() });
        }
        let mut plan = Self { spec: spec.clone(), networks: None, thin: 1, every: every.max(1), rate };
        match spec {
            NoiseSpec::Sensors(_) => {}
            NoiseSpec::DualProNet { accel, gyro } => {
                let text = spec.to_string();
                let of = |sensor, tag| {
                    select(networks, sensor, tag)
                        .map_err(|source| LogNoiseError::NoNetwork { spec: text.clone(), source })
                };
                let pair = (of(Sensor::Accel, accel)?, of(Sensor::Gyro, gyro)?);
                let trained = pair.0.weights.card().rate.hz();
                plan.thin = (rate.hz() / trained).round().max(1.0) as usize;
                if (rate.hz() / (trained * plan.thin as f64) - 1.0).abs() > RATE_TOLERANCE {
                    return Err(LogNoiseError::Rate { spec: text, found_hz: rate.hz(), trained_hz: trained });
                }
                plan.networks = Some(pair);
            }
            _ => return Err(LogNoiseError::NotCausal { spec: spec.to_string() }),
        }
        // What cannot be made should be said now, not at the first sample.
        plan.feed()?;
        Ok(plan)
    }

    /// The spec.
    pub fn spec(&self) -> &NoiseSpec {
        &self.spec
    }

    /// Samples from one answer to the next.
    pub fn every(&self) -> usize {
        self.every
    }

    /// Every how many samples the networks see one; 1 for all else.
    pub fn thin(&self) -> usize {
        self.thin
    }

    /// What a sensor's network was trained on, where that is known.
    pub fn trained_on(&self, sensor: Sensor) -> Option<TrainedRange> {
        let (accel, gyro) = self.networks?;
        let of = match sensor {
            Sensor::Accel => accel,
            Sensor::Gyro => gyro,
        };
        of.weights.card().range
    }

    /// Samples of the networks from one question to the next.
    pub(super) fn hop(&self) -> usize {
        (self.every / self.thin).max(1)
    }

    /// Seconds until there is a full window: the answers before it are constants.
    pub fn unknown_s(&self) -> f64 {
        match (&self.spec, self.memory()) {
            (_, Some(memory)) => memory as f64 * self.rate.period(),
            (spec, None) if spec.is_constant() => 0.0,
            (_, None) if self.window() == (self.rate.hz() * WINDOW_S).round() as usize => WINDOW_S,
            (_, None) => self.window() as f64 * self.rate.period(),
        }
    }

    /// Samples in the window of a simple estimator.
    fn window(&self) -> usize {
        ((self.rate.hz() * WINDOW_S).round() as usize).clamp(8, WINDOW_MOST)
    }

    /// The longest window of its networks, in the log's samples; none for all else, which may remember for ever.
    pub(super) fn memory(&self) -> Option<usize> {
        let (accel, gyro) = self.networks?;
        let window = accel.weights.config().window.max(gyro.weights.config().window);
        Some(window * self.thin)
    }

    /// A fresh feed.
    ///
    /// # Errors
    /// Parameters out of range; two networks that are no pair.
    pub fn feed(&self) -> Result<Feed, LogNoiseError> {
        let model = match (&self.spec, self.networks) {
            (NoiseSpec::Sensors(pair), _) => {
                let window = self.window();
                let hop = if window > OFTEN.0 { self.every.max(window / OFTEN.1) } else { self.every };
                Model::Simple(pair.model(Schedule { window, hop, rate: self.rate })?)
            }
            (_, Some((accel, gyro))) => Model::Networks(Box::new(DualProNet::new(
                self.spec.to_string(),
                &accel.weights,
                &gyro.weights,
                self.hop(),
            )?)),
            (other, None) => return Err(LogNoiseError::NotCausal { spec: other.to_string() }),
        };
        Ok(Feed { model, thin: self.thin, index: 0, noise: ImuNoise::baseline() })
    }
}

enum Model {
    Simple(Box<dyn NoiseModel>),
    Networks(Box<DualProNet>),
}

/// Takes a log's samples one by one and says the noise in force at each. Nothing it says depends on a later sample.
pub struct Feed {
    model: Model,
    thin: usize,
    index: usize,
    noise: ImuNoise,
}

impl std::fmt::Debug for Feed {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Feed").field("thin", &self.thin).field("index", &self.index).finish_non_exhaustive()
    }
}

impl Feed {
    /// Takes the next sample.
    pub fn feed(&mut self, sample: &ImuSample) -> ImuNoise {
        let is_seen = self.index.is_multiple_of(self.thin);
        self.index += 1;
        match &mut self.model {
            Model::Simple(model) => self.noise = model.feed(sample),
            Model::Networks(model) if is_seen => self.noise = raised_to_floor(&model.feed(sample)),
            Model::Networks(_) => {}
        }
        self.noise
    }

    /// Windows judged so far, and those unlike every window of the training.
    pub fn judged(&self) -> Judged {
        match &self.model {
            Model::Simple(_) => Judged::default(),
            Model::Networks(model) => Judged {
                accel: model.range_count(Sensor::Accel).into(),
                gyro: model.range_count(Sensor::Gyro).into(),
            },
        }
    }
}
