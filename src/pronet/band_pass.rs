//! First kernels that make the network begin as a bank of band-pass filters over the window itself.
//!
//! Filter `i` of `n` is a Hann-windowed cosine of `f = .03 + .47 (i + 1/2) / n` cycles a sample with a random phase, and of unit
//! length: white noise of deviation one comes out with deviation one. Where the first convolution sees differences of the window, kernel and
//! differences together shall be that cosine; a kernel so short can be so only in the least-squares sense (with a ridge of 1e-4, because
//! differences remove slow parts that the kernel would need large numbers to restore), and is scaled to unit length of the two
//! together.

use crate::config::{Input, ProNetConfig};
use dpn_core::random::Stream;
use nalgebra::{DMatrix, DVector};
use rand::Rng;
use std::f64::consts::{PI, TAU};

/// Frequencies the bank covers \[cycles a sample\].
const BAND: (f64, f64) = (0.03, 0.5);
/// Near the band's ends a cosine's phase would change its length: there it is zero.
const FREE_PHASE: (f64, f64) = (0.02, 0.48);
const RIDGE: f64 = 1e-4;

/// The first convolution's weights, `[channels, 1, kernel]` row by row.
pub(crate) fn band_pass_kernels(config: &ProNetConfig, stream: &Stream) -> Vec<f32> {
    let (channels, kernel) = (config.channels[0], config.kernels[0]);
    let before = differences(config.input);
    let long = kernel + before.len() - 1;
    // Kernel and differences together: column `j` holds the differences of tap `j` alone.
    let together = DMatrix::from_fn(long, kernel, |row, column| {
        row.checked_sub(column).and_then(|i| before.get(i)).copied().unwrap_or(0.0)
    });
    let normal = together.transpose() * &together + DMatrix::identity(kernel, kernel) * RIDGE;
    let mut flat = vec![0.0; channels * kernel];
    let solver = normal.cholesky().expect("positive definite by the ridge");
    for (i, out) in flat.chunks_exact_mut(kernel).enumerate() {
        let f = BAND.0 + (BAND.1 - BAND.0) * (i as f64 + 0.5) / channels as f64;
        let free = FREE_PHASE.0 < f && f < FREE_PHASE.1;
        let phase = if free { stream.index(i as u64).rng().random::<f64>() * TAU } else { 0.0 };
        let middle = (long - 1) as f64 / 2.0;
        let cosine = DVector::from_fn(long, |t, _| {
            let hann = 0.5 - 0.5 * (TAU * (t + 1) as f64 / (long + 1) as f64).cos();
            hann * (2.0 * PI * f * (t as f64 - middle) + phase).cos()
        });
        let taps = solver.solve(&(together.transpose() * cosine.normalize()));
        let length = (&together * &taps).norm();
        // A convolution layer correlates: its first weight meets the oldest sample.
        for (weight, tap) in out.iter_mut().zip(taps.iter().rev()) {
            *weight = (tap / length) as f32;
        }
    }
    flat
}

/// What was done to the window before, newest sample's factor first.
fn differences(input: Input) -> &'static [f64] {
    match input {
        Input::Demeaned | Input::Raw => &[1.0],
        Input::SecondDifferences => &[1.0, -2.0, 1.0],
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every kernel with the differences before it, newest sample's factor first.
    fn together(config: &ProNetConfig) -> Vec<Vec<f64>> {
        let kernel = config.kernels[0];
        band_pass_kernels(config, &Stream::new(1))
            .chunks_exact(kernel)
            .map(|w| {
                let taps: Vec<f64> = w.iter().rev().map(|v| f64::from(*v)).collect();
                let before = differences(config.input);
                let mut out = vec![0.0; kernel + before.len() - 1];
                for (j, tap) in taps.iter().enumerate() {
                    for (i, b) in before.iter().enumerate() {
                        out[i + j] += tap * b;
                    }
                }
                out
            })
            .collect()
    }

    fn gain(filter: &[f64], f: f64) -> f64 {
        let part = |g: fn(f64) -> f64| {
            filter.iter().enumerate().map(|(t, v)| v * g(TAU * f * t as f64)).sum::<f64>()
        };
        part(f64::cos).hypot(part(f64::sin))
    }

    #[test]
    fn every_filter_has_unit_gain_on_white_noise_and_peaks_in_its_band() {
        for input in Input::ALL {
            let config = ProNetConfig {
                input,
                channels: vec![16],
                kernels: vec![41],
                strides: vec![1],
                paddings: vec![0],
                ..ProNetConfig::default()
            };
            for (i, filter) in together(&config).iter().enumerate() {
                let energy: f64 = filter.iter().map(|v| v * v).sum();
                assert!((energy - 1.0).abs() < 1e-5, "{input} {i}: {energy}");
                let centre = 0.03 + 0.47 * (i as f64 + 0.5) / 16.0;
                let peak = (0..=500)
                    .map(|k| f64::from(k) * 1e-3)
                    .max_by(|a, b| gain(filter, *a).total_cmp(&gain(filter, *b)));
                // The Hann window of 43 samples is 2 / 43 cycles a sample wide on either side.
                assert!((peak.unwrap() - centre).abs() < 0.02, "{input} {i}: {peak:?} {centre}");
            }
        }
    }
}
