//! One line of the open-loop table.

use dpn_core::Sensor;
use dpn_core::bounds::cramer_rao_pooled;
use dpn_train::label::Label;
use dpn_train::split::Side;
use serde::{Deserialize, Serialize};

/// How one estimator did on one set of windows with known truth.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Row {
    /// Sensor the windows are from.
    pub sensor: Sensor,
    /// Signal the noise was injected into, for example `sg(11,2)` or `raw`.
    pub base: String,
    /// Where the sequences are from, for example `euroc`.
    pub data: String,
    /// Side of the split the sequences are on.
    pub split: Side,
    /// Name of the estimator.
    pub estimator: String,
    /// `grid` or `continuous`.
    pub levels: String,
    /// What the estimates are compared with.
    pub label: Label,
    /// Root mean square error \[unit of the sensor\]; the mean over training seeds where there are several.
    pub rmse: f64,
    /// Standard deviation of the RMSE over training seeds; absent for one seed or none.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub rmse_spread: Option<f64>,
    /// Mean error.
    pub bias: f64,
    /// Smallest pooled RMSE of an unbiased estimator on windows of pure white noise of these deviations.
    pub crb: f64,
    /// `rmse / crb`. Below 1 is possible: prior knowledge of the levels biases, and pays.
    pub ratio: f64,
    /// Windows judged.
    pub n: usize,
    /// Training seeds averaged; 0 where nothing was trained.
    pub seeds: usize,
    /// Share of the windows that are unlike all that the network was trained on, the mean over its seeds; absent where no network was asked.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub outside: Option<f64>,
    /// RMSE and bias by true deviation.
    pub by_sigma: Vec<SigmaBin>,
}

/// Errors at one level of the true deviation.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct SigmaBin {
    /// Mean true deviation in the bin.
    pub sigma: f64,
    /// Root mean square error.
    pub rmse: f64,
    /// Mean error.
    pub bias: f64,
    /// Windows.
    pub n: usize,
}

/// The figures of one estimate against its truth.
#[derive(Debug, Clone, PartialEq)]
pub struct Errors {
    /// Root mean square error.
    pub rmse: f64,
    /// Mean error.
    pub bias: f64,
    /// See [`Row::crb`].
    pub crb: f64,
    /// See [`Row::by_sigma`].
    pub by_sigma: Vec<SigmaBin>,
}

impl Errors {
    /// Compares `estimate` with `truth`; `injected` decides the bins, `bins` of equal width over its range.
    ///
    /// # Panics
    /// When lengths differ.
    pub fn of(estimate: &[f64], truth: &[f64], injected: &[f64], bins: usize, window: usize) -> Self {
        assert!(
            estimate.len() == truth.len() && truth.len() == injected.len(),
            "one estimate and truth a window"
        );
        let n = estimate.len().max(1) as f64;
        let errors = || estimate.iter().zip(truth).map(|(e, t)| e - t);
        Self {
            rmse: (errors().map(|e| e * e).sum::<f64>() / n).sqrt(),
            bias: errors().sum::<f64>() / n,
            crb: cramer_rao_pooled(truth.iter().copied(), window),
            by_sigma: by_sigma(estimate, truth, injected, bins),
        }
    }
}

fn by_sigma(estimate: &[f64], truth: &[f64], injected: &[f64], bins: usize) -> Vec<SigmaBin> {
    let low = injected.iter().copied().fold(f64::INFINITY, f64::min);
    let high = injected.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let width = (high - low) / bins as f64;
    let mut sums = vec![(0.0, 0.0, 0.0, 0usize); bins];
    for ((e, t), level) in estimate.iter().zip(truth).zip(injected) {
        let at = if width > 0.0 { (((level - low) / width) as usize).min(bins - 1) } else { 0 };
        let sum = &mut sums[at];
        sum.0 += t;
        sum.1 += (e - t).powi(2);
        sum.2 += e - t;
        sum.3 += 1;
    }
    sums.into_iter()
        .filter(|sum| sum.3 > 0)
        .map(|(sigma, square, error, n)| {
            let count = n as f64;
            SigmaBin { sigma: sigma / count, rmse: (square / count).sqrt(), bias: error / count, n }
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn errors_of_a_known_case() {
        let errors = Errors::of(&[1.5, 2.0, 2.0, 4.5], &[1.0, 1.0, 3.0, 3.0], &[1.0, 1.0, 3.0, 3.0], 2, 200);
        assert!((errors.rmse - (4.5f64 / 4.0).sqrt()).abs() < 1e-12);
        assert!((errors.bias - 0.5).abs() < 1e-12);
        assert!((errors.crb - (5.0f64 / 400.0).sqrt()).abs() < 1e-12);
        assert_eq!(errors.by_sigma.len(), 2);
        assert_eq!((errors.by_sigma[1].n, errors.by_sigma[1].sigma), (2, 3.0));
    }
}
