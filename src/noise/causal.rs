//! From a spec to something that is fed samples one by one.

use super::CausalError;
use dpn_core::estimate::{Doubt, NoiseSpec, Schedule, Watch, raised_to_floor};
use dpn_core::signal::{BlockLength, Blocks};
use dpn_core::{ImuNoise, ImuSample, NoiseModel, SampleRate, Sensor};
use dpn_pronet::DualProNet;
use dpn_pronet::model::RangeCount;
use dpn_pronet::network::{Network, select_for};
use dpn_pronet::range::TrainedRange;
use serde::Serialize;

/// A spec that needs the samples so far and nothing else, for samples of one rate: constants, simple estimators, networks.
#[derive(Debug, Clone)]
pub struct Causal<'a> {
    spec: NoiseSpec,
    networks: Option<[&'a Network; 2]>,
    rate: SampleRate,
    block: BlockLength,
}

impl<'a> Causal<'a> {
    /// `spec` for samples of `rate`.
    ///
    /// # Errors
    /// A spec that needs more than the samples so far (`file`, `oracle`, `self`, the controls); networks that are not there; a rate
    /// below theirs.
    pub fn new(spec: &NoiseSpec, rate: SampleRate, networks: &'a [Network]) -> Result<Self, CausalError> {
        let mut causal = Self { spec: spec.clone(), networks: None, rate, block: BlockLength::ONE };
        match spec {
            NoiseSpec::Sensors(_) => {}
            NoiseSpec::DualProNet { accel, gyro } => {
                let pair = pair(spec, [accel, gyro], networks, rate)?;
                let trained = pair[0].weights.card().rate;
                causal.block = BlockLength::of(rate, trained).ok_or_else(|| CausalError::Rate {
                    spec: spec.to_string(),
                    found_hz: rate.hz(),
                    trained_hz: trained.hz(),
                })?;
                causal.networks = Some(pair);
            }
            _ => return Err(CausalError::NotCausal { spec: spec.to_string() }),
        }
        Ok(causal)
    }

    /// The spec.
    pub fn spec(&self) -> &NoiseSpec {
        &self.spec
    }

    /// Rate of the samples.
    pub fn rate(&self) -> SampleRate {
        self.rate
    }

    /// Of how many samples the networks see the mean; 1 for all else.
    pub fn block(&self) -> usize {
        self.block.samples()
    }

    /// How often its networks see a mean, and the rate of their training \[Hz\], where that is another.
    pub fn seen_and_trained_hz(&self) -> Option<[f64; 2]> {
        let [accel, _] = self.networks?;
        let trained = accel.weights.card().rate;
        (self.block != BlockLength::ONE || !self.block.meets(self.rate, trained))
            .then(|| [self.block.blocks_hz(self.rate), trained.hz()])
    }

    /// Rate of its networks' training \[Hz\].
    pub fn trained_hz(&self) -> Option<f64> {
        self.networks.map(|[accel, _]| accel.weights.card().rate.hz())
    }

    /// What a sensor's network was trained on, where that is known.
    pub fn trained_on(&self, sensor: Sensor) -> Option<TrainedRange> {
        self.networks?.into_iter().find(|network| network.sensor() == sensor)?.weights.card().range
    }

    /// The longest window of its networks, in samples that are fed; none for all else, which may remember for ever.
    pub fn memory(&self) -> Option<usize> {
        let windows = self.networks?.map(|network| network.weights.config().window);
        windows.into_iter().max().map(|window| window * self.block())
    }

    /// A model that has seen nothing, asked every `hop` samples that it sees (means of [`block`](Self::block) that are fed); a simple estimator about the
    /// last `window` samples, networks about windows of their own.
    ///
    /// # Errors
    /// Parameters out of range; two networks that are no pair.
    pub fn feed(&self, window: usize, hop: usize) -> Result<Feed, CausalError> {
        let model = match (&self.spec, self.networks) {
            (NoiseSpec::Sensors(pair), _) => {
                Model::Simple(pair.model(Schedule { window, hop, rate: self.rate })?)
            }
            (spec, networks) => {
                let [accel, gyro] = networks.expect("what is neither of sensors nor networks was refused");
                let networks = DualProNet::new(spec.to_string(), &accel.weights, &gyro.weights, hop)?;
                Model::Networks(Box::new(networks))
            }
        };
        let blocks = Blocks::new(self.block);
        let noise = blocks.of_one_sample(&ImuNoise::baseline());
        Ok(Feed { model, blocks, length: self.block, noise, unknown: noise, watch: None })
    }
}

/// The networks of two tags for samples of `rate`, accelerometer first.
fn pair<'a>(
    spec: &NoiseSpec,
    tags: [&String; 2],
    networks: &'a [Network],
    rate: SampleRate,
) -> Result<[&'a Network; 2], CausalError> {
    let of = |sensor, tag| {
        select_for(networks, sensor, tag, rate)
            .map_err(|source| CausalError::NoNetwork { spec: spec.to_string(), source })
    };
    Ok([of(Sensor::Accel, tags[0])?, of(Sensor::Gyro, tags[1])?])
}

enum Model {
    Simple(Box<dyn NoiseModel>),
    Networks(Box<DualProNet>),
}

/// Takes samples one by one and says the noise in force at each. Nothing it says depends on a later sample.
pub struct Feed {
    model: Model,
    blocks: Blocks,
    length: BlockLength,
    noise: ImuNoise,
    /// What is said before anything is known.
    unknown: ImuNoise,
    watch: Option<(Watch, SampleRate)>,
}

impl std::fmt::Debug for Feed {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Feed").field("blocks", &self.blocks).finish_non_exhaustive()
    }
}

impl Feed {
    /// Holds what is said against the spectrum of the last half to whole minute of samples at `rate`, where `spec`, whose feed this is, is an estimate: constants and
    /// what is learned are not.
    #[must_use]
    pub fn watched(self, spec: &NoiseSpec, rate: SampleRate) -> Self {
        let watch = Watch::new(rate).filter(|_| spec.is_estimate());
        Self { watch: watch.map(|watch| (watch, rate)), ..self }
    }

    /// What that spectrum has against what is said, accelerometer and gyroscope; nothing of a feed that is not [watched](Self::watched).
    pub fn doubts(&self) -> [Option<Doubt>; 2] {
        self.watch.as_ref().map_or([None; 2], |(watch, _)| watch.doubts())
    }

    fn say(&mut self, sample: &ImuSample) {
        match &mut self.model {
            Model::Simple(model) => self.noise = model.feed(sample),
            Model::Networks(model) => {
                if let Some(mean) = self.blocks.feed(sample) {
                    self.noise = raised_to_floor(&self.blocks.of_one_sample(&model.feed(&mean)));
                }
            }
        }
    }

    /// Windows judged so far, and those unlike every window of the training.
    pub fn judged(&self) -> Judged {
        match &self.model {
            Model::Simple(_) => Judged::default(),
            Model::Networks(model) => {
                Judged { accel: model.range_count(Sensor::Accel), gyro: model.range_count(Sensor::Gyro) }
            }
        }
    }
}

impl NoiseModel for Feed {
    fn name(&self) -> &str {
        match &self.model {
            Model::Simple(model) => model.name(),
            Model::Networks(model) => model.name(),
        }
    }

    fn feed(&mut self, sample: &ImuSample) -> ImuNoise {
        self.say(sample);
        if let Some((watch, _)) = &mut self.watch {
            watch.feed(sample, (self.noise != self.unknown).then_some(&self.noise));
        }
        self.noise
    }

    fn reset(&mut self) {
        match &mut self.model {
            Model::Simple(model) => model.reset(),
            Model::Networks(model) => model.reset(),
        }
        self.blocks = Blocks::new(self.length);
        self.noise = self.unknown;
        self.watch = self.watch.take().and_then(|(_, rate)| Some((Watch::new(rate)?, rate)));
    }
}

/// Windows of both sensors, an axis each, and how many of them were unlike every window of the training.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize)]
pub struct Judged {
    /// The accelerometer's.
    pub accel: RangeCount,
    /// The gyroscope's.
    pub gyro: RangeCount,
}

impl Judged {
    /// One sensor's.
    pub fn of(&self, sensor: Sensor) -> RangeCount {
        match sensor {
            Sensor::Accel => self.accel,
            Sensor::Gyro => self.gyro,
        }
    }

    /// What came between `before` and this.
    #[must_use]
    pub fn since(&self, before: &Self) -> Self {
        let of = |now: RangeCount, then: RangeCount| RangeCount {
            windows: now.windows - then.windows,
            outside: now.outside - then.outside,
        };
        Self { accel: of(self.accel, before.accel), gyro: of(self.gyro, before.gyro) }
    }

    /// Both together.
    #[must_use]
    pub fn plus(&self, other: &Self) -> Self {
        let of = |a: RangeCount, b: RangeCount| RangeCount {
            windows: a.windows + b.windows,
            outside: a.outside + b.outside,
        };
        Self { accel: of(self.accel, other.accel), gyro: of(self.gyro, other.gyro) }
    }
}
