//! The open loop: every estimator on every set of windows with known noise.
//!
//! For each sensor, collection and base, the disjoint windows of both sides of the split are injected on the paper's grid
//! and on as many continuous levels. Simple estimators and networks read the noisy windows; regressors are fitted to the
//! training side first. A collection without bases of its own (raw TUM-VI) is judged as it is, by networks and
//! regressors of every base: nothing is ever trained on it.

use super::rows::{Errors, Row};
use dpn_core::Sensor;
use dpn_core::estimate::spec::EstimatorSpec;
use dpn_core::estimate::{EstimatorError, WindowSigma};
use dpn_core::progress::Progress;
use dpn_core::random::Stream;
use dpn_core::signal::FilterError;
use dpn_pronet::network::Network;
use dpn_train::asl::TUM_VI;
use dpn_train::base::{Base, Scope};
use dpn_train::corpus::Corpus;
use dpn_train::examples::Examples;
use dpn_train::features::{FeatureError, Features};
use dpn_train::label::Label;
use dpn_train::levels::{LevelKind, Levels};
use dpn_train::regress::{RegressError, Regressor, fit_all};
use dpn_train::split::Side;
use dpn_train::trainer::predict;
use dpn_train::windows::{Stretch, WINDOW, WindowSet};
use rayon::prelude::*;
use std::borrow::Cow;
use std::collections::BTreeMap;
use std::sync::Arc;
use thiserror::Error;

/// What to judge, and by what.
pub struct Request<'a> {
    /// Recordings.
    pub corpora: &'a [Corpus],
    /// Sensors.
    pub sensors: &'a [Sensor],
    /// Bases of collections that are not raw.
    pub bases: &'a [Base],
    /// Trained networks.
    pub networks: &'a [Network],
    /// Seed of the injected noise.
    pub seed: u64,
}

/// Why the open loop cannot be run.
#[derive(Debug, Error)]
pub enum OpenLoopError {
    /// A base's filter cannot be.
    #[error(transparent)]
    Filter(#[from] FilterError),
    /// A simple estimator cannot be.
    #[error(transparent)]
    Estimator(#[from] EstimatorError),
    /// Features of a regressor.
    #[error(transparent)]
    Features(#[from] FeatureError),
    /// A regressor cannot be fitted.
    #[error(transparent)]
    Regress(#[from] RegressError),
    /// Nothing to judge on.
    #[error("no windows to judge on in {0}; give longer recordings")]
    NoWindows(String),
}

/// Rows, and the predictions worth drawing.
#[derive(Debug, Default)]
pub struct OpenLoop {
    /// Every row.
    pub rows: Vec<Row>,
    /// Predictions on the test side with labels `sigma_inj`, by sensor, base and levels.
    pub drawn: Vec<Drawn>,
}

/// Predictions of one set of windows.
#[derive(Debug)]
pub struct Drawn {
    /// The sensor.
    pub sensor: Sensor,
    /// The base.
    pub base: String,
    /// `grid` or `continuous`.
    pub levels: String,
    /// True deviations.
    pub truth: Vec<f64>,
    /// Estimator and its predictions.
    pub estimates: Vec<(String, Vec<f64>)>,
}

/// Regressors fitted on one base, with the label they answer.
type Fitted = Vec<(Label, Vec<Box<dyn Regressor>>)>;

/// Judges everything asked for.
///
/// # Errors
/// Filters or estimators that cannot be; too few windows.
pub fn run(request: &Request<'_>, progress: &mut dyn Progress) -> Result<OpenLoop, OpenLoopError> {
    let features = Features::new()?;
    let simple = simple_estimators()?;
    let mut out = OpenLoop::default();
    let sets: Vec<(Sensor, &Corpus, Base, LevelKind)> = plan(request);
    progress.start("open loop", sets.len() as u64);
    let mut transfer: BTreeMap<(Sensor, &'static str), (String, Fitted)> = BTreeMap::new();
    for (done, (sensor, corpus, base, kind)) in sets.into_iter().enumerate() {
        progress.step(done as u64, &format!("{} {sensor} {base} {}", corpus.name, kind.family()));
        let job = Job { request, sensor, corpus, base, kind, features: &features, simple: &simple };
        let foreign = transfer.get(&(sensor, kind.family()));
        if let Some(fitted) = job.judge(foreign, &mut out)? {
            transfer.insert((sensor, kind.family()), fitted);
        }
    }
    progress.finish(&format!("{} rows", out.rows.len()));
    Ok(out)
}

/// Collections with bases first, so that what is fitted on them can be carried to the raw ones.
fn plan<'a>(request: &Request<'a>) -> Vec<(Sensor, &'a Corpus, Base, LevelKind)> {
    let mut sets = Vec::new();
    for raw in [false, true] {
        for corpus in request.corpora.iter().filter(|corpus| (corpus.name == TUM_VI) == raw) {
            for &sensor in request.sensors {
                let own = [Base::Raw];
                for &base in if raw { &own[..] } else { request.bases } {
                    for kind in [LevelKind::Grid, LevelKind::Uniform] {
                        sets.push((sensor, corpus, base, kind));
                    }
                }
            }
        }
    }
    sets
}

/// The simple estimators of the study, with their default parameters.
fn simple_estimators() -> Result<Vec<Arc<dyn WindowSigma>>, EstimatorError> {
    EstimatorSpec::all().iter().map(|spec| spec.for_windows(WINDOW)).collect()
}

/// One sensor, collection, base and kind of levels.
struct Job<'a> {
    request: &'a Request<'a>,
    sensor: Sensor,
    corpus: &'a Corpus,
    base: Base,
    kind: LevelKind,
    features: &'a Features,
    simple: &'a [Arc<dyn WindowSigma>],
}

/// What one estimator said, and under which labels it may be judged.
struct Answer {
    name: String,
    seed: Option<u64>,
    labels: Vec<Label>,
    sigma: Vec<f64>,
}

impl Job<'_> {
    /// Whether nothing here was trained on: the collection is judged raw.
    fn foreign(&self) -> bool {
        self.corpus.name == TUM_VI
    }

    /// Adds rows and drawings; returns what was fitted, if anything was.
    fn judge(
        &self,
        transfer: Option<&(String, Fitted)>,
        out: &mut OpenLoop,
    ) -> Result<Option<(String, Fitted)>, OpenLoopError> {
        let train = if self.foreign() { None } else { Some(self.examples(Side::Train)?) };
        let test = self.examples(Side::Test)?;
        let (mut fitted, mut train_table) = (None, None);
        if let Some(train) = train.as_ref().filter(|train| !train.is_empty()) {
            // The features are those of the noisy windows whatever they are labelled with.
            let table = self.features.table(&train.samples);
            let fit = |label: &Label| Ok((*label, fit_all(&table, &train.truth(*label))?));
            let both: Result<Fitted, RegressError> = Label::ALL.par_iter().map(fit).collect();
            fitted = Some((self.base.to_string(), both?));
            train_table = Some(table);
        }
        let sides = [(Side::Train, train.as_ref(), train_table.as_deref()), (Side::Test, Some(&test), None)];
        for (side, examples, table) in sides {
            let Some(examples) = examples.filter(|examples| !examples.is_empty()) else {
                continue;
            };
            let answers = self.answers(examples, table, fitted.as_ref(), transfer);
            self.add_rows(side, examples, &answers, &mut out.rows);
            if side == Side::Test && !self.foreign() {
                out.drawn.push(self.drawn(examples, &answers));
            }
        }
        if test.is_empty() && train.is_none_or(|train| train.is_empty()) {
            return Err(OpenLoopError::NoWindows(self.corpus.name.clone()));
        }
        Ok(fitted)
    }

    /// Noisy windows of one side; the same noise for every base.
    fn examples(&self, side: Side) -> Result<Examples, FilterError> {
        let recordings = self.corpus.side(side);
        let set = WindowSet::cut(&recordings, self.sensor, self.base, Scope::Window, Stretch::Whole)?;
        let stream = Stream::new(self.request.seed).named("open-loop").named(self.sensor.name());
        let stream = stream.named(&self.corpus.name).named(&side.to_string()).named(self.kind.family());
        Ok(Examples::draw(&set, &Levels::paper(self.sensor, self.kind), &stream))
    }

    /// Every estimator's answers; `table` holds the examples' features where they were computed before.
    fn answers(
        &self,
        examples: &Examples,
        table: Option<&[f64]>,
        fitted: Option<&(String, Fitted)>,
        transfer: Option<&(String, Fitted)>,
    ) -> Vec<Answer> {
        let mut answers: Vec<Answer> = self
            .simple
            .par_iter()
            .map(|estimator| Answer {
                name: estimator.name().to_owned(),
                seed: None,
                labels: Label::ALL.to_vec(),
                sigma: examples.samples.chunks_exact(WINDOW).map(|window| estimator.sigma(window)).collect(),
            })
            .collect();
        let (regressors, suffix) = match (fitted, transfer) {
            (Some((_, fitted)), _) => (Some(fitted), String::new()),
            (None, Some((base, fitted))) if self.foreign() => (Some(fitted), format!("@{base}")),
            _ => (None, String::new()),
        };
        if let Some(regressors) = regressors {
            let table =
                table.map_or_else(|| Cow::Owned(self.features.table(&examples.samples)), Cow::Borrowed);
            for (label, fitted) in regressors {
                answers.extend(fitted.iter().map(|regressor| Answer {
                    name: format!("{}{suffix}", regressor.name()),
                    seed: None,
                    labels: vec![*label],
                    sigma: regressor.predict(&table),
                }));
            }
        }
        for network in self.request.networks.iter().filter(|network| network.sensor() == self.sensor) {
            let own = network.base == self.base.to_string() && network.levels == self.kind.family();
            if !own && !self.foreign() {
                continue;
            }
            let labels = Label::ALL.iter().copied();
            answers.push(Answer {
                name: if own { network.name.clone() } else { format!("{}@{}", network.name, network.base) },
                seed: Some(network.seed),
                labels: labels.filter(|l| self.foreign() || l.to_string() == network.label).collect(),
                sigma: predict(&network.weights, &examples.samples),
            });
        }
        answers
    }

    fn add_rows(&self, side: Side, examples: &Examples, answers: &[Answer], rows: &mut Vec<Row>) {
        let bins = Levels::paper(self.sensor, self.kind).steps;
        for label in Label::ALL {
            let truth = examples.truth(label);
            // Seeds of one network stand together under its name, in the order the names came.
            let mut groups: Vec<(&str, Vec<(Errors, bool)>)> = Vec::new();
            for answer in answers.iter().filter(|answer| answer.labels.contains(&label)) {
                let errors = Errors::of(&answer.sigma, &truth, &examples.injected, bins, WINDOW);
                match groups.iter_mut().find(|(name, _)| *name == answer.name) {
                    Some((_, group)) => group.push((errors, answer.seed.is_some())),
                    None => groups.push((&answer.name, vec![(errors, answer.seed.is_some())])),
                }
            }
            for (name, group) in groups {
                let count = group.len() as f64;
                let rmse = group.iter().map(|(e, _)| e.rmse).sum::<f64>() / count;
                let spread = group.iter().map(|(e, _)| (e.rmse - rmse).powi(2)).sum::<f64>() / (count - 1.0);
                let (first, trained) = &group[0];
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
                    seeds: if *trained { group.len() } else { 0 },
                    by_sigma: first.by_sigma.clone(),
                });
            }
        }
    }

    fn drawn(&self, examples: &Examples, answers: &[Answer]) -> Drawn {
        let mut estimates: Vec<(String, Vec<f64>)> = Vec::new();
        for answer in answers.iter().filter(|answer| answer.labels.contains(&Label::Injected)) {
            if !estimates.iter().any(|(name, _)| *name == answer.name) {
                estimates.push((answer.name.clone(), answer.sigma.clone()));
            }
        }
        Drawn {
            sensor: self.sensor,
            base: self.base.to_string(),
            levels: self.kind.family().to_owned(),
            truth: examples.truth(Label::Injected),
            estimates,
        }
    }
}
