//! Median absolute deviation of second differences.

use super::WindowSigma;
use crate::signal::stats;

/// Relative excess of the figure over sigma, times the number of differences (measured: `golden/mad_bias`).
const EXCESS: f64 = 0.37;

/// `mad2`: median absolute deviation of the second differences about their median, over `sqrt(6)`.
///
/// Takes for noise what `diff2` does, but up to half of the differences may be anything: impacts, dropouts, single
/// steps. Pays for it with twice the smallest spread there can be. Fooled by vibration, and, where more
/// than half of the differences are equal (coarse quantisation), answers zero.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Mad2;

impl WindowSigma for Mad2 {
    fn name(&self) -> &str {
        "mad2"
    }

    fn min_len(&self) -> usize {
        4
    }

    fn sigma(&self, window: &[f64]) -> f64 {
        if window.len() < self.min_len() {
            return f64::NAN;
        }
        let d = stats::differences(window, 2);
        stats::mad(&d) / stats::difference_gain(2) / (1.0 + EXCESS / d.len() as f64)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::estimate::wavelet;
    use crate::random::Stream;
    use rand::Rng;
    use rand_distr::StandardNormal;
    use serde::Deserialize;

    #[test]
    fn impacts_on_a_fifth_of_the_differences_move_it_by_less_than_a_half() {
        let mut rng = Stream::new(8).named("estimate").named("impacts").rng();
        let x: Vec<f64> = (0..200).map(|_| rng.sample(StandardNormal)).collect();
        let mut hit = x.clone();
        (40..80).step_by(3).for_each(|i| hit[i] += 1000.0);
        let (clean, struck) = (Mad2.sigma(&x), Mad2.sigma(&hit));
        assert!(struck < 1.5 * clean, "{clean} became {struck}");
    }

    #[derive(Deserialize)]
    struct Golden {
        rows: Vec<Row>,
    }

    #[derive(Deserialize)]
    struct Row {
        estimator: String,
        excess_times_values: f64,
        standard_error: f64,
    }

    #[test]
    fn the_excess_of_the_medians_here_and_of_the_wavelets_is_the_measured_one() {
        let golden: Golden = dpn_testing::golden("mad_bias");
        for row in &golden.rows {
            let excess = if row.estimator == "mad2" { EXCESS } else { wavelet::EXCESS };
            assert!((excess - row.excess_times_values).abs() < 3.0 * row.standard_error, "{}", row.estimator);
        }
    }
}
