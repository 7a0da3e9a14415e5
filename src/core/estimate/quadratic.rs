//! Makes the root of a sum of squared residuals an unbiased estimate of sigma.
//!
//! Residuals `r = M x` of white noise have `E[r . r] = sigma^2 tr(A)` with `A = M^T M`, and `r . r` spreads as a
//! chi-square of `nu = tr(A)^2 / tr(A^2)` degrees of freedom (Satterthwaite 1946). The root of such a sum lies low by
//! the factor `c4(nu)`, so `sigma = sqrt(r . r / tr(A)) / c4(nu)`. Its spread is `sigma / sqrt(2 nu)`: over the
//! Cramer-Rao bound by `sqrt(n / nu)`.

use super::{EstimatorError, WindowSigma};
use nalgebra::DMatrix;

/// Mean of the root of a chi-square of `nu` degrees of freedom, over `sqrt(nu)`; 1 - 1 / (4 nu) for large `nu`.
pub(super) fn c4(nu: f64) -> f64 {
    // R(a) = Gamma(a + 1/2) / Gamma(a), raised to large a by R(a) = R(a + 1) a / (a + 1/2).
    let (mut a, mut factor) = (0.5 * nu, 1.0);
    while a < 12.0 {
        factor *= a / (a + 0.5);
        a += 1.0;
    }
    let b = 1.0 / a;
    let series = 1.0 - b / 8.0 + b * b / 128.0 + 5.0 * b * b * b / 1024.0 - 21.0 * b.powi(4) / 32768.0;
    factor * series * a.sqrt() / (0.5 * nu).sqrt()
}

/// What a linear map does to white noise of `n` samples.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Gain {
    /// Length of the window this holds for.
    n: usize,
    /// `tr(A)`: mean of the sum of squared residuals at sigma 1.
    trace: f64,
    /// Degrees of freedom of that sum.
    nu: f64,
}

/// Windows up to this length are summed pulse by pulse, which takes memory with its square and time with its cube.
const PULSES: usize = 1000;
/// The widest filter whose edges a window of [`PULSES`] keeps apart.
pub(super) const WIDEST: usize = PULSES / 2 + 1;

impl Gain {
    /// What `residuals` does to white noise of `n` samples; its coefficients reach no further than [`WIDEST`] samples.
    ///
    /// Of a longer window both traces grow by the same with every sample inside, and edges add what they always add: exact but for the mean
    /// that some residuals are cleared of, which at a thousand samples moves sigma by less than 1e-6.
    pub(super) fn of(n: usize, residuals: impl Fn(&[f64]) -> Vec<f64>) -> Self {
        if n <= PULSES {
            return Self::by_pulses(n, residuals);
        }
        let edges = Self::by_pulses(PULSES, &residuals);
        let mut pulse = vec![0.0; PULSES];
        pulse[PULSES / 2] = 1.0;
        let inside = residuals(&pulse);
        let reach = inside.len().min(2 * WIDEST);
        let products = (0..reach).map(|lag| {
            let product: f64 = inside.iter().zip(&inside[lag..]).map(|(a, b)| a * b).sum();
            // A lag to either side.
            if lag == 0 { product * product } else { 2.0 * product * product }
        });
        let more = (n - PULSES) as f64;
        let square = edges.trace * edges.trace / edges.nu + more * products.sum::<f64>();
        let trace = edges.trace + more * inside.iter().map(|v| v * v).sum::<f64>();
        Self { n, trace, nu: trace * trace / square }
    }

    /// Applies `residuals` to every unit pulse of `n` samples.
    fn by_pulses(n: usize, residuals: impl Fn(&[f64]) -> Vec<f64>) -> Self {
        let mut pulse = vec![0.0; n];
        let columns: Vec<Vec<f64>> = (0..n)
            .map(|place| {
                pulse[place] = 1.0;
                let column = residuals(&pulse);
                pulse[place] = 0.0;
                column
            })
            .collect();
        let rows = columns.first().map_or(0, Vec::len);
        let map = DMatrix::from_iterator(rows, n, columns.into_iter().flatten());
        let trace = map.norm_squared();
        let square = (map.transpose() * map).norm_squared();
        Self { n, trace, nu: trace * trace / square }
    }

    /// Sigma from the residuals of a window of `n` samples.
    pub(super) fn sigma(&self, residuals: &[f64]) -> f64 {
        let squares: f64 = residuals.iter().map(|r| r * r).sum();
        (squares / self.trace).sqrt() / c4(self.nu)
    }

    /// This gain where it was made for windows of `n` samples, a fresh one otherwise.
    pub(super) fn at(&self, n: usize, residuals: impl Fn(&[f64]) -> Vec<f64>) -> Self {
        if n == self.n { *self } else { Self::of(n, residuals) }
    }

    /// Degrees of freedom.
    #[cfg(test)]
    pub(super) fn nu(&self) -> f64 {
        self.nu
    }
}

/// Residuals of a window.
type Residuals = Box<dyn Fn(&[f64]) -> Vec<f64> + Send + Sync>;

/// Sigma from the residuals that a linear map leaves of a window.
pub(crate) struct Linear {
    name: String,
    min_len: usize,
    map: Residuals,
    pub(super) gain: Gain,
}

impl Linear {
    /// `map` takes windows of `min_len` samples or more; `samples` is the length of those it will mostly be asked for.
    ///
    /// # Errors
    /// `samples` below `min_len`.
    pub(super) fn new(
        name: String,
        min_len: usize,
        samples: usize,
        map: impl Fn(&[f64]) -> Vec<f64> + Send + Sync + 'static,
    ) -> Result<Self, EstimatorError> {
        if samples < min_len {
            return Err(EstimatorError::WindowTooShort { name, needs: min_len, window: samples });
        }
        let gain = Gain::of(samples, &map);
        Ok(Self { name, min_len, map: Box::new(map), gain })
    }
}

impl WindowSigma for Linear {
    fn name(&self) -> &str {
        &self.name
    }

    fn min_len(&self) -> usize {
        self.min_len
    }

    fn sigma(&self, window: &[f64]) -> f64 {
        if window.len() < self.min_len {
            return f64::NAN;
        }
        self.gain.at(window.len(), &self.map).sigma(&(self.map)(window))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn c4_has_its_tabulated_values() {
        // Montgomery, Statistical Quality Control, appendix: c4 for samples of 2, 3, 5, 10, 25.
        for (n, published) in [(2.0, 0.7979), (3.0, 0.8862), (5.0, 0.9400), (10.0, 0.9727), (25.0, 0.9896)] {
            assert!((c4(n - 1.0) - published).abs() < 5e-5, "{n}");
        }
        // c4(1) = sqrt(2 / pi) exactly.
        assert!((c4(1.0) - (2.0 / std::f64::consts::PI).sqrt()).abs() < 1e-7);
    }

    #[test]
    fn a_long_windows_gain_is_that_of_its_pulses() {
        let filter = crate::signal::SavitzkyGolay::new(51, 3).expect("an odd window");
        let sg = |x: &[f64]| {
            let smooth = filter.smooth(x).expect("a window above the filter's");
            x.iter().zip(smooth).map(|(v, s)| v - s).collect::<Vec<f64>>()
        };
        let diff = |x: &[f64]| {
            let mut d = crate::signal::stats::differences(x, 2);
            let mean = crate::signal::stats::mean(&d);
            d.iter_mut().for_each(|v| *v -= mean);
            d
        };
        for n in [PULSES + 1, PULSES + 700] {
            for (long, pulses) in
                [(Gain::of(n, sg), Gain::by_pulses(n, sg)), (Gain::of(n, diff), Gain::by_pulses(n, diff))]
            {
                assert!((long.trace / pulses.trace - 1.0).abs() < 2e-6, "{long:?} {pulses:?}");
                assert!((long.nu / pulses.nu - 1.0).abs() < 1e-4, "{long:?} {pulses:?}");
            }
        }
    }

    #[test]
    fn demeaning_leaves_n_minus_one_degrees_of_freedom() {
        let demean = |x: &[f64]| {
            let mean = x.iter().sum::<f64>() / x.len() as f64;
            x.iter().map(|v| v - mean).collect()
        };
        let gain = Gain::of(20, demean);
        assert!((gain.nu - 19.0).abs() < 1e-10 && (gain.trace - 19.0).abs() < 1e-10);
    }
}
