//! The last step: from the last layer's number to a deviation, forth and back.

use crate::config::{Head, ProNetConfig};
use crate::definition::LOG_SIGMA_RANGE;

/// What turning the last number into a deviation takes.
#[derive(Debug, Clone, Copy)]
pub(crate) struct HeadKind {
    head: Head,
    leak: f32,
    unit: f32,
}

impl HeadKind {
    pub(crate) fn new(config: &ProNetConfig) -> Self {
        Self { head: config.head, leak: config.leak as f32, unit: config.output_scale() as f32 }
    }

    /// The deviation for the last number `z`.
    pub(crate) fn forward(self, z: f32) -> f32 {
        let positive = match self.head {
            // max(z, 0) + ln(1 + exp(-|z|)): no overflow.
            Head::Softplus => z.max(0.0) + (-z.abs()).exp().ln_1p(),
            Head::LeakyRelu => z.max(self.leak * z),
            Head::Linear => z,
            Head::LogSigma => z.clamp(LOG_SIGMA_RANGE.0, LOG_SIGMA_RANGE.1).exp(),
        };
        positive * self.unit
    }

    /// The gradient of `z` for the gradient `d` of the deviation.
    pub(crate) fn backward(self, z: f32, d: f32) -> f32 {
        let slope = match self.head {
            Head::Softplus => 1.0 / (1.0 + (-z).exp()),
            Head::LeakyRelu => {
                if z > 0.0 {
                    1.0
                } else {
                    self.leak
                }
            }
            Head::Linear => 1.0,
            Head::LogSigma if (LOG_SIGMA_RANGE.0..=LOG_SIGMA_RANGE.1).contains(&z) => z.exp(),
            Head::LogSigma => 0.0,
        };
        d * slope * self.unit
    }
}
