//! What a training hands to a card and gets back.

use crate::source::Source;
use std::sync::Arc;

/// What steps change, each `[parameters]` in the order of [`dpn_pronet::shape::parameters`].
#[derive(Debug, Clone, PartialEq)]
pub struct State {
    /// Weights as the optimiser sees them.
    pub weights: Vec<f32>,
    /// Their running mean.
    pub averaged: Vec<f32>,
    /// Adam's running mean of the gradient.
    pub mean: Vec<f32>,
    /// And of its squares.
    pub square: Vec<f32>,
}

impl State {
    /// Before the first step.
    pub fn new(weights: Vec<f32>) -> Self {
        let zeros = vec![0.0; weights.len()];
        Self { averaged: weights.clone(), weights, mean: zeros.clone(), square: zeros }
    }
}

/// What one step is taken with.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Step {
    /// Its number, from 1 at the run's first.
    pub number: u64,
    /// Learning rate.
    pub rate: f64,
    /// What the weights' running mean keeps of itself.
    pub keep: f64,
}

/// What steps learn from.
#[derive(Debug)]
pub enum Examples {
    /// These: windows, `[rows, window]`, and their labels, `[rows]`.
    Given(Vec<f32>, Vec<f32>),
    /// Drawn on the card.
    Drawn {
        /// From what.
        source: Arc<Source>,
        /// Window and number of the draw of each row, below 65,536.
        rows: Vec<[u32; 2]>,
        /// Of the epoch's stream.
        key: [u32; 2],
    },
}

impl Examples {
    /// How many there are.
    pub(crate) fn rows(&self) -> usize {
        match self {
            Self::Given(_, labels) => labels.len(),
            Self::Drawn { rows, .. } => rows.len(),
        }
    }
}
