//! What every regressor answers, and why there may be none.

use crate::features::FeatureError;

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
    /// `table`: rows of [`Features::COUNT`](crate::features::Features::COUNT); the answer: one number a row.
    fn predict(&self, table: &[f64]) -> Vec<f64>;
}
