//! How well the deviation of white noise can be known at all.
//!
//! For `n` samples of zero-mean Gaussian noise the Fisher information about sigma is `2 n / sigma^2`, so no unbiased
//! estimator has a standard deviation below `sigma / sqrt(2 n)` (Cramer-Rao).

/// Smallest standard deviation of an unbiased estimate of `sigma` from `n` samples of pure white noise.
///
/// # Units and frames
/// Same unit as `sigma`.
pub fn cramer_rao_sigma(sigma: f64, n: usize) -> f64 {
    sigma / (2.0 * n as f64).sqrt()
}

/// Root mean square of the bound over several true deviations: the smallest pooled RMSE an unbiased estimator can
/// show over windows with these deviations, each of `n` samples.
pub fn cramer_rao_pooled(sigmas: impl IntoIterator<Item = f64>, n: usize) -> f64 {
    let (mut sum, mut count) = (0.0, 0usize);
    for sigma in sigmas {
        sum += sigma * sigma;
        count += 1;
    }
    if count == 0 { 0.0 } else { (sum / count as f64 / (2.0 * n as f64)).sqrt() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_papers_accelerometer_grid_has_the_bound_of_the_issue() {
        let grid = (0..11).map(|i| 0.01 + 0.02 * f64::from(i));
        assert!((cramer_rao_pooled(grid, 200) - 0.0063).abs() < 5e-5);
    }
}
