//! Support vector regression with a Gaussian kernel.

use super::scaling::{Scaling, spread};
use super::{RegressError, Regressor};
use crate::features::Features;
use linfa::prelude::*;
use linfa_svm::Svm;
use ndarray::{Array1, Array2, ArrayView1};
use rayon::prelude::*;

/// Rows used at most: the kernel matrix grows with their square.
const MAX_ROWS: usize = 1500;
/// Price of a row outside the tube; half-width of the tube in units of the largest label.
const COST: f64 = 4.0;
const TUBE: f64 = 0.02;
/// Width of the kernel in units of scaled features: `exp(-|a - b|^2 / WIDTH)`.
const WIDTH: f64 = 100.0;

/// Support vector regression on scaled features.
#[derive(Debug)]
pub struct KernelRegressor {
    scaling: Scaling,
    model: Svm<f64, f64>,
}

impl KernelRegressor {
    /// Fits to rows of features and their labels; of more than 1,500 rows, that many evenly spread ones are used.
    ///
    /// # Errors
    /// A fit that linfa gives up.
    pub fn fit(table: &[f64], truth: &[f64]) -> Result<Self, RegressError> {
        let scaling = Scaling::of(table, truth);
        let scaled = scaling.apply(table);
        let keep = spread(truth.len(), MAX_ROWS);
        let mut rows = Array2::zeros((keep.len(), Features::COUNT));
        for (mut row, &at) in rows.outer_iter_mut().zip(&keep) {
            row.assign(&ArrayView1::from(&scaled[at * Features::COUNT..(at + 1) * Features::COUNT]));
        }
        let targets: Array1<f64> = keep.iter().map(|&at| truth[at] / scaling.label).collect();
        let dataset = Dataset::new(rows, targets);
        let model =
            Svm::<f64, f64>::params().c_svr(COST, Some(TUBE)).gaussian_kernel(WIDTH).fit(&dataset).map_err(
                |error| RegressError::Fit { method: "kernel regressor", reason: error.to_string() },
            )?;
        Ok(Self { scaling, model })
    }
}

impl Regressor for KernelRegressor {
    fn name(&self) -> &'static str {
        "kernel-svr"
    }

    fn predict(&self, table: &[f64]) -> Vec<f64> {
        let scaled = self.scaling.apply(table);
        scaled
            .par_chunks_exact(Features::COUNT)
            .map(|row| {
                let y: f64 = self.model.predict(ArrayView1::from(row));
                (y * self.scaling.label).max(0.0)
            })
            .collect()
    }
}
