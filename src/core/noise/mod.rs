//! What noise means here: one type per meaning, named conversions, and the seam every noise source implements.
//!
//! * [`units`]: deviations per sample, densities, bias walks; conversions between them.
//! * [`ImuFigures`]: the four noise parameters of a data sheet or an Allan plot.
//! * [`ImuNoise`]: the six per-axis deviations in force at one sample.
//! * [`NoiseModel`]: causal; fed one sample at a time, says the noise in force.
//! * [`NoiseTrack`]: a model's output over a recording.

mod figures;
mod imu_noise;
mod interval;
mod meaning;
mod model;
mod track;
pub mod units;

pub use figures::{Axes, Figure, ImuFigures};
pub use imu_noise::ImuNoise;
pub use interval::Interval;
pub use meaning::Meaning;
pub use model::{Constant, NoiseModel};
pub use track::{NoiseTrack, TrackError};
pub use units::{
    AccelBiasRateStd, AccelBiasWalkDensity, AccelNoiseDensity, AccelSampleStd, GyroBiasRateStd,
    GyroBiasWalkDensity, GyroNoiseDensity, GyroSampleStd,
};
