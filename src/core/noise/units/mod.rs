//! Noise quantities, one type per meaning; a bare `f64` of noise crosses no crate's border.
//!
//! White noise of density `n` sampled at rate `f` has the deviation `sigma = n * sqrt(f)` per sample, the variance `sigma^2`, and the
//! power density `n^2`. A bias walk of density `w` adds, over a step of `1 / f`, an increment of deviation `w / sqrt(f)`; the bias then
//! changes at a rate that looks like white noise of deviation `w * sqrt(f)`. VINS-Mono's `acc_n`, `gyr_n` are per-sample
//! deviations; data sheets, Kalibr, OpenVINS and ORB-SLAM3 give densities (decision 24). What else a configuration may mean by a number is
//! [`Meaning`](super::Meaning).

mod quantity;
mod walk;
mod white;

pub use quantity::BadNoise;
pub(crate) use quantity::checked;
pub use walk::{AccelBiasRateStd, AccelBiasWalkDensity, GyroBiasRateStd, GyroBiasWalkDensity};
pub use white::{AccelNoiseDensity, AccelSampleStd, GyroNoiseDensity, GyroSampleStd};
