//! Regressors on window features, through linfa: what a network has to beat.

mod elastic_net;
mod kernel;
mod scaling;

pub use elastic_net::ElasticNetRegressor;
pub use kernel::KernelRegressor;

use crate::features::{FeatureError, Features};

/// Why a regressor cannot be fitted.
#[derive(Debug, thiserror::Error)]
pub enum RegressError {
    /// Features cannot be computed.
    #[error(transparent)]
    Features(#[from] FeatureError),
    /// Fewer rows than features.
    #[error("{rows} windows are too few to fit {features} features; give longer or more recordings")]
    TooFewRows {
        /// Rows there are.
        rows: usize,
        /// Features to be weighed.
        features: usize,
    },
    /// linfa gave up.
    #[error("the {method} could not be fitted: {reason}")]
    Fit {
        /// Which regressor.
        method: &'static str,
        /// What linfa says.
        reason: String,
    },
}

/// Predicts a deviation from features.
pub trait Regressor: Send + Sync {
    /// Name in tables.
    fn name(&self) -> &'static str;

    /// Deviations of rows of features, in the unit of the labels fitted.
    ///
    /// # Shapes
    /// `table`: rows of [`Features::COUNT`]; the answer: one number a row.
    fn predict(&self, table: &[f64]) -> Vec<f64>;
}

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
