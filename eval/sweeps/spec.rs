//! A job with everything resolved: what `sweep.json` holds of it, so that a node needs the sweep's folder and the data alone.

use crate::closed_loop::Experiment;
use dpn_train::config::TrainConfig;
use serde::{Deserialize, Serialize};

/// What a job's cells are.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum JobSpec {
    /// Runs of the odometry: the experiment, [resolved](Experiment::resolved).
    ClosedLoop(Box<Experiment>),
    /// Trainings: a configuration each, in the order of the cells.
    Train(Vec<TrainSpec>),
}

/// One training.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TrainSpec {
    /// Name of its folder.
    pub folder: String,
    /// The configuration, seed included.
    pub config: TrainConfig,
    /// Where it is computed, as `dpn train --device` names it.
    pub device: String,
}
