//! From courses to a network: the affine start, then steps of AdamW on windows drawn by their number, with a running mean of the weights.
//!
//! All that a step draws is a function of seed and step, so that a training that goes on from its state ends in the same bits.

use crate::affine::{Fitted, Unknown, fit};
use crate::choice::chosen_speed;
use crate::config::InertialConfig;
use crate::course::Course;
use crate::loss::loss;
use crate::model::{Card, Model, UNIT, axis_of};
use crate::network;
use dpn_core::SampleRate;
use dpn_core::progress::Progress;
use dpn_core::random::Stream;
use dpn_pronet::StoreError;
use dpn_pronet::adam::{Adam, AdamConfig, clip_length};
use dpn_pronet::store::{self, Named};
use nalgebra::{DMatrix, Vector3};
use rand::Rng;
use rand_distr::{Distribution, StandardNormal};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use std::f64::consts::PI;
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};
use thiserror::Error;

/// A gradient is not longer than this.
const LONGEST: f64 = 1.0;
/// Rates of one training differ by no more than this share.
const SAME_RATE: f64 = 0.02;

/// Why nothing is trained.
#[derive(Debug, Error, PartialEq)]
pub enum TrainingError {
    /// Recordings of several rates.
    #[error(
        "{name} has {found:.1} Hz and {first} {wanted:.1} Hz: a network looks at samples, not at seconds; bring them to one rate (dpn convert --rate)"
    )]
    OtherRate {
        /// The recording.
        name: String,
        /// Its rate \[Hz\].
        found: f64,
        /// The first one.
        first: String,
        /// Its rate \[Hz\].
        wanted: f64,
    },
    /// No window fits.
    #[error(
        "no recording has {needed} samples in a row, a window and the past it looks at; give longer ones or a smaller `window`"
    )]
    TooShort {
        /// Samples that are needed.
        needed: usize,
    },
    /// Nothing to fit to.
    #[error("no span of 32 samples has a true turn; give a trajectory of 17 Hz or more")]
    NoSpan,
}

/// Whether what is named has one rate: levels and networks are of samples, not of seconds.
///
/// # Errors
/// The first that has another one than the first.
pub fn same_rate<'a>(all: impl IntoIterator<Item = (&'a str, SampleRate)>) -> Result<(), TrainingError> {
    let mut all = all.into_iter();
    let Some((first, wanted)) = all.next() else { return Ok(()) };
    match all.find(|(_, rate)| (rate.hz() / wanted.hz() - 1.0).abs() > SAME_RATE) {
        None => Ok(()),
        Some((name, found)) => Err(TrainingError::OtherRate {
            name: name.to_owned(),
            found: found.hz(),
            first: first.to_owned(),
            wanted: wanted.hz(),
        }),
    }
}

/// What the file of an unfinished training calls itself.
const FORMAT: &str = "dpn-inertial-checkpoint";

/// A training between two steps.
pub struct Training<'a> {
    courses: &'a [Course],
    affine: Fitted,
    model: Model,
    averaged: Vec<f32>,
    adam: Adam,
    /// Mean losses of the steps so far.
    history: Vec<f64>,
}

/// What stands beside the numbers of an unfinished training.
#[derive(Serialize, Deserialize)]
struct Notes {
    card: Card,
    history: Vec<f64>,
}

impl<'a> Training<'a> {
    /// Fits the affine start, chooses `speed` where it is not given and draws the first weights.
    ///
    /// # Errors
    /// Recordings of several rates, or too short ones.
    pub fn new(config: &InertialConfig, courses: &'a [Course]) -> Result<Self, TrainingError> {
        same_rate(courses.iter().map(|course| (&*course.name, course.rate)))?;
        let needed = config.window + network::PAST;
        if courses.iter().all(|course| course.len() <= needed) {
            return Err(TrainingError::TooShort { needed });
        }
        let all: Vec<&Course> = courses.iter().collect();
        let affine = fit(&all, Unknown::All).ok_or(TrainingError::NoSpan)?;
        let config = &InertialConfig {
            speed: Some(config.speed.unwrap_or_else(|| chosen_speed(&all))),
            ..config.clone()
        };
        let parameters = network::initial(&Stream::new(config.seed).named("inertial"));
        let model = Model::new(config, &affine, courses, parameters);
        let decay = AdamConfig { weight_decay: config.weight_decay, ..AdamConfig::default() };
        let adam = Adam::new(decay, network::count());
        Ok(Self { courses, affine, averaged: model.parameters.clone(), model, adam, history: Vec::new() })
    }

    /// Goes on from what [`Self::to_bytes`] left; `path` is for messages. `None` where that was another training.
    ///
    /// # Errors
    /// A damaged file, or another one.
    pub fn resumed(mut self, bytes: &[u8], path: &Path) -> Result<Option<Self>, StoreError> {
        let (notes, mut tensors): (Notes, _) = store::from_bytes(FORMAT, bytes, path)?;
        if notes.card != self.model.card {
            return Ok(None);
        }
        let mut take = |name: &str| store::take(&mut tensors, name, &[network::count()], path);
        (self.model.parameters, self.averaged) = (take("parameters")?, take("averaged")?);
        let state = [take("mean")?, take("square")?];
        self.adam = Adam::resumed(*self.adam.config(), state, notes.history.len() as u64);
        self.history = notes.history;
        Ok(Some(self))
    }

    /// The training as it stands, in a file's bytes.
    ///
    /// # Errors
    /// None that is known: notes are JSON.
    pub fn to_bytes(&self) -> Result<Vec<u8>, StoreError> {
        let [mean, square] = self.adam.state();
        let all = [
            ("parameters", &self.model.parameters[..]),
            ("averaged", &self.averaged),
            ("mean", mean),
            ("square", square),
        ];
        let named = |(name, numbers): (&str, &[f32])| Named {
            name: name.to_owned(),
            shape: vec![numbers.len()],
            numbers: numbers.to_vec(),
        };
        let notes = Notes { card: self.model.card.clone(), history: self.history.clone() };
        store::to_bytes(FORMAT, &notes, &all.map(named), Path::new("checkpoint"))
    }

    /// How it is trained, with the `speed` that was chosen.
    pub fn config(&self) -> &InertialConfig {
        &self.model.card.config
    }

    /// The affine start.
    pub fn affine(&self) -> &Fitted {
        &self.affine
    }

    /// Mean losses of the steps behind it, in squares of `huber_rad`.
    pub fn history(&self) -> &[f64] {
        &self.history
    }

    /// At most so many steps, until `stop` or the end; whether that was the end.
    pub fn train(&mut self, most: u64, stop: &AtomicBool, progress: &mut dyn Progress) -> bool {
        let config = self.model.card.config.clone();
        let to = config.steps.min(self.history.len() as u64 + most);
        while (self.history.len() as u64) < to && !stop.load(Ordering::Relaxed) {
            let step = self.history.len() as u64;
            let loss = self.step(&config, step);
            self.history.push(loss);
            progress.step(step + 1, &format!("loss {loss:.3e}"));
        }
        self.history.len() as u64 >= config.steps
    }

    /// The network of the mean weights.
    pub fn model(&self) -> Model {
        Model { card: self.model.card.clone(), parameters: self.averaged.clone() }
    }

    fn step(&mut self, config: &InertialConfig, step: u64) -> f64 {
        let stream = Stream::new(config.seed).named("inertial").named("step").index(step);
        let windows: Vec<(f64, Vec<f32>)> = (0..config.batch as u64)
            .into_par_iter()
            .map(|window| self.window(config, &stream.index(window)))
            .collect();
        let share = 1.0 / config.batch as f64;
        let mut gradient = vec![0.0; network::count()];
        for (_, part) in &windows {
            gradient.iter_mut().zip(part).for_each(|(sum, g)| *sum += share as f32 * g);
        }
        clip_length(&mut gradient, LONGEST);
        let rate = config.learning_rate * 0.5 * (1.0 + (PI * step as f64 / config.steps as f64).cos());
        self.adam.step(&mut self.model.parameters, &gradient, rate);
        // Early weights are forgotten sooner than the running mean's own pace would.
        let keep = config.ema.min((1 + step) as f64 / (10 + step) as f64) as f32;
        for (mean, now) in self.averaged.iter_mut().zip(&self.model.parameters) {
            *mean = keep * *mean + (1.0 - keep) * now;
        }
        share * windows.iter().map(|(loss, _)| loss).sum::<f64>()
    }

    /// Loss and gradient of one window that `stream` draws.
    fn window(&self, config: &InertialConfig, stream: &Stream) -> (f64, Vec<f32>) {
        let mut rng = stream.rng();
        let choices = |course: &Course| course.len().saturating_sub(config.window + network::PAST);
        let mut place = rng.random_range(0..self.courses.iter().map(choices).sum());
        let longer = |course: &&Course| {
            let here = place < choices(course);
            place -= if here { 0 } else { choices(course) };
            here
        };
        let course = self.courses.iter().find(longer).expect("the place is within one of them");
        let mut off = |half: f64| [(); 3].map(|()| half * rng.random_range(-1.0..1.0));
        let bias = [off(config.bias[0]), off(config.bias[1])].concat();
        let answers = config.window / network::STRIDE;
        let samples = DMatrix::from_fn(6, network::samples_for(answers), |axis, column| {
            let white: f64 = StandardNormal.sample(&mut rng);
            let value = axis_of(course, place + column, axis) + bias[axis] + config.noise[axis / 3] * white;
            self.model.seen(axis, value)
        });
        let (out, trace) = network::forward(&self.model.parameters, samples);
        let first = place + network::PAST - 1;
        let affine = &self.model.card.affine;
        let gyro_bias = Vector3::from_column_slice(&bias[..3]);
        let rates: Vec<Vector3<f64>> = (0..config.window)
            .map(|i| {
                let correction = out.column(i / network::STRIDE).map(f64::from);
                affine.apply(&(course.middle(first + i) + gyro_bias)) + UNIT * correction.fixed_rows::<3>(0)
            })
            .collect();
        let (loss, by_rate) = loss(course, first, &rates, &config.spans, config.huber_rad);
        let by_answers = DMatrix::from_fn(3, answers, |axis, answer| {
            let held = &by_rate[answer * network::STRIDE..(answer + 1) * network::STRIDE];
            (UNIT * held.iter().map(|by| by[axis]).sum::<f64>()) as f32
        });
        (loss, network::backward(&self.model.parameters, &trace, by_answers))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::course::simulated;
    use dpn_core::progress::Silent;
    use nalgebra::Matrix3;

    #[test]
    fn a_training_that_goes_on_ends_in_the_same_bits_and_lowers_the_loss() {
        let courses = [simulated(12.0, Matrix3::identity() * 1.02, Vector3::new(0.01, 0.0, -0.02), 0.01)];
        let config = InertialConfig {
            window: 512,
            batch: 2,
            steps: 6,
            train: vec!["a".into()],
            ..InertialConfig::default()
        };
        let stop = AtomicBool::new(false);
        let mut whole = Training::new(&config, &courses).unwrap();
        assert!(whole.train(9, &stop, &mut Silent));
        let mut cut = Training::new(&config, &courses).unwrap();
        assert!(!cut.train(3, &stop, &mut Silent));
        let bytes = cut.to_bytes().unwrap();
        let again = Training::new(&config, &courses).unwrap();
        let mut again = again.resumed(&bytes, Path::new("c")).unwrap().unwrap();
        assert!(again.train(9, &stop, &mut Silent));
        let bytes = again.model().to_bytes().unwrap();
        assert_eq!(bytes, whole.model().to_bytes().unwrap());
        assert_eq!(Model::from_bytes(&bytes, Path::new("m")).unwrap(), whole.model());
        let other = InertialConfig { seed: 1, ..config };
        let other = Training::new(&other, &courses).unwrap();
        assert!(other.resumed(&again.to_bytes().unwrap(), Path::new("c")).unwrap().is_none());
    }

    #[test]
    fn recordings_of_two_rates_and_windows_that_do_not_fit_are_refused() {
        let course = simulated(12.0, Matrix3::identity(), Vector3::zeros(), 0.01);
        let slow = Course {
            name: "slow".into(),
            rate: dpn_core::SampleRate::from_hz(100.0).unwrap(),
            ..course.clone()
        };
        let config = InertialConfig::default();
        let refused = |courses: &[Course]| Training::new(&config, courses).err().unwrap().to_string();
        assert!(refused(&[course.clone(), slow]).contains("slow has 100.0 Hz and simulated 200.0 Hz"));
        assert!(refused(&[course]).contains("2559 samples in a row"));
    }
}
