//! One set of windows: who is asked, what is fitted first, which rows come of it.

use super::request::{OpenLoopError, Request};
use super::rows::{Errors, Row};
use dpn_core::Sensor;
use dpn_core::estimate::WindowSigma;
use dpn_core::random::Stream;
use dpn_core::signal::FilterError;
use dpn_core::signal::stats::mean;
use dpn_pronet::network::Network;
use dpn_pronet::range::Quietest;
use dpn_train::asl::TUM_VI;
use dpn_train::base::Base;
use dpn_train::corpus::Corpus;
use dpn_train::examples::Examples;
use dpn_train::features::Features;
use dpn_train::label::Label;
use dpn_train::levels::{LevelKind, Levels};
use dpn_train::regress::{Regressor, fit_all};
use dpn_train::split::Side;
use dpn_train::trainer::predict;
use dpn_train::windows::{Stretch, WINDOW, WindowSet};
use rayon::prelude::*;
use std::borrow::Cow;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// Regressors fitted on one base.
pub(super) struct Fitted {
    /// The base.
    base: String,
    /// With the label they answer.
    regressors: Vec<(Label, Vec<Box<dyn Regressor>>)>,
}

/// The training side of one set.
pub(super) struct Training {
    examples: Examples,
    /// Features of the examples; none without examples.
    table: Option<Vec<f64>>,
    /// What is fitted to them.
    pub(super) fitted: Option<Fitted>,
}

/// One sensor, collection, base and kind of levels.
pub(super) struct Job<'a> {
    pub(super) request: &'a Request<'a>,
    pub(super) sensor: Sensor,
    pub(super) corpus: &'a Corpus,
    pub(super) base: Base,
    pub(super) kind: LevelKind,
    pub(super) features: &'a Features,
    pub(super) simple: &'a [Arc<dyn WindowSigma>],
    pub(super) stop: &'a AtomicBool,
}

/// What one estimator said, and under which labels it may be judged.
struct Answer {
    name: String,
    seed: Option<u64>,
    labels: Vec<Label>,
    sigma: Vec<f64>,
    /// Share of the windows that are unlike the network's training.
    outside: Option<f64>,
}

/// Windows that are held against a network's training range, about as many.
const LOOKED_AT: usize = 500;

/// Share of the rows that are unlike all that `network` was trained on, `sigma` its answers; none where its card does not say what that was.
fn outside(network: &Network, examples: &Examples, sigma: &[f64]) -> Option<f64> {
    let range = network.weights.card().range?;
    let quietest = range.quietest.and_then(|_| Quietest::new(examples.width));
    let every = (examples.window.last()? / LOOKED_AT).max(1);
    let looked_at = (0..examples.len()).filter(|row| examples.window[*row].is_multiple_of(every));
    let judged: Vec<f64> = looked_at
        .map(|row| {
            let window: Vec<f32> = examples.row(row).iter().map(|v| *v as f32).collect();
            f64::from(range.is_outside(&window, sigma[row], quietest.as_ref()))
        })
        .collect();
    Some(mean(&judged))
}

impl Job<'_> {
    /// Whether nothing here was trained on: the collection is judged raw.
    pub(super) fn foreign(&self) -> bool {
        self.corpus.name == TUM_VI
    }

    /// Rows, and what was fitted, if anything was.
    ///
    /// # Errors
    /// No windows; a fit that fails; a request to stop.
    pub(super) fn judge(
        &self,
        transfer: Option<&Fitted>,
    ) -> Result<(Vec<Row>, Option<Fitted>), OpenLoopError> {
        let training = if self.foreign() { None } else { Some(self.training()?) };
        let test = self.examples(Side::Test)?;
        let mut rows = Vec::new();
        let fitted = training.as_ref().and_then(|training| training.fitted.as_ref());
        if let Some(Training { examples, table: Some(table), .. }) = &training {
            let answers = self.answers(examples, Some(table), fitted, transfer)?;
            self.add_rows(Side::Train, examples, &answers, &mut rows);
        }
        if !test.is_empty() {
            let answers = self.answers(&test, None, fitted, transfer)?;
            self.add_rows(Side::Test, &test, &answers, &mut rows);
        }
        if test.is_empty() && training.as_ref().is_none_or(|training| training.table.is_none()) {
            return Err(OpenLoopError::NoWindows(self.corpus.name.clone()));
        }
        Ok((rows, training.and_then(|training| training.fitted)))
    }

    /// The training side, and what is fitted to it.
    ///
    /// # Errors
    /// A fit that fails; a request to stop.
    pub(super) fn training(&self) -> Result<Training, OpenLoopError> {
        let examples = self.examples(Side::Train)?;
        if examples.is_empty() {
            return Ok(Training { examples, table: None, fitted: None });
        }
        self.go_on()?;
        // The features are those of the noisy windows whatever they are labelled with.
        let table = self.features.table(&examples.samples);
        let fit = |label: &Label| {
            self.go_on()?;
            Ok((*label, fit_all(&table, &examples.truth(*label))?))
        };
        let both = Label::OF_WHITE.par_iter().map(fit).collect::<Result<Vec<_>, OpenLoopError>>()?;
        let fitted = Some(Fitted { base: self.base.to_string(), regressors: both });
        Ok(Training { examples, table: Some(table), fitted })
    }

    /// An error where a stop was asked for.
    fn go_on(&self) -> Result<(), OpenLoopError> {
        if self.stop.load(Ordering::Relaxed) {
            Err(OpenLoopError::Stopped { done: 0, total: 0 })
        } else {
            Ok(())
        }
    }

    /// Noisy windows of one side; the same noise for every base.
    fn examples(&self, side: Side) -> Result<Examples, FilterError> {
        let recordings = self.corpus.side(side);
        let set = WindowSet::cut(&recordings, self.sensor, self.base, Stretch::Whole, WINDOW)?;
        let stream = Stream::new(self.request.seed).named("open-loop").named(self.sensor.name());
        let stream = stream.named(&self.corpus.name).named(&side.to_string()).named(self.kind.family());
        Ok(Examples::draw(&set, &Levels::paper(self.sensor, self.kind), &stream))
    }

    /// Every estimator's answers; `table` holds the examples' features where they were computed before.
    fn answers(
        &self,
        examples: &Examples,
        table: Option<&[f64]>,
        fitted: Option<&Fitted>,
        transfer: Option<&Fitted>,
    ) -> Result<Vec<Answer>, OpenLoopError> {
        let windows = |estimator: &dyn WindowSigma| {
            self.go_on()?;
            Ok(Answer {
                name: estimator.name().to_owned(),
                seed: None,
                labels: Label::OF_WHITE.to_vec(),
                sigma: examples.samples.chunks_exact(WINDOW).map(|window| estimator.sigma(window)).collect(),
                outside: None,
            })
        };
        let simple = self.simple.par_iter().map(|estimator| windows(estimator.as_ref()));
        let mut answers = simple.collect::<Result<Vec<_>, OpenLoopError>>()?;
        let (regressors, suffix) = match (fitted, transfer) {
            (Some(fitted), _) => (Some(fitted), String::new()),
            (None, Some(fitted)) if self.foreign() => (Some(fitted), format!("@{}", fitted.base)),
            _ => (None, String::new()),
        };
        if let Some(fitted) = regressors {
            let table =
                table.map_or_else(|| Cow::Owned(self.features.table(&examples.samples)), Cow::Borrowed);
            for (label, regressors) in &fitted.regressors {
                for regressor in regressors {
                    self.go_on()?;
                    answers.push(Answer {
                        name: format!("{}{suffix}", regressor.name()),
                        seed: None,
                        labels: vec![*label],
                        sigma: regressor.predict(&table),
                        outside: None,
                    });
                }
            }
        }
        for network in self.request.networks.iter().filter(|network| network.sensor() == self.sensor) {
            let own = network.base == self.base.to_string() && network.levels == self.kind.family();
            if !own && !self.foreign() {
                continue;
            }
            self.go_on()?;
            let labels = Label::OF_WHITE.iter().copied();
            let sigma = predict(&network.weights, &examples.samples);
            answers.push(Answer {
                name: if own { network.name.clone() } else { format!("{}@{}", network.name, network.base) },
                seed: Some(network.seed),
                labels: labels.filter(|l| self.foreign() || l.to_string() == network.label).collect(),
                outside: outside(network, examples, &sigma),
                sigma,
            });
        }
        Ok(answers)
    }

    fn add_rows(&self, side: Side, examples: &Examples, answers: &[Answer], rows: &mut Vec<Row>) {
        let bins = Levels::paper(self.sensor, self.kind).steps;
        for label in Label::OF_WHITE {
            let truth = examples.truth(label);
            // Seeds of one network stand together under its name, in the order the names came.
            let mut groups: Vec<(&str, Vec<(Errors, &Answer)>)> = Vec::new();
            for answer in answers.iter().filter(|answer| answer.labels.contains(&label)) {
                let errors = Errors::of(&answer.sigma, &truth, &examples.injected, bins, WINDOW);
                match groups.iter_mut().find(|(name, _)| *name == answer.name) {
                    Some((_, group)) => group.push((errors, answer)),
                    None => groups.push((&answer.name, vec![(errors, answer)])),
                }
            }
            for (name, group) in groups {
                let count = group.len() as f64;
                let rmse = group.iter().map(|(e, _)| e.rmse).sum::<f64>() / count;
                let spread = group.iter().map(|(e, _)| (e.rmse - rmse).powi(2)).sum::<f64>() / (count - 1.0);
                let (first, answer) = &group[0];
                let outside: Option<Vec<f64>> = group.iter().map(|(_, answer)| answer.outside).collect();
                rows.push(Row {
                    sensor: self.sensor,
                    base: self.base.to_string(),
                    data: self.corpus.name.clone(),
                    split: side,
                    estimator: name.to_owned(),
                    levels: self.kind.family().to_owned(),
                    label,
                    rmse,
                    rmse_spread: (group.len() > 1).then(|| spread.sqrt()),
                    bias: group.iter().map(|(e, _)| e.bias).sum::<f64>() / count,
                    crb: first.crb,
                    ratio: rmse / first.crb,
                    n: truth.len(),
                    seeds: if answer.seed.is_some() { group.len() } else { 0 },
                    outside: outside.map(|shares| mean(&shares)),
                    by_sigma: first.by_sigma.clone(),
                });
            }
        }
    }
}
