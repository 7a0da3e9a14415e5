//! What follows a convolution: layer normalisation over channels and leaky ReLU, in either order, forth and back.

use super::conv::convolve_back;
use super::{add, leaky, slope};
use crate::plan::{Block, UNITS};
use cubecl::prelude::*;
use dpn_pronet::config::BlockOrder;
use dpn_pronet::definition::NORM_EPSILON;

/// Turns the numbers at the place of a block's output into its output; keeps in `far` those before gain and offset, or, where the ReLU comes first, those before
/// it.
#[cube]
pub(crate) fn finish(
    near: &mut [f32],
    far: &mut [f32],
    weights: &[f32],
    #[comptime] block: Block,
    #[comptime] leak: u32,
) {
    let (outputs, length) = comptime!((block.outputs, block.length));
    let first = comptime!(block.order == BlockOrder::ConvActNorm);
    if comptime!(block.norm) {
        let moments = comptime!(block.moments);
        let mut t = UNIT_POS as usize;
        while t < length {
            let row = comptime!(block.to) + t * comptime!(block.to_pitch);
            let mut mean = 0.0f32;
            for o in 0..outputs {
                mean += if first { leaky(near[row + o], leak) } else { near[row + o] };
            }
            mean /= comptime!(outputs as f32);
            let mut variance = 0.0f32;
            for o in 0..outputs {
                let value = if first { leaky(near[row + o], leak) } else { near[row + o] };
                variance += (value - mean) * (value - mean);
            }
            near[moments + t] = mean;
            near[moments + length + t] = 1.0 / (variance / comptime!(outputs as f32) + NORM_EPSILON).sqrt();
            t += UNITS;
        }
        sync_storage();
    }
    let mut item = UNIT_POS as usize;
    while item < comptime!(length * outputs) {
        let (t, o) = (item / outputs, item % outputs);
        let at = comptime!(block.to) + t * comptime!(block.to_pitch) + o;
        let value = near[at];
        if comptime!(block.norm) {
            let (mean, scale) =
                (near[comptime!(block.moments) + t], near[comptime!(block.moments) + length + t]);
            let (gain, offset) = (weights[comptime!(block.gain) + o], weights[comptime!(block.offset) + o]);
            if first {
                far[comptime!(block.kept) + item] = value;
                near[at] = gain * ((leaky(value, leak) - mean) * scale) + offset;
            } else {
                let normal = (value - mean) * scale;
                far[comptime!(block.kept) + item] = normal;
                near[at] = leaky(gain * normal + offset, leak);
            }
        } else {
            far[comptime!(block.kept) + item] = value;
            near[at] = leaky(value, leak);
        }
        item += UNITS;
    }
    sync_storage();
}

/// The normalised number that `kept` stands for.
#[cube]
fn normal(near: &mut [f32], kept: f32, t: usize, #[comptime] block: Block, #[comptime] leak: u32) -> f32 {
    if comptime!(block.order == BlockOrder::ConvActNorm) {
        let (mean, scale) =
            (near[comptime!(block.moments) + t], near[comptime!(block.moments + block.length) + t]);
        (leaky(kept, leak) - mean) * scale
    } else {
        kept
    }
}

/// From the gradient `d` of a block's output to that of what stands before the ReLU, where this comes last.
#[cube]
pub(crate) fn enter(
    weights: &[f32],
    kept: f32,
    d: f32,
    o: usize,
    #[comptime] block: Block,
    #[comptime] leak: u32,
) -> f32 {
    if comptime!(!block.norm) {
        d * slope(kept, leak)
    } else if comptime!(block.order == BlockOrder::ConvActNorm) {
        d
    } else {
        d * slope(weights[comptime!(block.gain) + o] * kept + weights[comptime!(block.offset) + o], leak)
    }
}

/// Writes the gradient of the output of `block`, which goes into `next`, to its place, as [`enter`] has it.
#[cube]
pub(crate) fn enter_from(
    near: &mut [f32],
    far: &mut [f32],
    weights: &[f32],
    turned: &[f32],
    #[comptime] block: Block,
    #[comptime] next: Block,
    #[comptime] leak: u32,
) {
    let outputs = comptime!(block.outputs);
    let mut item = UNIT_POS as usize;
    while item < comptime!(block.length * outputs) {
        let (t, o) = (item / outputs, item % outputs);
        let d = convolve_back(near, turned, t, o, next);
        let kept = far[comptime!(block.kept) + item];
        near[comptime!(block.to) + t * comptime!(block.to_pitch) + o] =
            enter(weights, kept, d, o, block, leak);
        item += UNITS;
    }
    sync_storage();
}

/// Adds the gradients of gains and offsets and turns the gradient of a block's output, as [`enter`] left it, into that of its convolution.
#[cube]
pub(crate) fn back(
    near: &mut [f32],
    far: &mut [f32],
    weights: &[f32],
    gradient: &mut [f32],
    first: bool,
    #[comptime] sums: usize,
    #[comptime] block: Block,
    #[comptime] leak: u32,
) {
    let (outputs, length) = comptime!((block.outputs, block.length));
    if comptime!(block.norm) {
        channel_sums(near, far, gradient, first, sums, block, leak, true);
        let mut t = UNIT_POS as usize;
        while t < length {
            let row = comptime!(block.to) + t * comptime!(block.to_pitch);
            let mut mean = 0.0f32;
            let mut along = 0.0f32;
            for o in 0..outputs {
                let d = near[row + o] * weights[comptime!(block.gain) + o];
                mean += d;
                along += d * normal(near, far[comptime!(block.kept) + t * outputs + o], t, block, leak);
            }
            near[sums + t] = mean / comptime!(outputs as f32);
            near[sums + length + t] = along / comptime!(outputs as f32);
            t += UNITS;
        }
        sync_storage();
        let mut item = UNIT_POS as usize;
        while item < comptime!(length * outputs) {
            let (t, o) = (item / outputs, item % outputs);
            let at = comptime!(block.to) + t * comptime!(block.to_pitch) + o;
            let kept = far[comptime!(block.kept) + item];
            let centred = near[at] * weights[comptime!(block.gain) + o]
                - near[sums + t]
                - normal(near, kept, t, block, leak) * near[sums + length + t];
            let d = centred * near[comptime!(block.moments + block.length) + t];
            near[at] =
                if comptime!(block.order == BlockOrder::ConvActNorm) { d * slope(kept, leak) } else { d };
            item += UNITS;
        }
        sync_storage();
    }
    if comptime!(block.bias.is_some()) {
        channel_sums(near, far, gradient, first, sums, block, leak, false);
    }
}

/// Adds sums over time of what stands at the place of a block's output: with `of_norm` to the gradients of offsets, and, times the normalised numbers, of gains;
/// else to those of biases. Segments of time are summed side by side and put together in order.
#[cube]
fn channel_sums(
    near: &mut [f32],
    far: &mut [f32],
    gradient: &mut [f32],
    first: bool,
    #[comptime] sums: usize,
    #[comptime] block: Block,
    #[comptime] leak: u32,
    #[comptime] of_norm: bool,
) {
    let (outputs, length) = comptime!((block.outputs, block.length));
    let segments = comptime!((UNITS / outputs).max(1));
    let size = comptime!(length.div_ceil(segments));
    let plain = comptime!(if of_norm { block.offset } else { block.bias.unwrap_or(0) });
    let mut item = UNIT_POS as usize;
    while item < comptime!(segments * outputs) {
        let (o, segment) = (item % outputs, item / outputs);
        let mut sum = 0.0f32;
        let mut along = 0.0f32;
        for t in segment * size..usize::min((segment + 1) * size, length) {
            let d = near[comptime!(block.to) + t * comptime!(block.to_pitch) + o];
            sum += d;
            if of_norm {
                along += d * normal(near, far[comptime!(block.kept) + t * outputs + o], t, block, leak);
            }
        }
        if comptime!(segments == 1) {
            add(gradient, plain + o, sum, first);
            if of_norm {
                add(gradient, comptime!(block.gain) + o, along, first);
            }
        } else {
            near[sums + item] = sum;
            near[sums + UNITS + item] = along;
        }
        item += UNITS;
    }
    sync_storage();
    if comptime!(segments > 1) {
        let o = UNIT_POS as usize;
        if o < outputs {
            let mut sum = 0.0f32;
            let mut along = 0.0f32;
            for segment in 0..segments {
                sum += near[sums + segment * outputs + o];
                along += near[sums + UNITS + segment * outputs + o];
            }
            add(gradient, plain + o, sum, first);
            if of_norm {
                add(gradient, comptime!(block.gain) + o, along, first);
            }
        }
        sync_storage();
    }
}
