//! The seam: whatever says how noisy the IMU is implements [`NoiseModel`].

use super::ImuNoise;
use crate::imu::ImuSample;

/// A causal source of noise: fed the samples of a recording in order, it says the noise in force at each.
///
/// The answer at a sample may depend on that sample and on those before it, never on a later one: the track of a
/// recording cut anywhere equals the track of the whole recording up to there, bit for bit.
pub trait NoiseModel: Send {
    /// The noise spec that names this model, for example `"x1"` or `"diff2"`.
    fn name(&self) -> &str;

    /// Takes the next sample and returns the noise in force at it.
    fn feed(&mut self, sample: &ImuSample) -> ImuNoise;

    /// Forgets everything fed so far.
    fn reset(&mut self);
}

/// The same noise at every sample.
#[derive(Debug, Clone, PartialEq)]
pub struct Constant {
    name: String,
    noise: ImuNoise,
}

impl Constant {
    /// A constant called `name`.
    pub fn new(name: impl Into<String>, noise: ImuNoise) -> Self {
        Self { name: name.into(), noise }
    }
}

impl NoiseModel for Constant {
    fn name(&self) -> &str {
        &self.name
    }

    fn feed(&mut self, _sample: &ImuSample) -> ImuNoise {
        self.noise
    }

    fn reset(&mut self) {}
}
