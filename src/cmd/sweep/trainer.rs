//! Trainings of a sweep.

use crate::cmd::training_curve::draw_curve;
use crate::cmd::{corpus, device, program};
use anyhow::Result;
use dpn_core::SampleRate;
use dpn_core::config::Validate;
use dpn_core::progress::Progress;
use dpn_eval::sweeps::{SweepError, TrainFault, TrainPlan, TrainSpec, Trainer};
use dpn_io::ResultPath;
use dpn_papers::id;
use dpn_train::config::TrainConfig;
use dpn_train::corpus::Corpus;
use dpn_train::run::{Run, RunError};
use dpn_train::trainer::TrainError;
use serde_json::{Map, Value};
use std::path::PathBuf;
use std::sync::atomic::AtomicBool;
use std::sync::{Arc, Mutex, PoisonError};

/// Folder of a sweep's own networks.
pub(super) const MODELS: &str = "models";

/// Trains on one corpus, which is read when it is first needed: once a rate, for a trainer and all its clones.
#[derive(Clone)]
pub(crate) struct CorpusTrainer {
    data: Option<PathBuf>,
    read: Arc<Mutex<Vec<Arc<Read>>>>,
}

/// A corpus and its checksum.
struct Read {
    corpus: Corpus,
    fingerprint: String,
}

impl CorpusTrainer {
    pub(crate) fn new(data: Option<PathBuf>) -> Self {
        Self { data, read: Arc::default() }
    }

    fn corpus(&self, rate: SampleRate) -> Result<Arc<Read>> {
        // A panic while it was read left nothing there: nothing is broken.
        let mut read = self.read.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(read) = read.iter().find(|read| read.corpus.rate == rate) {
            return Ok(Arc::clone(read));
        }
        let corpus = corpus::to_train(corpus::load(self.data.as_deref(), rate)?)?;
        let fingerprint = corpus.fingerprint();
        read.push(Arc::new(Read { corpus, fingerprint }));
        Ok(Arc::clone(&read[read.len() - 1]))
    }

    /// Every training of a plan, with its checksum and its updates.
    pub(crate) fn trainings(&mut self, plan: &TrainPlan) -> Result<Vec<(TrainSpec, String, f64)>> {
        device::parse(&plan.device)?;
        // Updates are counted, none is made.
        let device = device::parse(device::CPU)?;
        let mut all = Vec::new();
        for (name, config) in plan.configurations()? {
            config.validate()?;
            let steps =
                dpn_train::trainer::Trainer::new(&config, &self.corpus(config.rate_hz)?.corpus, &device)?
                    .steps_per_epoch();
            let updates = (steps * config.fit.epochs) as f64;
            for seed in plan.seed..plan.seed.saturating_add(plan.seeds) {
                let config = TrainConfig { seed, ..config.clone() };
                let folder = format!("{name}-seed{seed}");
                let spec = TrainSpec { folder, config, device: plan.device.clone() };
                let content = self.content(&spec)?;
                all.push((spec, content, updates));
            }
        }
        Ok(all)
    }

    fn run(
        &mut self,
        spec: &TrainSpec,
        dir: &ResultPath,
        (stop, progress): (&AtomicBool, &mut dyn Progress),
    ) -> Result<Map<String, Value>> {
        let device = device::parse(&spec.device)?;
        let read = self.corpus(spec.config.rate_hz)?;
        let resume = dir.join("checkpoint.safetensors").is_file();
        let (summary, _) =
            Run::open(dir, &spec.config, &read.corpus, &device, resume)?.train(stop, progress)?;
        draw_curve(spec.config.sensor(), &summary, dir)?;
        match serde_json::to_value(&summary)? {
            Value::Object(row) => Ok(row),
            other => Ok(Map::from_iter([("summary".to_owned(), other)])),
        }
    }
}

impl Trainer for CorpusTrainer {
    fn content(&mut self, spec: &TrainSpec) -> Result<String, SweepError> {
        let read =
            self.corpus(spec.config.rate_hz).map_err(|error| SweepError::Train(format!("{error:#}")))?;
        let config = serde_json::to_string(&spec.config.resolved()).expect("a configuration is JSON");
        Ok(id([program(), read.fingerprint.clone(), config, spec.device.clone()]))
    }

    fn train(
        &mut self,
        spec: &TrainSpec,
        dir: &ResultPath,
        with: (&AtomicBool, &mut dyn Progress),
    ) -> Result<Map<String, Value>, TrainFault> {
        self.run(spec, dir, with).map_err(|error| match error.downcast_ref() {
            Some(RunError::Train(TrainError::Stopped { .. })) => TrainFault::Stopped,
            _ => TrainFault::Failed(format!("{error:#}")),
        })
    }
}
