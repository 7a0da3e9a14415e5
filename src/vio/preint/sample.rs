//! A reading with its noise.

use dpn_core::{ImuNoise, ImuSample};

/// One sample with the noise in force.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NoisySample {
    /// The reading.
    pub sample: ImuSample,
    /// Its deviations, per axis and per sample.
    pub noise: ImuNoise,
}
