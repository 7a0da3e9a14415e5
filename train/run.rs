//! A training run on disk: resume where it stopped, save after every epoch, leave weights and a summary.
//!
//! The folder holds `config.toml` (every default written out, written before the first epoch), `checkpoint.safetensors`,
//! `history.jsonl`, and at the end `SENSOR.safetensors` and `summary.json`. Every file is there in full or not at all; what is
//! lost when the process dies is the epoch it was in. The checkpoint holds the history too, and a run that goes on writes it out first: a process
//! that died between the two leaves no line short. A run holds its folder's lock.
//!
//! A run may be resumed with another number of epochs where what is behind it is also the beginning of that run: then it ends in the same bits as
//! one that was as long from the start.

use crate::calibration::Calibration;
use crate::config::{Schedule, TrainConfig};
use crate::corpus::Corpus;
use crate::device::Device;
use crate::state::{Best, EpochRecord, State};
use crate::trainer::{TrainError, Trainer};
use dpn_core::progress::Progress;
use dpn_io::{FolderLock, IoError, LockError, ResultPath, write_file};
use dpn_pronet::weights::{Card, Weights};
use dpn_pronet::{Checkpoint, StoreError};
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value, json};
use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;
use std::time::Instant;
use thiserror::Error;

const CONFIG: &str = "config.toml";
const CHECKPOINT: &str = "checkpoint.safetensors";
const HISTORY: &str = "history.jsonl";
const SUMMARY: &str = "summary.json";
/// Vectors of the trainer's own in a checkpoint.
const AVERAGED: &str = "averaged";
const BEST: &str = "best";

/// Why a run cannot be started, resumed or saved.
#[derive(Debug, Error)]
pub enum RunError {
    /// Training itself.
    #[error(transparent)]
    Train(#[from] TrainError),
    /// A checkpoint or weights.
    #[error(transparent)]
    Store(#[from] StoreError),
    /// Another file of the run.
    #[error(transparent)]
    Io(#[from] IoError),
    /// A folder that another process trains in.
    #[error(transparent)]
    Locked(#[from] LockError),
    /// The folder holds a run already.
    #[error("{}: a run stands there already ({epochs} of its epochs done)", path.display())]
    Exists {
        /// The folder.
        path: PathBuf,
        /// Its finished epochs.
        epochs: u64,
    },
    /// Nothing to go on from.
    #[error("{}: no run to resume", path.display())]
    Nothing {
        /// The folder.
        path: PathBuf,
    },
    /// The run to resume was made with another configuration or other recordings.
    #[error("{}: cannot resume, because the run there {reason}", path.display())]
    Differs {
        /// The folder.
        path: PathBuf,
        /// What differs.
        reason: &'static str,
    },
    /// The run to resume is of another number of epochs, and what is behind it is no beginning of the one asked for.
    #[error("{}: cannot be made {epochs} epochs long, because the run there {reason}", path.display())]
    OtherLength {
        /// The folder.
        path: PathBuf,
        /// The epochs asked for.
        epochs: u64,
        /// Why not.
        reason: &'static str,
    },
    /// A configuration, summary or history that cannot be written as text, or read.
    #[error("the run's {what} is no text that can be written or read: {reason}")]
    Text {
        /// Which file.
        what: &'static str,
        /// Why.
        reason: String,
    },
}

impl RunError {
    /// What to do about it.
    pub fn hint(&self) -> Option<String> {
        match self {
            Self::Exists { .. } => {
                Some("go on with it by --resume, or choose another folder with --out".into())
            }
            Self::Nothing { .. } => Some("leave --resume out to start a run there".into()),
            Self::Differs { .. } => Some(
                "give the configuration and data it was started with, or start anew in another folder".into(),
            ),
            Self::OtherLength { .. } => Some(
                "train anew in another folder; what may be made longer is a run with fit.schedule = \"constant\", at a multiple of \
                 fit.validate_every epochs"
                    .into(),
            ),
            Self::Train(TrainError::Corpus(error)) => error.hint(),
            #[cfg(feature = "wgpu")]
            Self::Train(TrainError::Gpu(error)) => Some(error.hint()),
            Self::Io(error) => error.hint(),
            Self::Locked(error) => error.hint(),
            _ => None,
        }
    }
}

/// What came out of a run.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct RunSummary {
    /// Version of dpn.
    pub version: String,
    /// Name of the estimator in tables.
    pub name: String,
    /// `accel` or `gyro`.
    pub sensor: String,
    /// Base noise was injected into.
    pub base: String,
    /// `grid` or `continuous`.
    pub levels: String,
    /// `sigma_inj`, `sigma_tot` or `sigma_eff`.
    pub label: String,
    /// Seed.
    pub seed: u64,
    /// Collection of recordings, their names, their fingerprint.
    pub data: String,
    /// Training sequences.
    pub sequences: Vec<String>,
    /// SHA-256 over all samples.
    pub fingerprint: String,
    /// Windows learned from.
    pub fit_windows: usize,
    /// Windows validated on.
    pub validation_windows: usize,
    /// Parameters of the network.
    pub parameters: usize,
    /// Updates a whole run makes.
    pub updates: u64,
    /// Epoch whose weights were kept.
    pub best_epoch: u64,
    /// Their RMSE on the validation examples \[unit of the sensor\].
    pub validation_rmse: f64,
    /// How far off they are there in logarithms, and how far they say they are; absent where they do not say it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub calibration: Option<Calibration>,
}

/// What a checkpoint says besides its numbers.
#[derive(Debug, Serialize, Deserialize)]
struct Notes {
    config: TrainConfig,
    fingerprint: String,
    history: Vec<EpochRecord>,
    best: Option<(u64, f64)>,
}

/// A run in its folder.
pub struct Run<'a> {
    dir: ResultPath,
    trainer: Trainer,
    fingerprint: String,
    corpus: &'a Corpus,
    state: State,
    /// Held until the run is over.
    _lock: FolderLock,
}

impl<'a> Run<'a> {
    /// Starts a run in `dir`, or goes on with the one that stands there; one that has not finished an epoch begins anew. `config` may ask for
    /// another number of epochs than the run was begun with.
    ///
    /// # Errors
    /// A folder that another process trains in, holds a run already (without `resume`), holds none (with it), or one of another configuration
    /// or data, or one that no run of so many epochs begins as; recordings that do not serve; files that cannot be written.
    pub fn open(
        dir: impl Into<ResultPath>,
        config: &TrainConfig,
        corpus: &'a Corpus,
        device: &Device,
        resume: bool,
    ) -> Result<Self, RunError> {
        let trainer = Trainer::new(config, corpus, device)?;
        let fingerprint = corpus.fingerprint();
        let dir = dir.into();
        let lock = FolderLock::take(&dir)?;
        let path = dir.join(CHECKPOINT);
        let there = path.read()?.map(|bytes| Checkpoint::from_bytes(&bytes, path.path())).transpose()?;
        let state = match (there, resume) {
            (Some(there), true) => load(there, dir.path(), &trainer, &fingerprint)?,
            (Some(there), false) => {
                let epochs = notes(&there, dir.path())?.history.len() as u64;
                return Err(RunError::Exists { path: dir.path().to_owned(), epochs });
            }
            (None, true) if !dir.join(CONFIG).is_file() => {
                return Err(RunError::Nothing { path: dir.path().to_owned() });
            }
            (None, _) => trainer.start(),
        };
        let run = Self { dir, trainer, fingerprint, corpus, state, _lock: lock };
        let text = toml::to_string_pretty(run.trainer.config())
            .map_err(|error| RunError::Text { what: CONFIG, reason: error.to_string() })?;
        write_file(run.dir.join(CONFIG), &text)?;
        if run.state.epochs_done() > 0 {
            run.write_history()?;
        }
        Ok(run)
    }

    /// Epochs behind it, and in all.
    pub fn epochs(&self) -> (u64, u64) {
        (self.state.epochs_done(), self.trainer.config().fit.epochs)
    }

    /// Trains to the end, or until `stop` is set; then the run can be resumed.
    ///
    /// # Errors
    /// Divergence, a request to stop, files that cannot be written.
    pub fn train(
        mut self,
        stop: &AtomicBool,
        progress: &mut dyn Progress,
    ) -> Result<(RunSummary, ResultPath), RunError> {
        let fit = self.trainer.config().fit;
        let steps = self.trainer.steps_per_epoch();
        let sensor = self.trainer.config().sensor();
        progress.start(&format!("train {sensor}"), steps * fit.epochs);
        let clock = Instant::now();
        while self.state.epochs_done() < fit.epochs {
            let epoch = self.state.epochs_done();
            let best = self.state.best.as_ref().map(|best| best.validation_rmse);
            let note = |loss: f64| {
                let best = best.map_or_else(String::new, |rmse| {
                    format!(", best validation {rmse:.5} {}", sensor.unit())
                });
                format!("epoch {}/{}, loss {loss:.5}{best}", epoch + 1, fit.epochs)
            };
            self.trainer.epoch(&mut self.state, stop, &mut |done, loss| {
                progress.step(epoch * steps + done, &note(loss));
            })?;
            self.save()?;
        }
        let summary = self.summary()?;
        let path = self.dir.join(format!("{sensor}.safetensors"));
        self.finish(&summary, &path)?;
        progress.finish(&format!(
            "validation RMSE {:.5} {} at epoch {}, {:.0} s",
            summary.validation_rmse,
            sensor.unit(),
            summary.best_epoch,
            clock.elapsed().as_secs_f64()
        ));
        Ok((summary, path))
    }

    fn summary(&self) -> Result<RunSummary, RunError> {
        let config = self.trainer.config();
        let (fit_windows, validation_windows) = self.trainer.windows();
        let best = self.state.best.as_ref();
        let (validation_rmse, calibration) = match best {
            Some(best) => {
                let record = self.state.history.iter().find(|record| record.epoch == best.epoch);
                (best.validation_rmse, record.and_then(|record| record.calibration))
            }
            None => self.trainer.judge(&self.state.averaged)?,
        };
        Ok(RunSummary {
            version: env!("CARGO_PKG_VERSION").into(),
            name: config.name.clone(),
            sensor: config.sensor().name().into(),
            base: config.base.base().to_string(),
            levels: config.noise.levels.family().into(),
            label: config.noise.label.to_string(),
            seed: config.seed,
            data: self.corpus.name.clone(),
            sequences: self.trainer.sequences().to_vec(),
            fingerprint: self.fingerprint.clone(),
            fit_windows,
            validation_windows,
            parameters: dpn_pronet::shape::parameter_count(&config.network),
            updates: self.trainer.steps_per_epoch() * config.fit.epochs,
            best_epoch: best.map_or(self.state.epochs_done(), |best| best.epoch),
            validation_rmse,
            calibration,
        })
    }

    /// Writes the checkpoint and the history.
    fn save(&self) -> Result<(), RunError> {
        let text = |what| move |error: serde_json::Error| RunError::Text { what, reason: error.to_string() };
        let notes = Notes {
            config: self.trainer.config().clone(),
            fingerprint: self.fingerprint.clone(),
            history: self.state.history.clone(),
            best: self.state.best.as_ref().map(|best| (best.epoch, best.validation_rmse)),
        };
        let mut checkpoint = Checkpoint {
            config: self.trainer.config().network.clone(),
            parameters: self.state.weights.clone(),
            adam: self.state.adam.clone(),
            vectors: [(AVERAGED.to_owned(), self.state.averaged.clone())].into(),
            notes: Map::from_iter([(
                "run".to_owned(),
                serde_json::to_value(&notes).map_err(text(CHECKPOINT))?,
            )]),
        };
        if let Some(best) = &self.state.best {
            checkpoint.vectors.insert(BEST.to_owned(), best.weights.clone());
        }
        let bytes = checkpoint.to_bytes()?;
        // A kill leaves the checkpoint before it.
        write_file(self.dir.join(CHECKPOINT), &bytes)?;
        self.write_history()
    }

    /// A line an epoch.
    fn write_history(&self) -> Result<(), RunError> {
        let lines: Result<Vec<String>, _> = self.state.history.iter().map(serde_json::to_string).collect();
        let text = |error: serde_json::Error| RunError::Text { what: HISTORY, reason: error.to_string() };
        let lines = lines.map_err(text)?.join("\n") + "\n";
        Ok(write_file(self.dir.join(HISTORY), &lines)?)
    }

    /// Writes weights and summary.
    fn finish(&self, summary: &RunSummary, path: &ResultPath) -> Result<(), RunError> {
        let text = |error: serde_json::Error| RunError::Text { what: SUMMARY, reason: error.to_string() };
        let mut training = match serde_json::to_value(summary).map_err(text)? {
            Value::Object(map) => map,
            other => Map::from_iter([("summary".to_owned(), other)]),
        };
        training.insert("run".into(), json!(self.trainer.config()));
        let answering = self.trainer.weights(&self.state, Card::default());
        let card = Card {
            rate: self.trainer.config().rate_hz,
            range: self.trainer.trained_range(&answering),
            training,
        };
        let weights: Weights = self.trainer.weights(&self.state, card);
        let bytes = weights.to_bytes()?;
        write_file(path, &bytes)?;
        let lines = serde_json::to_string_pretty(summary).map_err(text)? + "\n";
        write_file(self.dir.join(SUMMARY), &lines)?;
        Ok(())
    }
}

/// The epochs of the run in `dir`.
///
/// # Errors
/// No history there, or one that does not read.
pub fn history(dir: &ResultPath) -> Result<Vec<EpochRecord>, RunError> {
    let bytes = dir.join(HISTORY).read_existing()?;
    let text = String::from_utf8_lossy(&bytes);
    let text_error = |error: serde_json::Error| RunError::Text { what: HISTORY, reason: error.to_string() };
    text.lines().map(|line| serde_json::from_str(line).map_err(text_error)).collect()
}

fn notes(checkpoint: &Checkpoint, dir: &Path) -> Result<Notes, RunError> {
    let notes = checkpoint.notes.get("run").and_then(|value| serde_json::from_value(value.clone()).ok());
    let reason = "was written by another version of dpn";
    notes.ok_or_else(|| RunError::Differs { path: dir.to_owned(), reason })
}

/// Whether a run of `was` with `done` epochs behind it has made the beginning of a run of `epochs`; the error says why not.
fn begins(was: &TrainConfig, done: u64, epochs: u64, steps_per_epoch: u64) -> Result<(), &'static str> {
    let fit = &was.fit;
    if fit.epochs == epochs {
        return Ok(());
    }
    if epochs < done {
        return Err("has more of them behind it");
    }
    if fit.schedule == Schedule::Cosine {
        return Err("lets its learning rate follow a cosine over all of its epochs");
    }
    if fit.warmup_steps > steps_per_epoch * epochs.min(fit.epochs) {
        return Err("ends before its learning rate has risen");
    }
    // The last epoch of a run is validated in any case, and its weights may be the best.
    let out_of_turn = |total: u64| done == total && !done.is_multiple_of(fit.validate_every);
    if out_of_turn(fit.epochs) || out_of_turn(epochs) {
        return Err("was, or was not, validated after its last epoch");
    }
    Ok(())
}

/// The state in a checkpoint, if it belongs to this run and these recordings.
fn load(
    mut checkpoint: Checkpoint,
    dir: &Path,
    trainer: &Trainer,
    fingerprint: &str,
) -> Result<State, RunError> {
    let config = trainer.config();
    let differs = |reason| RunError::Differs { path: dir.to_owned(), reason };
    let notes = notes(&checkpoint, dir)?;
    let mut as_long = notes.config.clone();
    as_long.fit.epochs = config.fit.epochs;
    if as_long != *config {
        return Err(differs("has another configuration"));
    }
    let (done, epochs) = (notes.history.len() as u64, config.fit.epochs);
    begins(&notes.config, done, epochs, trainer.steps_per_epoch())
        .map_err(|reason| RunError::OtherLength { path: dir.to_owned(), epochs, reason })?;
    if notes.fingerprint != fingerprint {
        return Err(differs("saw other recordings"));
    }
    let averaged = checkpoint.vectors.remove(AVERAGED).ok_or_else(|| differs("has no averaged weights"))?;
    let best = match (notes.best, checkpoint.vectors.remove(BEST)) {
        (Some((epoch, validation_rmse)), Some(weights)) => Some(Best { epoch, validation_rmse, weights }),
        (None, None) => None,
        _ => return Err(differs("does not hold its best weights")),
    };
    Ok(State {
        weights: checkpoint.parameters,
        averaged,
        adam: checkpoint.adam,
        best,
        history: notes.history,
    })
}
