//! Regressors on window features, through linfa: what a network has to beat.

mod elastic_net;
mod kernel;
mod regressor;
mod scaling;

pub use elastic_net::ElasticNetRegressor;
pub use kernel::KernelRegressor;
pub use regressor::{RegressError, Regressor};

use crate::features::Features;

/// Fits both regressors to rows of features and their labels.
///
/// # Shapes
/// `table`: rows of [`Features::COUNT`], as [`Features::table`] gives; `truth`: one label a row.
///
/// # Errors
/// Too few examples; a fit that linfa gives up.
pub fn fit_all(table: &[f64], truth: &[f64]) -> Result<Vec<Box<dyn Regressor>>, RegressError> {
    if truth.len() < 2 * Features::COUNT {
        return Err(RegressError::TooFewRows { rows: truth.len(), features: Features::COUNT });
    }
    Ok(vec![Box::new(ElasticNetRegressor::fit(table, truth)?), Box::new(KernelRegressor::fit(table, truth)?)])
}
