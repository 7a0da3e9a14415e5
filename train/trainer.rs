//! The training loop: draw, forward, backward, update; validate; keep the best.
//!
//! Deterministic: weights are a function of configuration and recordings. Examples are drawn in parallel, each from a
//! stream of its own; the network's kernels sum in a fixed order; the optimiser's state is [`State`]. A run that goes on
//! from a saved [`State`] therefore ends in the same bits as one that never stopped.

use crate::calibration::Calibration;
#[cfg(feature = "wgpu")]
use crate::card::OnCard;
use crate::config::TrainConfig;
use crate::corpus::{Corpus, CorpusError};
use crate::device::Device;
use crate::examples::Examples;
use crate::flight::FlightNoise;
use crate::loss::loss;
use crate::schedule::learning_rate;
use crate::split::Side;
use crate::state::{EpochRecord, State};
use crate::windows::{Stretch, WindowSet};
use dpn_core::config::ConfigFaults;
use dpn_core::random::Stream;
use dpn_core::signal::FilterError;
use dpn_pronet::adam::{AdamConfig, clip_length};
use dpn_pronet::range::TrainedRange;
use dpn_pronet::weights::{Card, Weights};
use dpn_pronet::{Predictor, Trainable, init};
use rand::seq::SliceRandom;
use rayon::prelude::*;
use std::sync::atomic::{AtomicBool, Ordering};
use thiserror::Error;

/// Why training cannot start, or had to stop.
#[derive(Debug, Error)]
pub enum TrainError {
    /// The recordings do not serve.
    #[error(transparent)]
    Corpus(#[from] CorpusError),
    /// The base's filter cannot be.
    #[error(transparent)]
    Filter(#[from] FilterError),
    /// Levels of sequences that are not there.
    #[error(
        "none of the training sequences is in `noise.own`, which names {named}; say their levels, as `dpn truth` finds them"
    )]
    NoLevel {
        /// Who is.
        named: String,
    },
    /// The network cannot be.
    #[error(transparent)]
    Network(#[from] ConfigFaults),
    /// No window to learn from, or none to validate on.
    #[error(
        "the training sequences hold {fit} windows to learn from and {validation} to validate on; record longer"
    )]
    NoWindows {
        /// Windows to learn from.
        fit: usize,
        /// Windows to validate on.
        validation: usize,
    },
    /// The loss became infinite or NaN.
    #[error("the loss is {loss} in epoch {epoch}; lower `fit.learning_rate` or set `fit.clip_norm`")]
    Diverged {
        /// Epoch, from 1.
        epoch: u64,
        /// The loss.
        loss: f64,
    },
    /// The card that was to compute.
    #[cfg(feature = "wgpu")]
    #[error(transparent)]
    Gpu(#[from] dpn_gpu::GpuError),
    /// Asked to stop between two epochs or within one.
    #[error("stopped in epoch {epoch}")]
    Stopped {
        /// Epoch that was not finished, from 1.
        epoch: u64,
    },
}

/// A run: what it learns from and how.
pub struct Trainer {
    config: TrainConfig,
    fit: WindowSet,
    validation: Examples,
    truth: Vec<f64>,
    stream: Stream,
    learner: Learner,
}

/// Where steps are taken.
enum Learner {
    Cpu(Trainable),
    #[cfg(feature = "wgpu")]
    Gpu(OnCard),
}

impl Trainer {
    /// Cuts windows and draws the validation examples.
    ///
    /// # Errors
    /// Recordings, filter or network that do not serve; no windows.
    ///
    /// # Panics
    /// When `corpus` is of another rate than the configuration.
    pub fn new(config: &TrainConfig, corpus: &Corpus, device: &Device) -> Result<Self, TrainError> {
        assert_eq!(config.rate_hz, corpus.rate, "the corpus is made at the configuration's rate");
        let config = config.resolved();
        let mut recordings = corpus.require(Side::Train)?;
        if let Some(own) = &config.noise.own {
            recordings.retain(|(name, _)| own.contains_key(*name));
            if recordings.is_empty() {
                let named = own.keys().map(String::as_str).collect::<Vec<_>>().join(", ");
                return Err(TrainError::NoLevel { named });
            }
        }
        let (base, window) = (config.base.base(), config.network.window);
        let cut = |stretch| WindowSet::cut(&recordings, config.sensor(), base, stretch, window);
        let flight = match &config.noise.own {
            None => None,
            Some(own) => {
                let whole = cut(Stretch::Whole)?;
                let windows =
                    (0..whole.len()).map(|index| (whole.sequence_number(index), whole.raw(index, 0)));
                Some(FlightNoise::of(whole.sequences(), windows, own, config.rate_hz))
            }
        };
        let fit = cut(Stretch::Fit)?.with_flight_noise(flight.clone());
        let held_out = cut(Stretch::Validation)?.with_flight_noise(flight);
        if fit.is_empty() || held_out.is_empty() {
            return Err(TrainError::NoWindows { fit: fit.len(), validation: held_out.len() });
        }
        let stream = Stream::new(config.seed).named("train").named(config.sensor().name());
        // Validation examples are the same for every training seed, so that seeds are compared on one scale.
        let judge = Stream::new(0).named("validation").named(config.sensor().name());
        let mut validation = Examples::draw(&held_out, &config.levels(), &judge);
        validation.disturb(&config.draw_rule(), &judge.named("vibration"));
        let truth = validation.truth(config.noise.label);
        let network = |on| Trainable::new(&config.network, &on);
        let learner = match device {
            Device::Cpu => Learner::Cpu(network(dpn_pronet::Device::Cpu)?),
            #[cfg(feature = "ndarray")]
            Device::Ndarray => Learner::Cpu(network(dpn_pronet::Device::ndarray())?),
            #[cfg(feature = "wgpu")]
            Device::Gpu(gpu) => {
                let here = network(dpn_pronet::Device::Cpu)?;
                let weights = init::initial_parameters(&config.network, &stream.named("weights"));
                Learner::Gpu(OnCard::new(gpu, here, &config, adam(&config), &fit, &weights)?)
            }
        };
        Ok(Self { config, fit, validation, truth, stream, learner })
    }

    /// The configuration with every default written out.
    pub fn config(&self) -> &TrainConfig {
        &self.config
    }

    /// Sequences that windows are cut from.
    pub fn sequences(&self) -> &[String] {
        self.fit.sequences()
    }

    /// Windows to learn from and windows to validate on.
    pub fn windows(&self) -> (usize, usize) {
        (self.fit.len(), self.validation.len() / self.config.levels().steps.max(1))
    }

    /// The state before the first epoch.
    pub fn start(&self) -> State {
        let weights = init::initial_parameters(&self.config.network, &self.stream.named("weights"));
        State::new(weights, adam(&self.config))
    }

    /// Updates in one epoch.
    pub fn steps_per_epoch(&self) -> u64 {
        (self.fit.len() as u64 * self.config.fit.draws_per_window).div_ceil(self.config.fit.batch as u64)
    }

    /// Goes through one epoch. `stop` is looked at before every update, on a card before every lot of them; `each_step` hears then the steps done in the epoch
    /// and the mean loss so far. On an error `state` is as before the epoch.
    ///
    /// # Errors
    /// Divergence; a request to stop; a card that fails.
    pub fn epoch(
        &self,
        state: &mut State,
        stop: &AtomicBool,
        each_step: &mut dyn FnMut(u64, f64),
    ) -> Result<EpochRecord, TrainError> {
        let epoch = state.epochs_done();
        let mut next = state.clone();
        let order = self.order(epoch);
        let batch = self.config.fit.batch;
        let (mut loss_sum, mut seen, mut done) = (0.0, 0, 0);
        for lot in order.chunks(batch * self.batches()) {
            if stop.load(Ordering::Relaxed) {
                return Err(TrainError::Stopped { epoch: epoch + 1 });
            }
            let losses = self.advance(epoch, lot, &mut next)?;
            for (batch, loss) in lot.chunks(batch).zip(losses) {
                if !loss.is_finite() {
                    // Or is it the card?
                    #[cfg(feature = "wgpu")]
                    if let Learner::Gpu(card) = &self.learner {
                        card.try_out(&self.config, &self.fit, &state.weights)?;
                    }
                    return Err(TrainError::Diverged { epoch: epoch + 1, loss });
                }
                loss_sum += loss * batch.len() as f64;
                seen += batch.len();
                done += 1;
            }
            each_step(done, loss_sum / seen as f64);
        }
        let rate = self.rate(next.adam.steps() - 1);
        let epoch = epoch + 1;
        let fit = &self.config.fit;
        let validate = epoch.is_multiple_of(fit.validate_every) || epoch == fit.epochs;
        let (validation_rmse, calibration) =
            validate.then(|| self.judge(&next.averaged)).transpose()?.unzip();
        if let Some(rmse) = validation_rmse.filter(|rmse| rmse.is_finite()) {
            next.keep_if_best(epoch, rmse);
        }
        let loss = loss_sum / order.len() as f64;
        let record = EpochRecord {
            epoch,
            loss,
            validation_rmse,
            learning_rate: rate,
            calibration: calibration.flatten(),
        };
        next.history.push(record);
        *state = next;
        Ok(record)
    }

    /// Weights of the best validated epoch with what is to be known about them; the averaged ones where none was
    /// validated.
    pub fn weights(&self, state: &State, card: Card) -> Weights {
        let weights = state.best.as_ref().map_or(&state.averaged, |best| &best.weights);
        Weights::new(&self.config.network, weights.clone(), card)
    }

    /// The range of the windows learned from, noise included, from one epoch's draw, and of what `weights` answer there.
    pub fn trained_range(&self, weights: &Weights) -> Option<TrainedRange> {
        let order: Vec<(usize, u64)> = (0..self.fit.len()).map(|window| (window, 0)).collect();
        let (windows, _) = self.draw(0, &order);
        let samples: Vec<f64> = windows.iter().map(|v| f64::from(*v)).collect();
        let windows = || windows.chunks_exact(self.fit.window());
        Some(TrainedRange::spanning(windows())?.with_answers(windows(), &predict(weights, &samples)))
    }

    /// RMSE of `weights` on the validation examples \[unit of the sensor\], and whether they are as far off as they say; none of a network that does
    /// not say it.
    ///
    /// # Errors
    /// A card that fails.
    pub fn judge(&self, weights: &[f32]) -> Result<(f64, Option<Calibration>), TrainError> {
        let (sigma, spread) = match &self.learner {
            Learner::Cpu(_) => {
                let weights = Weights::new(&self.config.network, weights.to_vec(), Card::default());
                predict_with_spread(&weights, &self.validation.samples)
            }
            #[cfg(feature = "wgpu")]
            Learner::Gpu(card) => {
                let windows = self.validation.samples.iter().map(|v| *v as f32).collect();
                let answers = card.answers(weights, windows)?;
                if answers.iter().any(|answer| !answer.is_finite()) {
                    card.try_out(&self.config, &self.fit, weights)?;
                }
                let outputs = self.config.network.head.outputs();
                let column =
                    |at: usize| answers.iter().skip(at).step_by(outputs).map(|v| f64::from(*v)).collect();
                (column(0), (outputs > 1).then(|| column(1)))
            }
        };
        let square: f64 = sigma.iter().zip(&self.truth).map(|(e, t): (&f64, _)| (e - t).powi(2)).sum();
        let rmse = (square / self.truth.len().max(1) as f64).sqrt();
        Ok((rmse, spread.map(|spread: Vec<f64>| Calibration::of(&sigma, &spread, &self.truth))))
    }

    /// Batches between two looks at whether to stop.
    fn batches(&self) -> usize {
        match &self.learner {
            Learner::Cpu(_) => 1,
            #[cfg(feature = "wgpu")]
            Learner::Gpu(card) => card.batches(self.fit.window()),
        }
    }

    /// Learning rate of the update after `steps` of them.
    fn rate(&self, steps: u64) -> f64 {
        learning_rate(&self.config.fit, steps, self.steps_per_epoch() * self.config.fit.epochs)
    }

    /// Learns from the examples of one epoch that `lot` names, batch by batch; the mean loss of each. A loss that is no number ends what is learned.
    fn advance(&self, epoch: u64, lot: &[(usize, u64)], next: &mut State) -> Result<Vec<f64>, TrainError> {
        match &self.learner {
            Learner::Cpu(network) => {
                let (windows, labels) = self.draw(epoch, lot);
                let (kind, scale) = (self.config.fit.loss, self.config.network.output_scale());
                let (loss, mut gradient) =
                    network.gradient(&next.weights, &windows, |answers| loss(kind, scale, answers, &labels));
                if self.config.fit.clip_norm > 0.0 {
                    clip_length(&mut gradient, self.config.fit.clip_norm);
                }
                let rate = self.rate(next.adam.steps());
                next.adam.step(&mut next.weights, &gradient, rate);
                let keep = self.keep(next.adam.steps()) as f32;
                for (mean, weight) in next.averaged.iter_mut().zip(&next.weights) {
                    *mean = keep * *mean + (1.0 - keep) * weight;
                }
                Ok(vec![loss])
            }
            #[cfg(feature = "wgpu")]
            Learner::Gpu(card) => {
                let stream = self.stream.named("card").index(epoch);
                let step = |before| dpn_gpu::Step {
                    number: before + 1,
                    rate: self.rate(before),
                    keep: self.keep(before + 1),
                };
                let losses = card.steps(next, lot, &stream, || self.draw(epoch, lot), step)?;
                Ok(losses.into_iter().map(f64::from).collect())
            }
        }
    }

    /// What the running mean of the weights keeps of itself at update number `step`. It starts as a plain mean, so that early weights do not linger.
    fn keep(&self, step: u64) -> f64 {
        self.config.fit.ema.min(1.0 - 1.0 / (step as f64).max(1.0))
    }

    /// Windows in the order of one epoch, each with the number of its draw.
    fn order(&self, epoch: u64) -> Vec<(usize, u64)> {
        let draws = self.config.fit.draws_per_window;
        let mut order: Vec<(usize, u64)> =
            (0..self.fit.len()).flat_map(|window| (0..draws).map(move |draw| (window, draw))).collect();
        order.shuffle(&mut self.stream.named("order").index(epoch).rng());
        order
    }

    /// Noisy windows and their labels.
    fn draw(&self, epoch: u64, batch: &[(usize, u64)]) -> (Vec<f32>, Vec<f32>) {
        let rule = self.config.draw_rule();
        let width = self.fit.window();
        let mut windows = vec![0f32; batch.len() * width];
        let labels = windows
            .par_chunks_exact_mut(width)
            .zip(batch)
            .map(|(row, &(window, draw))| {
                let mut example = vec![0.0; width];
                let stream = self.stream.named("example").index(epoch).index(window as u64).index(draw);
                let label = rule.example_into(&self.fit, window, &stream, &mut example);
                for (to, from) in row.iter_mut().zip(&example) {
                    *to = *from as f32;
                }
                label as f32
            })
            .collect();
        (windows, labels)
    }
}

/// The optimiser's settings.
fn adam(config: &TrainConfig) -> AdamConfig {
    AdamConfig { weight_decay: config.fit.weight_decay, ..AdamConfig::default() }
}

/// Deviations that `weights` give for rows of as many samples as its windows have, in row order.
pub fn predict(weights: &Weights, samples: &[f64]) -> Vec<f64> {
    predict_with_spread(weights, samples).0
}

/// As [`predict`], and the deviations of the answers' logarithms; none of a network that does not say them.
fn predict_with_spread(weights: &Weights, samples: &[f64]) -> (Vec<f64>, Option<Vec<f64>>) {
    let says_spread = Predictor::new(weights).says_spread();
    let width = weights.config().window;
    let rows = samples.par_chunks(ROWS * width).flat_map_iter(|chunk| {
        let windows: Vec<f32> = chunk.iter().map(|v| *v as f32).collect();
        let [mut sigma, mut spread] = [(); 2].map(|()| vec![0f32; windows.len() / width]);
        let mut predictor = Predictor::new(weights);
        if says_spread {
            predictor.predict_with_spread(&windows, &mut sigma, &mut spread);
        } else {
            predictor.predict(&windows, &mut sigma);
        }
        sigma.into_iter().zip(spread).map(|(sigma, spread)| (f64::from(sigma), f64::from(spread)))
    });
    let (sigma, spread) = rows.unzip();
    (sigma, says_spread.then_some(spread))
}

/// Rows a thread asks about at a time.
const ROWS: usize = 256;
