//! A list of errors in a few numbers.

use dpn_core::signal::stats::median;
use serde::{Deserialize, Serialize};

/// A list of errors in a few numbers, in the errors' unit.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct ErrorSummary {
    /// How many.
    pub count: usize,
    /// Root of the mean square.
    pub rmse: f64,
    /// Mean.
    pub mean: f64,
    /// Median.
    pub median: f64,
    /// Largest.
    pub max: f64,
}

impl ErrorSummary {
    /// Of `errors`, each zero or more; `None` for none.
    pub fn of(errors: &[f64]) -> Option<Self> {
        if errors.is_empty() {
            return None;
        }
        let n = errors.len() as f64;
        Some(Self {
            count: errors.len(),
            rmse: (errors.iter().map(|e| e * e).sum::<f64>() / n).sqrt(),
            mean: errors.iter().sum::<f64>() / n,
            median: median(errors),
            max: errors.iter().copied().fold(0.0, f64::max),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn four_errors_by_hand() {
        let got = ErrorSummary::of(&[1.0, 5.0, 1.0, 3.0]).unwrap();
        let expected = ErrorSummary { count: 4, rmse: 3.0, mean: 2.5, median: 2.0, max: 5.0 };
        assert_eq!(got, expected);
        assert_eq!(ErrorSummary::of(&[]), None);
    }
}
