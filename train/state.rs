//! Everything a training run carries from one epoch to the next.

use crate::calibration::Calibration;
use dpn_pronet::adam::{Adam, AdamConfig};
use serde::{Deserialize, Serialize};

/// One epoch in figures.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct EpochRecord {
    /// Epoch, from 1.
    pub epoch: u64,
    /// Mean training loss over its examples, in units of the output scale squared (or of squared logarithms).
    pub loss: f64,
    /// RMSE on the validation examples with the averaged weights \[unit of the sensor\]; absent where not validated.
    pub validation_rmse: Option<f64>,
    /// Learning rate of its last update.
    pub learning_rate: f64,
    /// On the validation examples, of a network that says how far off it is; absent where not validated.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub calibration: Option<Calibration>,
}

/// The weights kept so far.
#[derive(Debug, Clone, PartialEq)]
pub struct Best {
    /// Epoch they are from.
    pub epoch: u64,
    /// Their RMSE on the validation examples.
    pub validation_rmse: f64,
    /// The weights.
    pub weights: Vec<f32>,
}

/// State between two epochs.
#[derive(Debug, Clone, PartialEq)]
pub struct State {
    /// Weights as the optimiser sees them.
    pub weights: Vec<f32>,
    /// Their running mean, which is validated and kept.
    pub averaged: Vec<f32>,
    /// The optimiser.
    pub adam: Adam,
    /// Best weights so far.
    pub best: Option<Best>,
    /// Epochs behind us.
    pub history: Vec<EpochRecord>,
}

impl State {
    /// The state before the first epoch.
    pub fn new(weights: Vec<f32>, adam: AdamConfig) -> Self {
        Self {
            averaged: weights.clone(),
            adam: Adam::new(adam, weights.len()),
            weights,
            best: None,
            history: Vec::new(),
        }
    }

    /// Epochs behind us.
    pub(crate) fn epochs_done(&self) -> u64 {
        self.history.len() as u64
    }

    /// Takes the averaged weights as the best ones if `rmse` is the smallest so far.
    pub(crate) fn keep_if_best(&mut self, epoch: u64, rmse: f64) {
        if self.best.as_ref().is_none_or(|best| rmse < best.validation_rmse) {
            self.best = Some(Best { epoch, validation_rmse: rmse, weights: self.averaged.clone() });
        }
    }
}
