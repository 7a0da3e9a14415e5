//! Median of the finest wavelet coefficients.

use super::WindowSigma;
use crate::signal::stats::{MAD_TO_SIGMA, median_in_place};
use crate::signal::{Wavelet, finest_detail};

/// Relative excess of the median of `n` absolute normal values over its limit, times `n`.
///
/// Second order of a sample quantile: `Q''(1/2) / (8 q n)` with the half-normal's `Q''(1/2) = q / (4 phi(q)^2)` at
/// `q = .6745`, that is `1 / (32 phi(q)^2)`; checked in `golden/mad_bias`.
pub(super) const EXCESS: f64 = 0.3094;

/// `wavelet(haar|db2|db4)`: median of the absolute finest details, over .6745 (Donoho and Johnstone).
///
/// Takes for noise the upper half of the spectrum, from a quarter of the rate on, with db4's sharper edge letting
/// less motion in than Haar's. Up to half of the coefficients may be anything. Fooled by vibration above a quarter of
/// the rate: its coefficients are not normal, so a tone near Nyquist counts 2.1 times its deviation.
#[derive(Debug, Clone)]
pub(crate) struct WaveletMad {
    name: String,
    wavelet: Wavelet,
}

impl WaveletMad {
    /// With the family `wavelet`.
    pub(crate) fn new(wavelet: Wavelet) -> Self {
        Self { name: format!("wavelet({})", wavelet.name()), wavelet }
    }
}

impl WindowSigma for WaveletMad {
    fn name(&self) -> &str {
        &self.name
    }

    fn min_len(&self) -> usize {
        self.wavelet.scaling().len()
    }

    fn sigma(&self, window: &[f64]) -> f64 {
        let mut detail = finest_detail(window, self.wavelet);
        detail.iter_mut().for_each(|d| *d = d.abs());
        let n = detail.len() as f64;
        // NaN where there is no coefficient: the median says so.
        MAD_TO_SIGMA * median_in_place(&mut detail) / (1.0 + EXCESS / n)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;

    #[test]
    fn a_tone_near_nyquist_counts_as_the_opening_text_says() {
        let x: Vec<f64> = (0..4000).map(|i| 2f64.sqrt() * (TAU * 0.4871 * f64::from(i)).sin()).collect();
        for wavelet in Wavelet::ALL {
            let sigma = WaveletMad::new(wavelet).sigma(&x);
            assert!((sigma - 2.1).abs() < 0.05, "{}: {sigma}", wavelet.name());
        }
    }
}
