//! Signal processing on one axis: smoothing, spectra, wavelets, window statistics.
//!
//! * `savitzky_golay`: polynomial smoothing with polynomial edges.
//! * [`spectrum`]: Welch's power spectral density, band power, peaks.
//! * [`periodogram`]: a long signal's spectrum in bands, lines left out.
//! * [`wavelet`]: detail coefficients of the finest level.
//! * [`ranks`]: medians and quantiles of numbers that are not held.
//! * [`LowPass`]: what sensors' filters let through.
//! * [`Blocks`]: a recording at a lower rate, as means over blocks.
//! * [`resample`]: the same behind a steep low pass.
//! * [`stats`]: moments, quantiles, median absolute deviation, differences.

mod blocks;
mod low_pass;
mod orthonormal;
pub mod periodogram;
pub mod ranks;
pub mod resample;
mod savitzky_golay;
pub mod spectrum;
pub mod stats;
pub mod wavelet;

pub use blocks::{BlockLength, Blocks, block_means};
pub use low_pass::{LowPass, Made};
pub use savitzky_golay::{FilterError, SavitzkyGolay};
pub use spectrum::{Peak, Spectrum, SpectrumError, Welch};
pub use wavelet::{Wavelet, finest_detail};
