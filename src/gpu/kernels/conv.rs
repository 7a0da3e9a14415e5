//! Convolutions over time, forth and back.

use super::add;
use crate::plan::{Block, TILE, UNITS};
use cubecl::prelude::*;

/// Writes a block's convolution to the place of its output.
#[cube]
pub(crate) fn convolve(near: &mut [f32], weights: &[f32], #[comptime] block: Block) {
    let outputs = comptime!(block.outputs);
    let tiles = comptime!(block.length.div_ceil(TILE));
    let mut item = UNIT_POS as usize;
    while item < comptime!(outputs * tiles) {
        let (o, from) = (item % outputs, (item / outputs) * TILE);
        let mut sums = Array::<f32>::new(TILE);
        if comptime!(block.bias.is_some()) {
            let bias = weights[comptime!(block.bias.unwrap_or(0)) + o];
            #[unroll]
            for j in 0..TILE {
                sums[j] = bias;
            }
        }
        let mut weight = comptime!(block.weight) + o;
        let first = comptime!(block.from) + from * comptime!(block.stride * block.from_pitch);
        for c in 0..comptime!(block.inputs) {
            let mut at = first + c;
            for _ in 0..comptime!(block.kernel) {
                let w = weights[weight];
                #[unroll]
                for j in 0..TILE {
                    sums[j] += w * near[at + j * comptime!(block.stride * block.from_pitch)];
                }
                weight += outputs;
                at += comptime!(block.from_pitch);
            }
        }
        #[unroll]
        for j in 0..TILE {
            if from + j < comptime!(block.length) {
                near[comptime!(block.to) + (from + j) * comptime!(block.to_pitch) + o] = sums[j];
            }
        }
        item += UNITS;
    }
    sync_storage();
}

/// Adds a block's gradients with respect to its kernel; the gradient of its convolution stands at the place of its output.
#[cube]
pub(crate) fn convolve_weights(
    near: &mut [f32],
    gradient: &mut [f32],
    first: bool,
    #[comptime] block: Block,
) {
    let outputs = comptime!(block.outputs);
    let rows = comptime!(block.inputs * block.kernel);
    let tiles = comptime!(rows.div_ceil(TILE));
    let mut item = UNIT_POS as usize;
    while item < comptime!(outputs * tiles) {
        let (o, from) = (item % outputs, (item / outputs) * TILE);
        let mut sums = Array::<f32>::new(TILE);
        let mut places = Array::<usize>::new(TILE);
        #[unroll]
        for j in 0..TILE {
            let row = usize::min(from + j, rows - 1);
            let (c, k) = (row / comptime!(block.kernel), row % comptime!(block.kernel));
            places[j] = comptime!(block.from) + k * comptime!(block.from_pitch) + c;
        }
        for t in 0..comptime!(block.length) {
            let d = near[comptime!(block.to) + t * comptime!(block.to_pitch) + o];
            let step = t * comptime!(block.stride * block.from_pitch);
            #[unroll]
            for j in 0..TILE {
                sums[j] += d * near[places[j] + step];
            }
        }
        #[unroll]
        for j in 0..TILE {
            if from + j < rows {
                add(gradient, comptime!(block.weight) + (from + j) * outputs + o, sums[j], first);
            }
        }
        item += UNITS;
    }
    sync_storage();
}

/// The gradient of a block's input at time step `t` and channel `c`.
#[cube]
pub(crate) fn convolve_back(
    near: &mut [f32],
    turned: &[f32],
    t: usize,
    c: usize,
    #[comptime] block: Block,
) -> f32 {
    let (stride, outputs) = comptime!((block.stride, block.outputs));
    let at = t + comptime!(block.padding);
    let (whole, phase) = (at / stride, at % stride);
    let mut sum = 0.0f32;
    if phase < comptime!(block.kernel) {
        let last = usize::min(whole, (comptime!(block.kernel - 1) - phase) / stride);
        let skipped = select(whole < comptime!(block.length), 0usize, whole - comptime!(block.length - 1));
        let mut j = skipped;
        while j <= last {
            let mut weight =
                comptime!(block.weight) + (phase + j * stride) * comptime!(outputs * block.inputs) + c;
            let d = comptime!(block.to) + (whole - j) * comptime!(block.to_pitch);
            for o in 0..outputs {
                sum += near[d + o] * turned[weight];
                weight += comptime!(block.inputs);
            }
            j += 1;
        }
    }
    sum
}
