//! Savitzky-Golay smoothing: each output is a least-squares polynomial through its neighbours, taken at its place.
//!
//! For window `W` and order `P` let the columns of `Q` (`W` rows, `P + 1` columns) be orthonormal polynomials on the
//! window's abscissa. The fit at all `W` places is `H x` with `H = Q Q^T`. Inside the signal the middle row of `H`
//! slides along; the first and last `(W - 1) / 2` outputs are the other rows, applied to the first and last window:
//! scipy's `mode="interp"`. `Q` needs neither a Vandermonde matrix nor normal equations (`orthonormal.rs`), so that rows
//! stay good to rounding at any order.
//!
//! Source: Savitzky and Golay 1964; orthogonal form as in Press et al., Numerical Recipes, "Savitzky-Golay smoothing
//! filters". Not here: derivatives, uneven sampling.

use super::orthonormal::{dot, orthonormal_polynomials};
#[cfg(test)]
use std::f64::consts::TAU;
use thiserror::Error;

/// Why a filter cannot be made or applied.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum FilterError {
    /// A window of no samples.
    #[error("a filter window of 0 samples holds nothing; the smallest is 1")]
    EmptyWindow,
    /// A window without a middle.
    #[error(
        "a filter window must be odd, {window} is even; the nearest odd ones are {} and {}", window - 1, window + 1
    )]
    EvenWindow {
        /// The window asked for.
        window: usize,
    },
    /// A window whose rows would fill the memory.
    #[error("a filter window of {window} samples is too wide; at most {} are taken", SavitzkyGolay::WIDEST)]
    TooWide {
        /// The window asked for.
        window: usize,
    },
    /// A polynomial with as many coefficients as the window has samples, or more.
    #[error(
        "order {order} needs a window above {order} samples, this one has {window}; lower the order or widen the window"
    )]
    OrderTooHigh {
        /// The window asked for.
        window: usize,
        /// The order asked for.
        order: usize,
    },
    /// A signal that does not fill the window once.
    #[error(
        "{len} samples are fewer than the filter's window of {window}; use a narrower window or a longer signal"
    )]
    SignalTooShort {
        /// Length of the signal.
        len: usize,
        /// The filter's window.
        window: usize,
    },
    /// An output of another length than the input.
    #[error("the output holds {out} samples, the input {len}; they must be equal")]
    OutputLength {
        /// Length of the signal.
        len: usize,
        /// Length of the output.
        out: usize,
    },
}

/// A Savitzky-Golay filter with its rows computed once.
///
/// ```
/// use dpn_core::signal::SavitzkyGolay;
/// let filter = SavitzkyGolay::new(5, 2)?;
/// let parabola: Vec<f64> = (0..20).map(|i| f64::from(i * i)).collect();
/// let smooth = filter.smooth(&parabola)?;
/// assert!(parabola.iter().zip(&smooth).all(|(a, b)| (a - b).abs() < 1e-10));
/// # Ok::<(), dpn_core::signal::FilterError>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct SavitzkyGolay {
    window: usize,
    order: usize,
    /// Middle row of `H`: the sliding kernel, symmetric.
    kernel: Vec<f64>,
    /// Rows `0 .. half` of `H`, one after the other. The right edge uses them mirrored: `H` is centrosymmetric.
    edge_rows: Vec<f64>,
}

impl SavitzkyGolay {
    /// The widest window \[samples\]: the rows of its edges take 16 MB.
    pub const WIDEST: usize = 2001;

    /// The filter of `window` samples (odd, 1 to [`Self::WIDEST`]) and polynomial `order` (below `window`).
    ///
    /// # Errors
    /// An empty, even or too wide window; an order that the window cannot determine.
    pub fn new(window: usize, order: usize) -> Result<Self, FilterError> {
        if window == 0 {
            return Err(FilterError::EmptyWindow);
        }
        if window.is_multiple_of(2) {
            return Err(FilterError::EvenWindow { window });
        }
        if window > Self::WIDEST {
            return Err(FilterError::TooWide { window });
        }
        if order >= window {
            return Err(FilterError::OrderTooHigh { window, order });
        }
        let half = window / 2;
        let basis = orthonormal_polynomials(window, order);
        let row = |i: usize| (0..window).map(move |j| (i, j));
        let hat = |(i, j): (usize, usize)| basis.iter().map(|q| q[i] * q[j]).sum::<f64>();
        Ok(Self {
            window,
            order,
            kernel: row(half).map(hat).collect(),
            edge_rows: (0..half).flat_map(row).map(hat).collect(),
        })
    }

    /// Samples in the window.
    pub fn window(&self) -> usize {
        self.window
    }

    /// Smooths `x`, edges by the polynomial through the first and the last window.
    ///
    /// # Errors
    /// A signal shorter than the window.
    pub fn smooth(&self, x: &[f64]) -> Result<Vec<f64>, FilterError> {
        let mut out = vec![0.0; x.len()];
        self.smooth_into(x, &mut out)?;
        Ok(out)
    }

    /// As [`smooth`](Self::smooth), into `out` of the same length; allocates nothing.
    ///
    /// # Errors
    /// A signal shorter than the window; an output of another length.
    pub fn smooth_into(&self, x: &[f64], out: &mut [f64]) -> Result<(), FilterError> {
        let (len, window, half) = (x.len(), self.window, self.window / 2);
        if len < window {
            return Err(FilterError::SignalTooShort { len, window });
        }
        if out.len() != len {
            return Err(FilterError::OutputLength { len, out: out.len() });
        }
        let (first, last) = (&x[..window], &x[len - window..]);
        for (i, row) in self.edge_rows.chunks_exact(window).enumerate() {
            out[i] = dot(row.iter().zip(first));
            out[len - 1 - i] = dot(row.iter().zip(last.iter().rev()));
        }
        slide(&self.kernel, x, &mut out[half..len - half]);
        Ok(())
    }

    /// Root-mean-square gain of `x - smooth(x)` for white noise over a signal of `n` samples, edges included.
    ///
    /// Exact: every row `h` of `H` obeys `h . h = h_ii` (a projection), so its residual keeps `1 - h_ii` of the
    /// variance. Zero when the order is `window - 1`. NaN when `n` is below the window: there is no residual then.
    pub fn residual_gain(&self, n: usize) -> f64 {
        let (window, half) = (self.window, self.window / 2);
        if n < window {
            return f64::NAN;
        }
        if self.order + 1 == window {
            return 0.0; // the polynomial passes through every sample: what is left is rounding
        }
        let inside = (n - 2 * half) as f64 * (1.0 - self.kernel[half]);
        let edge: f64 = (0..half).map(|i| 1.0 - self.edge_rows[i * window + i]).sum();
        ((inside + 2.0 * edge) / n as f64).sqrt()
    }

    /// Amplitude response of the kernel at `cycles_per_sample` = frequency / rate, in \[0, 0.5\].
    ///
    /// Real (the kernel is symmetric), 1 at zero, may be negative in the stop band.
    #[cfg(test)]
    fn frequency_response(&self, cycles_per_sample: f64) -> f64 {
        let half = self.window / 2;
        let wings: f64 =
            (1..=half).map(|k| self.kernel[half + k] * (TAU * cycles_per_sample * k as f64).cos()).sum();
        self.kernel[half] + 2.0 * wings
    }
}

/// `out[i] = sum_j kernel[j] * x[i + j]`. Blocks of outputs keep their sums in registers; every output adds its
/// terms in the same order wherever it stands, so the result does not depend on the block.
fn slide(kernel: &[f64], x: &[f64], out: &mut [f64]) {
    const BLOCK: usize = 8;
    let mut blocks = out.chunks_exact_mut(BLOCK);
    let mut at = 0;
    for block in &mut blocks {
        let mut sums = [0.0; BLOCK];
        for (j, c) in kernel.iter().enumerate() {
            let from = &x[at + j..at + j + BLOCK];
            for (sum, v) in sums.iter_mut().zip(from) {
                *sum += c * v;
            }
        }
        block.copy_from_slice(&sums);
        at += BLOCK;
    }
    for (i, y) in blocks.into_remainder().iter_mut().enumerate() {
        *y = kernel.iter().zip(&x[at + i..]).fold(0.0, |sum, (c, v)| sum + c * v);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use serde::Deserialize;
    use std::collections::BTreeMap;

    #[derive(Deserialize)]
    struct Case {
        signal: String,
        window: usize,
        order: usize,
        expected: Vec<f64>,
    }

    #[derive(Deserialize)]
    struct Golden {
        signals: BTreeMap<String, Vec<f64>>,
        scipy: Vec<Case>,
        exact: Vec<Case>,
    }

    fn golden() -> Golden {
        dpn_testing::golden("savitzky_golay")
    }

    /// Largest error relative to the largest input.
    fn worst(golden: &Golden, case: &Case) -> f64 {
        let x = &golden.signals[&case.signal];
        let scale = x.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
        let got = SavitzkyGolay::new(case.window, case.order).unwrap().smooth(x).unwrap();
        assert_eq!(got.len(), case.expected.len());
        got.iter().zip(&case.expected).fold(0.0_f64, |m, (a, b)| m.max((a - b).abs() / scale))
    }

    #[test]
    fn smoothing_agrees_with_scipy_to_1e_12() {
        let golden = golden();
        for case in &golden.scipy {
            let error = worst(&golden, case);
            assert!(error < 1e-12, "{} ({},{}): {error:e}", case.signal, case.window, case.order);
        }
    }

    #[test]
    fn smoothing_agrees_with_rational_arithmetic_to_a_few_roundings_at_any_order() {
        let golden = golden();
        for case in &golden.exact {
            let error = worst(&golden, case);
            assert!(error < 5e-15, "{} ({},{}): {error:e}", case.signal, case.window, case.order);
        }
    }

    #[test]
    fn the_five_point_parabola_has_its_published_coefficients() {
        let filter = SavitzkyGolay::new(5, 2).unwrap();
        for (c, published) in filter.kernel.iter().zip([-3.0, 12.0, 17.0, 12.0, -3.0]) {
            assert!((c - published / 35.0).abs() < 1e-15);
        }
    }

    #[test]
    fn windows_without_a_middle_are_refused_by_the_names_of_their_neighbours() {
        let text = SavitzkyGolay::new(10, 2).unwrap_err().to_string();
        assert!(text.contains("9 and 11"), "{text}");
        assert_eq!(SavitzkyGolay::new(0, 0).unwrap_err(), FilterError::EmptyWindow);
        assert_eq!(SavitzkyGolay::new(999_999, 3).unwrap_err(), FilterError::TooWide { window: 999_999 });
        assert_eq!(SavitzkyGolay::new(5, 5).unwrap_err(), FilterError::OrderTooHigh { window: 5, order: 5 });
        let short = SavitzkyGolay::new(11, 2).unwrap().smooth(&[0.0; 10]).unwrap_err();
        assert_eq!(short, FilterError::SignalTooShort { len: 10, window: 11 });
    }

    #[test]
    fn the_residual_gain_is_the_norm_of_the_residual_map() {
        // Column by column: the residual of a unit pulse at each place is a column of I - S.
        for (window, order, n) in [(5, 2, 40), (11, 2, 200), (21, 3, 21), (51, 3, 60), (7, 6, 30), (1, 0, 9)]
        {
            let filter = SavitzkyGolay::new(window, order).unwrap();
            let mut sum = 0.0;
            for place in 0..n {
                let mut pulse = vec![0.0; n];
                pulse[place] = 1.0;
                let smooth = filter.smooth(&pulse).unwrap();
                sum += pulse.iter().zip(&smooth).map(|(a, b)| (a - b) * (a - b)).sum::<f64>();
            }
            let gain = (sum / n as f64).sqrt();
            assert!((filter.residual_gain(n) - gain).abs() < 1e-13, "({window},{order}) over {n}");
        }
        assert!(SavitzkyGolay::new(11, 2).unwrap().residual_gain(10).is_nan());
    }

    #[test]
    fn a_tone_inside_the_signal_is_scaled_by_the_frequency_response() {
        let filter = SavitzkyGolay::new(11, 2).unwrap();
        for f in [0.0, 0.03, 0.17, 0.465] {
            let x: Vec<f64> = (0..100).map(|i| (TAU * f * f64::from(i)).cos()).collect();
            let y = filter.smooth(&x).unwrap();
            for i in 5..95 {
                assert!((y[i] - filter.frequency_response(f) * x[i]).abs() < 1e-13, "f = {f}");
            }
        }
    }

    proptest! {
        #[test]
        fn a_polynomial_of_the_filters_order_passes_unchanged(
            half in 1_usize..20, extra in 0_usize..30, coefficients in prop::collection::vec(-1.0..1.0_f64, 1..6),
        ) {
            let window = 2 * half + 1;
            let order = coefficients.len() - 1;
            prop_assume!(order < window);
            let n = window + extra;
            let x: Vec<f64> = (0..n)
                .map(|i| coefficients.iter().rev().fold(0.0, |sum, c| sum * (i as f64 / n as f64) + c))
                .collect();
            let y = SavitzkyGolay::new(window, order).unwrap().smooth(&x).unwrap();
            for (a, b) in x.iter().zip(&y) {
                prop_assert!((a - b).abs() < 1e-12);
            }
        }

        #[test]
        fn reversing_the_signal_reverses_the_result(
            x in prop::collection::vec(-10.0..10.0_f64, 21..80),
        ) {
            let filter = SavitzkyGolay::new(21, 3).unwrap();
            let forward = filter.smooth(&x).unwrap();
            let reversed: Vec<f64> = x.iter().rev().copied().collect();
            let back = filter.smooth(&reversed).unwrap();
            for (a, b) in forward.iter().zip(back.iter().rev()) {
                prop_assert!((a - b).abs() < 1e-13 * 10.0);
            }
        }
    }
}
