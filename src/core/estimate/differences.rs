//! Deviation of differences of order 1 to 4.

use super::EstimatorError;
use super::quadratic::Linear;
use crate::signal::stats;

/// `diff1` to `diff4`: deviation of the differences of that order about their mean, over the gain of white noise.
///
/// Takes for noise what changes from sample to sample: order k weighs frequency f by `(2 sin(pi f / rate))^(2 k)`, so
/// the higher the order, the less motion and the more of the last octave below Nyquist. Fooled by vibration near
/// Nyquist, which high orders exaggerate (a tone at .465 of the rate counts 1.41, 1.61, 1.76 and 1.87 times its
/// deviation in orders 1 to 4), and by quantisation. A polynomial trend of degree k leaves order k unmoved.
///
/// The order, 1 to 4; `samples` is the length of the windows it will mostly be asked for.
///
/// # Errors
/// Another order; `samples` below `order + 2`.
pub(crate) fn differences(order: usize, samples: usize) -> Result<Linear, EstimatorError> {
    if !(1..=4).contains(&order) {
        return Err(EstimatorError::Parameter {
            estimator: "diff",
            parameter: "order",
            value: order as f64,
            range: "1, 2, 3 or 4",
        });
    }
    Linear::new(format!("diff{order}"), order + 2, samples, move |x| centred_differences(x, order))
}

fn centred_differences(x: &[f64], order: usize) -> Vec<f64> {
    let mut d = stats::differences(x, order);
    let mean = stats::mean(&d);
    d.iter_mut().for_each(|v| *v -= mean);
    d
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;

    #[test]
    fn a_tone_near_nyquist_counts_as_the_opening_text_says() {
        let x: Vec<f64> = (0..4000).map(|i| 2f64.sqrt() * (TAU * 0.465 * f64::from(i)).sin()).collect();
        for (order, times) in [(1, 1.41), (2, 1.61), (3, 1.76), (4, 1.87)] {
            // The gain alone: the correction of the root matters below 1e-3 here.
            let d = centred_differences(&x, order);
            let got = stats::deviation(&d, stats::Ddof::Zero) / stats::difference_gain(order);
            assert!((got - times).abs() < 0.005, "order {order}: {got}");
        }
    }

    #[test]
    fn orders_out_of_range_are_refused() {
        assert!(differences(0, 200).is_err());
        assert!(differences(5, 200).is_err());
        assert!(matches!(differences(2, 3), Err(EstimatorError::WindowTooShort { needs: 4, .. })));
    }
}
