//! A linear regressor with both penalties, on the features and their squares.

use super::scaling::{Scaling, spread};
use super::{RegressError, Regressor};
use crate::features::Features;
use linfa::prelude::*;
use linfa_elasticnet::ElasticNet;
use ndarray::{Array1, Array2, ArrayView2};

/// Weight of the penalties; share of the absolute one in them.
const PENALTY: f64 = 1e-4;
const L1_RATIO: f64 = 0.5;
/// Rows used at most: 44 weights need no more.
const MAX_ROWS: usize = 6000;

/// `sigma = w . (f, f^2) + c` with an elastic-net penalty on `w`.
#[derive(Debug)]
pub struct ElasticNetRegressor {
    scaling: Scaling,
    model: ElasticNet<f64>,
}

impl ElasticNetRegressor {
    /// Fits to rows of features and their labels.
    ///
    /// # Errors
    /// A fit that linfa gives up.
    pub fn fit(table: &[f64], truth: &[f64]) -> Result<Self, RegressError> {
        let scaling = Scaling::of(table, truth);
        let keep = spread(truth.len(), MAX_ROWS);
        let rows: Vec<f64> = keep
            .iter()
            .flat_map(|&at| &table[at * Features::COUNT..(at + 1) * Features::COUNT])
            .copied()
            .collect();
        let targets: Array1<f64> = keep.iter().map(|&at| truth[at] / scaling.label).collect();
        let dataset = Dataset::new(expand(&scaling.apply(&rows)), targets);
        let model = ElasticNet::params()
            .penalty(PENALTY)
            .l1_ratio(L1_RATIO)
            .max_iterations(2000)
            .tolerance(1e-5)
            .fit(&dataset)
            .map_err(|error| RegressError::Fit { method: "elastic net", reason: error.to_string() })?;
        Ok(Self { scaling, model })
    }
}

/// Rows of features followed by their squares.
fn expand(scaled: &[f64]) -> Array2<f64> {
    let rows = scaled.len() / Features::COUNT;
    let mut out = Array2::zeros((rows, 2 * Features::COUNT));
    for (row, mut target) in scaled.chunks_exact(Features::COUNT).zip(out.outer_iter_mut()) {
        for (i, value) in row.iter().enumerate() {
            target[i] = *value;
            target[Features::COUNT + i] = value * value;
        }
    }
    out
}

impl Regressor for ElasticNetRegressor {
    fn name(&self) -> &'static str {
        "elastic-net"
    }

    fn predict(&self, table: &[f64]) -> Vec<f64> {
        let rows = expand(&self.scaling.apply(table));
        let view: ArrayView2<'_, f64> = rows.view();
        self.model.predict(&view).iter().map(|y| (y * self.scaling.label).max(0.0)).collect()
    }
}
