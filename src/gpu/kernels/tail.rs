//! Behind the last block: pooling over time, linear layers, the head and the loss, forth and back.

use super::norm::enter;
use super::{add, leaky, slope};
use crate::plan::{Linear, Plan, UNITS};
use cubecl::prelude::*;
use dpn_pronet::config::{Head, Pool};
use dpn_pronet::definition::{LOG_SIGMA_RANGE, LOG_SPREAD_RANGE, POOL_EPSILON};

/// What is minimised, as `dpn_train`'s configuration says it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Loss {
    /// Mean square error in units of the output scale.
    Mse,
    /// Mean square error of the logarithm.
    LogMse,
    /// What a normal law of the logarithm is worth, whose deviation the network says too.
    LogNll,
}

/// Features of the last block's channels.
#[cube]
pub(crate) fn pool(near: &mut [f32], #[comptime] plan: Plan) {
    let block = comptime!(*plan.blocks.last().expect("a network has a block"));
    let to = comptime!(plan.linears[0].from);
    let mut c = UNIT_POS as usize;
    while c < comptime!(block.outputs) {
        let mut sum = 0.0f32;
        let mut squares = 0.0f32;
        for t in 0..comptime!(block.length) {
            let value = near[comptime!(block.to) + t * comptime!(block.to_pitch) + c];
            sum += value;
            squares += value * value;
        }
        let each = comptime!(1.0 / block.length as f32);
        match comptime!(plan.pool) {
            Pool::Mean => near[to + c] = sum * each,
            Pool::LogRms => near[to + c] = 0.5 * (squares * each + POOL_EPSILON).ln(),
            Pool::MeanAndRms => {
                near[to + c] = sum * each;
                near[to + comptime!(block.outputs) + c] = (squares * each + POOL_EPSILON).sqrt();
            }
        }
        c += UNITS;
    }
    sync_storage();
}

/// From the gradient of the features to that of the last block's output, as [`enter`] has it.
#[cube]
pub(crate) fn pool_back(near: &mut [f32], far: &mut [f32], weights: &[f32], #[comptime] plan: Plan) {
    let block = comptime!(*plan.blocks.last().expect("a network has a block"));
    let (features, d_features) = comptime!((plan.linears[0].from, plan.d_features));
    let outputs = comptime!(block.outputs);
    let each = comptime!(1.0 / block.length as f32);
    let mut item = UNIT_POS as usize;
    while item < comptime!(block.length * outputs) {
        let (t, c) = (item / outputs, item % outputs);
        let at = comptime!(block.to) + t * comptime!(block.to_pitch) + c;
        let share = near[d_features + c] * each;
        let d: f32 = match comptime!(plan.pool) {
            Pool::Mean => share,
            // The mean square is exp(2 feature).
            Pool::LogRms => {
                let square = near[features + c] + near[features + c];
                share * near[at] / square.exp()
            }
            Pool::MeanAndRms => {
                share + near[d_features + outputs + c] * each * near[at] / near[features + outputs + c]
            }
        };
        near[at] = enter(weights, far[comptime!(block.kept) + item], d, c, block, plan.leak);
        item += UNITS;
    }
    sync_storage();
}

/// One linear layer.
#[cube]
pub(crate) fn linear(near: &mut [f32], weights: &[f32], #[comptime] layer: Linear, #[comptime] leak: u32) {
    let mut o = UNIT_POS as usize;
    while o < comptime!(layer.outputs) {
        let mut sum = weights[comptime!(layer.bias) + o];
        let mut weight = comptime!(layer.weight) + o;
        for i in 0..comptime!(layer.inputs) {
            sum += weights[weight] * near[comptime!(layer.from) + i];
            weight += comptime!(layer.outputs);
        }
        near[comptime!(layer.to) + o] = if comptime!(layer.leaky) { leaky(sum, leak) } else { sum };
        o += UNITS;
    }
    sync_storage();
}

/// Adds the gradients of a linear layer, whose outputs' gradients stand at their place, and writes those of its inputs to theirs, or, of the first layer, to the
/// features'.
#[cube]
pub(crate) fn linear_back(
    near: &mut [f32],
    turned: &[f32],
    gradient: &mut [f32],
    first: bool,
    #[comptime] layer: Linear,
    #[comptime] features: Option<usize>,
    #[comptime] leak: u32,
) {
    let (inputs, outputs) = comptime!((layer.inputs, layer.outputs));
    let mut item = UNIT_POS as usize;
    while item < comptime!(inputs * outputs) {
        let value = near[comptime!(layer.from) + item / outputs] * near[comptime!(layer.to) + item % outputs];
        add(gradient, comptime!(layer.weight) + item, value, first);
        item += UNITS;
    }
    let mut o = UNIT_POS as usize;
    while o < outputs {
        add(gradient, comptime!(layer.bias) + o, near[comptime!(layer.to) + o], first);
        o += UNITS;
    }
    sync_storage();
    let mut i = UNIT_POS as usize;
    while i < inputs {
        let mut sum = 0.0f32;
        for o in 0..outputs {
            sum += turned[comptime!(layer.weight) + o * inputs + i] * near[comptime!(layer.to) + o];
        }
        if comptime!(features.is_some()) {
            near[comptime!(features.unwrap_or(0)) + i] = sum;
        } else {
            // A leaky ReLU keeps the sign of what goes in.
            let at = comptime!(layer.from) + i;
            near[at] = sum * slope(near[at], leak);
        }
        i += UNITS;
    }
    sync_storage();
}

/// The answer of the last layer's numbers: the deviation, in units of `unit`.
#[cube]
pub(crate) fn sigma(z: f32, unit: f32, #[comptime] head: Head, #[comptime] leak: u32) -> f32 {
    let positive = match head {
        // No overflow.
        Head::Softplus => f32::max(z, 0.0) + (1.0 + (-z.abs()).exp()).ln(),
        Head::LeakyRelu => leaky(z, leak),
        Head::LogSigma | Head::LogSigmaAndSpread => {
            clamp(z, comptime!(LOG_SIGMA_RANGE.0), comptime!(LOG_SIGMA_RANGE.1)).exp()
        }
    };
    positive * unit
}

/// The second answer, how sure the network is of the first.
#[cube]
pub(crate) fn spread(z: f32) -> f32 {
    clamp(z, comptime!(LOG_SPREAD_RANGE.0), comptime!(LOG_SPREAD_RANGE.1)).exp()
}

/// Puts the gradient of the mean loss over `1 / share` windows in place of the last layer's numbers and returns this window's loss, as `dpn_train`'s losses have it.
#[cube]
#[allow(unused_assignments, reason = "one arm is left once the kernel is compiled")]
pub(crate) fn loss(
    near: &mut [f32],
    label: f32,
    unit: f32,
    share: f32,
    #[comptime] at: usize,
    #[comptime] loss: Loss,
    #[comptime] head: Head,
    #[comptime] leak: u32,
) -> f32 {
    let z = near[at];
    let sigma = sigma(z, unit, head, leak);
    let mut value = 0.0f32;
    let mut d = 0.0f32;
    match loss {
        Loss::Mse => {
            let error = (sigma - label) / unit;
            d = 2.0 * (share * error) * (1.0 / unit);
            value = error * error;
        }
        Loss::LogMse => {
            let floor = 1e-3 * unit;
            let error = f32::max(sigma, floor).ln() - label.ln();
            d = select(sigma < floor, 0.0f32, 2.0 * (share * error) * (1.0 / sigma));
            value = error * error;
        }
        Loss::LogNll => {
            let spread = spread(near[at + 1]);
            let error = sigma.ln() - label.ln();
            let ratio = error / spread;
            d = share * ratio / spread / sigma;
            let inside = near[at + 1] >= comptime!(LOG_SPREAD_RANGE.0)
                && near[at + 1] <= comptime!(LOG_SPREAD_RANGE.1);
            near[at + 1] = select(inside, share - share * ratio * ratio, 0.0f32);
            value = 0.5 * (ratio * ratio) + spread.ln();
        }
    }
    let slope = match head {
        Head::Softplus => 1.0 / (1.0 + (-z).exp()),
        Head::LeakyRelu => slope(z, leak),
        Head::LogSigma | Head::LogSigmaAndSpread => {
            let inside = z >= comptime!(LOG_SIGMA_RANGE.0) && z <= comptime!(LOG_SIGMA_RANGE.1);
            select(inside, z.exp(), 0.0f32)
        }
    };
    near[at] = d * slope * unit;
    value
}
