//! What noise means here: one type per meaning, named conversions, and the seam every noise source implements.
//!
//! * [`units`]: deviations per sample, densities, bias walks; conversions between them.
//! * [`formats`]: the same as other programs write them.
//! * [`ImuNoise`]: the six per-axis deviations in force at one sample.
//! * [`NoiseModel`]: causal; fed one sample at a time, says the noise in force.
//! * [`NoiseTrack`]: a model's output over a recording.

pub mod formats;
mod imu_noise;
mod model;
mod track;
pub mod units;

pub use imu_noise::ImuNoise;
pub use model::{Constant, NoiseModel};
pub use track::{NoiseTrack, TrackError};
pub use units::{
    AccelBiasRateStd, AccelBiasWalkDensity, AccelNoiseDensity, AccelSampleStd, GyroBiasRateStd,
    GyroBiasWalkDensity, GyroNoiseDensity, GyroSampleStd,
};
