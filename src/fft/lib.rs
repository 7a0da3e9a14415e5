//! The forward Fourier transform of `f64`, by `rustfft`.
//!
//! rustfft is generic over its numbers, so whoever plans a transform compiles all of it, for every width of vectors: half of `dpn-core`, and again in its
//! tests. Here it is compiled once.

pub use rustfft::Fft;
pub use rustfft::num_complex::Complex;
use std::sync::Arc;

/// The forward transform of `length` values, unscaled: X\[k\] = sum over n of x\[n\] exp(-2 pi i k n / length).
#[must_use]
pub fn forward(length: usize) -> Arc<dyn Fft<f64>> {
    rustfft::FftPlanner::new().plan_fft_forward(length)
}
