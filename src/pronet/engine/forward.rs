//! The forward pass over a chunk of windows.

use super::chunk::{Arithmetic, Chunk};
use super::kernel::{Rows, multiply};
use super::norm;
use super::plan::LANE;
use super::pool::pool_forward;
use pulp::{Simd, WithSimd};

/// The forward pass over a chunk's windows.
pub(crate) struct Forward<'a> {
    pub(crate) of: &'a Arithmetic,
    pub(crate) packed: &'a [f32],
    /// `[count, window]`, the sensor's unit.
    pub(crate) windows: &'a [f32],
    pub(crate) keep: bool,
    pub(crate) chunk: &'a mut Chunk,
    /// `[count, outputs]`: a deviation in the sensor's unit, and what else the head says.
    pub(crate) answers: &'a mut [f32],
}

impl WithSimd for Forward<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { of, packed, windows, keep, chunk, answers } = self;
        let plan = &of.plan;
        let features_width = plan.linears[0].width_in;
        for (i, window) in windows.chunks_exact(of.window).enumerate() {
            let slot = if keep { i * plan.saved_len } else { 0 };
            let saved = &mut chunk.saved[slot..slot + plan.saved_len];
            let features = &mut chunk.levels[0][i * features_width..(i + 1) * features_width];
            window_forward(simd, of, packed, window, &mut chunk.scratch, saved, features);
        }
        let count = windows.len() / of.window;
        let last = plan.linears.len() - 1;
        let leak = of.norm.leak;
        for (l, linear) in plan.linears.iter().enumerate() {
            let (before, after) = chunk.levels.split_at_mut(l + 1);
            let rows = Rows { data: &before[l], stride: linear.width_in, count };
            let bias = &packed[linear.bias..linear.bias + linear.width_out];
            multiply(simd, rows, packed, &linear.weights, Some(bias), &mut after[0], linear.width_out);
            if l < last {
                for v in after[0].iter_mut() {
                    *v = v.max(leak * *v);
                }
            }
        }
        for (z, answer) in
            chunk.levels[last + 1].chunks_exact(LANE).zip(answers.chunks_exact_mut(of.head.outputs()))
        {
            of.head.forward(z, answer);
        }
    }
}

/// One window from its samples to its pooled features.
#[inline(always)]
fn window_forward<S: Simd>(
    simd: S,
    of: &Arithmetic,
    packed: &[f32],
    window: &[f32],
    scratch: &mut [f32],
    saved: &mut [f32],
    features: &mut [f32],
) {
    let plan = &of.plan;
    let first = &plan.blocks[0];
    of.preparation.run(
        window,
        scratch,
        &mut saved[..first.saved_conv][first.saved_input..][..first.input_len()],
    );
    for (b, block) in plan.blocks.iter().enumerate() {
        let (input, rest) = saved.split_at_mut(block.saved_conv);
        let rows = Rows {
            data: &input[block.saved_input..][..block.input_len()],
            stride: block.stride * block.width_in,
            count: block.time_out,
        };
        let out_len = block.time_out * block.width_out;
        let (conv, rest) = rest.split_at_mut(block.saved_stats - block.saved_conv);
        let bias = &packed[block.bias..block.bias + block.width_out];
        multiply(simd, rows, packed, &block.weights, Some(bias), conv, block.width_out);
        // What follows the statistics is the next block's padded input, or the last block's output.
        let next = match plan.blocks.get(b + 1) {
            Some(next) => next.saved_input + next.padding * next.width_in,
            None => plan.saved_last,
        };
        let (stats, rest) = rest.split_at_mut(next - block.saved_stats);
        norm::forward(simd, of.norm, block, packed, &conv[..out_len], stats, &mut rest[..out_len]);
    }
    let last = plan.blocks.last().expect("a network has a block");
    let out = &saved[plan.saved_last..][..last.time_out * last.width_out];
    pool_forward(simd, of.pool, last, out, features);
}
