//! The last step: from the last layer's numbers to a deviation, and to how sure the network is of it, forth and back.

use crate::config::{Head, ProNetConfig};
use crate::definition::{LOG_SIGMA_RANGE, LOG_SPREAD_RANGE};

/// What turning the last numbers into an answer takes.
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

    /// Numbers of an answer.
    pub(crate) fn outputs(self) -> usize {
        self.head.outputs()
    }

    /// Writes the answer for the last numbers `z`: the deviation and, where the head has it, the deviation of its logarithm.
    ///
    /// # Shapes
    /// `z` and `answer`: `[outputs]` or more, and `[outputs]`.
    pub(crate) fn forward(self, z: &[f32], answer: &mut [f32]) {
        let positive = match self.head {
            // max(z, 0) + ln(1 + exp(-|z|)): no overflow.
            Head::Softplus => z[0].max(0.0) + (-z[0].abs()).exp().ln_1p(),
            Head::LeakyRelu => z[0].max(self.leak * z[0]),
            Head::LogSigma | Head::LogSigmaAndSpread => {
                z[0].clamp(LOG_SIGMA_RANGE.0, LOG_SIGMA_RANGE.1).exp()
            }
        };
        answer[0] = positive * self.unit;
        if let [_, spread] = answer {
            *spread = z[1].clamp(LOG_SPREAD_RANGE.0, LOG_SPREAD_RANGE.1).exp();
        }
    }

    /// Writes the gradient of `z` for the gradient `d` of the answer.
    ///
    /// # Shapes
    /// `z` and `d_z`: `[outputs]` or more; `d`: `[outputs]`.
    pub(crate) fn backward(self, z: &[f32], d: &[f32], d_z: &mut [f32]) {
        let exp_within = |z: f32, (low, high)| if (low..=high).contains(&z) { z.exp() } else { 0.0 };
        let slope = match self.head {
            Head::Softplus => 1.0 / (1.0 + (-z[0]).exp()),
            Head::LeakyRelu => {
                if z[0] > 0.0 {
                    1.0
                } else {
                    self.leak
                }
            }
            Head::LogSigma | Head::LogSigmaAndSpread => exp_within(z[0], LOG_SIGMA_RANGE),
        };
        d_z[0] = d[0] * slope * self.unit;
        if let [_, d_spread] = d {
            d_z[1] = d_spread * exp_within(z[1], LOG_SPREAD_RANGE);
        }
    }
}
