//! Deviation of the Savitzky-Golay residual, corrected for what the filter keeps.

use super::EstimatorError;
use super::quadratic::{Linear, WIDEST};
use crate::signal::SavitzkyGolay;

/// `sg(window,order)`: sigma from `x - SG(x)` over the window, polynomial edges included.
///
/// Takes for noise whatever a local polynomial does not follow: with (11,2) at 200 Hz most of what lies above 25 Hz.
/// Fooled by vibration in that range, which it counts in full; blind to noise that a wide polynomial follows, which
/// for white noise is corrected exactly. A trend of the polynomial's order leaves it unmoved.
///
/// The filter's window and order; `samples` is the length of the windows it will mostly be asked for.
///
/// # Errors
/// A filter's window above 501; what [`SavitzkyGolay::new`] refuses; an order of `window - 1`, which leaves no residual; `samples` below the
/// filter's window.
pub(crate) fn sg_residual(window: usize, order: usize, samples: usize) -> Result<Linear, EstimatorError> {
    // Held against its bound before a filter of that size is made: it takes memory with the window's square.
    if window > WIDEST {
        return Err(EstimatorError::Parameter {
            estimator: "sg",
            parameter: "window",
            value: window as f64,
            range: "at most 501 samples",
        });
    }
    let filter = SavitzkyGolay::new(window, order)?;
    if order + 1 == window {
        return Err(EstimatorError::Parameter {
            estimator: "sg",
            parameter: "order",
            value: order as f64,
            range: "at most the window less 2, or the polynomial passes through every sample",
        });
    }
    Linear::new(format!("sg({window},{order})"), window, samples, move |x| residual(&filter, x))
}

/// `x - SG(x)` of a window that is as long as the filter's or longer.
fn residual(filter: &SavitzkyGolay, x: &[f64]) -> Vec<f64> {
    let mut out = filter.smooth(x).expect("shorter windows are answered with NaN before");
    out.iter_mut().zip(x).for_each(|(y, v)| *y = v - *y);
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::estimate::WindowSigma;

    #[test]
    fn the_gain_agrees_with_the_filters_own_figure() {
        for (window, order) in [(5, 2), (11, 2), (51, 3)] {
            let estimator = sg_residual(window, order, 200).unwrap();
            let filter = SavitzkyGolay::new(window, order).unwrap();
            let noise: Vec<f64> = (0..200).map(|i| f64::from(i * i * 37 % 101) - 50.0).collect();
            let r = residual(&filter, &noise);
            let plain = (r.iter().map(|v| v * v).sum::<f64>() / 200.0).sqrt() / filter.residual_gain(200);
            let corrected = estimator.sigma(&noise) * super::super::quadratic::c4(estimator.gain.nu());
            assert!((plain / corrected - 1.0).abs() < 1e-12, "({window},{order})");
        }
    }

    #[test]
    fn a_filter_that_leaves_no_residual_is_refused() {
        assert!(matches!(sg_residual(5, 4, 200), Err(EstimatorError::Parameter { parameter: "order", .. })));
        assert!(matches!(sg_residual(51, 3, 50), Err(EstimatorError::WindowTooShort { needs: 51, .. })));
        assert!(matches!(sg_residual(6, 2, 200), Err(EstimatorError::Filter(_))));
        assert_eq!(
            sg_residual(999_999, 3, 1_000_000).map(|_| ()).unwrap_err().to_string(),
            "sg: window is 999999, it must be at most 501 samples"
        );
    }
}
