//! A chunk of windows, forth and back, on one thread.

use super::buffer::{Buffer, zeros};
use super::head::HeadKind;
use super::input::Preparation;
use super::kernel::{Rows, accumulate, add_row, multiply};
use super::norm::{self, NormKind, Sums};
use super::plan::{BlockPlan, LANE, Plan};
use crate::config::Pool;
use crate::module::POOL_EPSILON;
use pulp::{Simd, WithSimd};

/// What a forward pass needs besides the weights.
#[derive(Debug, Clone)]
pub(crate) struct Arithmetic {
    pub(crate) plan: Plan,
    pub(crate) preparation: Preparation,
    pub(crate) norm: NormKind,
    pub(crate) head: HeadKind,
    pub(crate) pool: Pool,
    pub(crate) window: usize,
}

/// What a forward pass over a chunk leaves behind for the backward pass.
#[derive(Debug, Clone, Default)]
pub(crate) struct Chunk {
    count: usize,
    saved: Buffer,
    /// Features, then every linear layer's output (after its leaky ReLU): `[count, width]` each.
    levels: Vec<Buffer>,
    scales: Vec<f32>,
    scratch: Vec<f32>,
}

impl Chunk {
    /// Makes room for `count` windows; `keep` says whether each window keeps what the backward pass needs.
    pub(crate) fn fit(&mut self, of: &Arithmetic, count: usize, keep: bool) {
        let plan = &of.plan;
        let slots = if keep { count } else { 1 };
        let room = slots * plan.saved_len;
        if self.saved.len() < room {
            // Time paddings inside are zero here and are never written.
            self.saved = zeros(room);
        }
        if self.count != count || self.levels.is_empty() {
            let widths = plan.linears.iter().map(|l| l.width_out);
            let first = plan.linears[0].width_in;
            self.levels = std::iter::once(first).chain(widths).map(|w| zeros(count * w)).collect();
            self.scales = vec![1.0; count];
            self.scratch = vec![0.0; of.window];
            self.count = count;
        }
    }
}

/// The forward pass over a chunk's windows.
pub(crate) struct Forward<'a> {
    pub(crate) of: &'a Arithmetic,
    pub(crate) packed: &'a [f32],
    /// `[count, window]`, the sensor's unit.
    pub(crate) windows: &'a [f32],
    pub(crate) keep: bool,
    pub(crate) chunk: &'a mut Chunk,
    /// `[count]`, the sensor's unit.
    pub(crate) sigma: &'a mut [f32],
}

impl WithSimd for Forward<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { of, packed, windows, keep, chunk, sigma } = self;
        let plan = &of.plan;
        let features_width = plan.linears[0].width_in;
        for (i, window) in windows.chunks_exact(of.window).enumerate() {
            let slot = if keep { i * plan.saved_len } else { 0 };
            let saved = &mut chunk.saved[slot..slot + plan.saved_len];
            let features = &mut chunk.levels[0][i * features_width..(i + 1) * features_width];
            chunk.scales[i] = window_forward(simd, of, packed, window, &mut chunk.scratch, saved, features);
        }
        let count = sigma.len();
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
        for (i, s) in sigma.iter_mut().enumerate() {
            *s = of.head.forward(chunk.levels[last + 1][i * LANE], chunk.scales[i]);
        }
    }
}

/// One window from its samples to its pooled features; returns its own scale.
#[inline(always)]
fn window_forward<S: Simd>(
    simd: S,
    of: &Arithmetic,
    packed: &[f32],
    window: &[f32],
    scratch: &mut [f32],
    saved: &mut [f32],
    features: &mut [f32],
) -> f32 {
    let plan = &of.plan;
    let first = &plan.blocks[0];
    let scale = of.preparation.run(
        window,
        scratch,
        &mut saved[..first.saved_conv][first.saved_input..][..input_len(first)],
    );
    for (b, block) in plan.blocks.iter().enumerate() {
        let (input, rest) = saved.split_at_mut(block.saved_conv);
        let rows = Rows {
            data: &input[block.saved_input..][..input_len(block)],
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
    let Some(last) = plan.blocks.last() else {
        return scale;
    };
    let out = &saved[plan.saved_last..][..last.time_out * last.width_out];
    pool_forward(simd, of.pool, last, out, features);
    if plan.scale_feature < features.len() && of.preparation.standardises() {
        features[plan.scale_feature] = scale.ln();
    }
    scale
}

#[inline(always)]
fn input_len(block: &BlockPlan) -> usize {
    (block.time_in + 2 * block.padding) * block.width_in
}

#[inline(always)]
fn pool_forward<S: Simd>(simd: S, pool: Pool, last: &BlockPlan, out: &[f32], features: &mut [f32]) {
    let width = last.width_out;
    let each = 1.0 / last.time_out as f32;
    let (mean, rest) = features.split_at_mut(width);
    mean.fill(0.0);
    for row in out.chunks_exact(width) {
        add_row(simd, mean, row);
    }
    for m in mean.iter_mut() {
        *m *= each;
    }
    if pool == Pool::MeanAndRms {
        let rms = &mut rest[..width];
        rms.fill(0.0);
        for row in out.chunks_exact(width) {
            for (r, v) in rms.iter_mut().zip(row) {
                *r += v * v;
            }
        }
        for r in &mut rms[..last.channels] {
            *r = (*r * each + POOL_EPSILON).sqrt();
        }
    }
}

/// Room for one chunk's backward pass and the gradients it sums.
#[derive(Debug, Clone, Default)]
pub(crate) struct Gradients {
    /// The layout of [`Plan::gradient`].
    pub(crate) sums: Buffer,
    /// Every block's gradient of the convolution's output, with zero rows around it.
    d_conv: Vec<Buffer>,
    /// Every block's gradient of its output.
    d_out: Vec<Buffer>,
    levels: Vec<Buffer>,
    count: usize,
}

impl Gradients {
    pub(crate) fn fit(&mut self, plan: &Plan, count: usize) {
        if self.sums.is_empty() {
            self.sums = zeros(plan.gradient_len);
            self.d_conv = plan.blocks.iter().map(|b| zeros(b.gradient_rows * b.width_out)).collect();
            self.d_out = plan.blocks.iter().map(|b| zeros(b.time_out * b.width_out)).collect();
        }
        self.sums.fill(0.0);
        if self.count != count || self.levels.is_empty() {
            let widths = plan.linears.iter().map(|l| l.width_out);
            let first = plan.linears[0].width_in;
            self.levels = std::iter::once(first).chain(widths).map(|w| zeros(count * w)).collect();
            self.count = count;
        }
    }
}

/// The backward pass over a chunk's windows.
pub(crate) struct Backward<'a> {
    pub(crate) of: &'a Arithmetic,
    pub(crate) packed: &'a [f32],
    pub(crate) chunk: &'a Chunk,
    /// `[count]`: gradient of every deviation.
    pub(crate) d_sigma: &'a [f32],
    pub(crate) gradients: &'a mut Gradients,
}

impl WithSimd for Backward<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { of, packed, chunk, d_sigma, gradients } = self;
        let plan = &of.plan;
        let count = d_sigma.len();
        let last = plan.linears.len();
        let z = &chunk.levels[last];
        let d_last = &mut gradients.levels[last];
        d_last.fill(0.0);
        for (i, d) in d_sigma.iter().enumerate() {
            d_last[i * LANE] = of.head.backward(z[i * LANE], chunk.scales[i], *d);
        }
        for (l, linear) in plan.linears.iter().enumerate().rev() {
            let (before, after) = gradients.levels.split_at_mut(l + 1);
            let (d_in, d_out) = (&mut before[l], &after[0]);
            let rows = |data, stride| Rows { data, stride, count };
            let d_weights = &mut gradients.sums[linear.d_weights..][..linear.width_in * linear.width_out];
            accumulate(
                simd,
                rows(&chunk.levels[l], linear.width_in),
                linear.width_in,
                d_out,
                linear.width_out,
                d_weights,
            );
            let d_bias = &mut gradients.sums[linear.d_bias..][..linear.width_out];
            for row in d_out.chunks_exact(linear.width_out) {
                add_row(simd, d_bias, row);
            }
            multiply(
                simd,
                rows(d_out, linear.width_out),
                packed,
                &linear.transposed,
                None,
                d_in,
                linear.width_in,
            );
            if l > 0 {
                for (d, h) in d_in.iter_mut().zip(chunk.levels[l].iter()) {
                    // A leaky ReLU keeps the sign, so its output tells its slope.
                    *d *= if *h > 0.0 { 1.0 } else { of.norm.leak };
                }
            }
        }
        let width = plan.linears[0].width_in;
        for i in 0..count {
            let saved = &chunk.saved[i * plan.saved_len..(i + 1) * plan.saved_len];
            window_backward(
                simd,
                of,
                packed,
                saved,
                &chunk.levels[0][i * width..(i + 1) * width],
                i,
                gradients,
            );
        }
    }
}

/// One window from its features' gradient to the gradients of all blocks' parameters.
#[inline(always)]
fn window_backward<S: Simd>(
    simd: S,
    of: &Arithmetic,
    packed: &[f32],
    saved: &[f32],
    features: &[f32],
    window: usize,
    gradients: &mut Gradients,
) {
    let plan = &of.plan;
    let Gradients { sums, d_conv, d_out, levels, .. } = gradients;
    let Some(last) = plan.blocks.last() else {
        return;
    };
    let width = plan.linears[0].width_in;
    let d_features = &levels[0][window * width..(window + 1) * width];
    let out = &saved[plan.saved_last..][..last.time_out * last.width_out];
    pool_backward(of.pool, last, out, features, d_features, &mut d_out[plan.blocks.len() - 1]);
    for (b, block) in plan.blocks.iter().enumerate().rev() {
        let len = block.time_out * block.width_out;
        let conv = &saved[block.saved_conv..][..len];
        let stats = &saved[block.saved_stats..];
        let inner = block.lead * block.width_out;
        let (bias, rest) = sums[block.d_bias..].split_at_mut(block.width_out);
        let (gain, rest) = rest.split_at_mut(block.width_out);
        let offset = &mut rest[..block.width_out];
        let mut channel_sums = Sums { bias, gain, offset };
        let (before, at) = d_out.split_at_mut(b);
        norm::backward(
            simd,
            of.norm,
            block,
            packed,
            conv,
            stats,
            &mut at[0][..len],
            &mut d_conv[b][inner..inner + len],
            &mut channel_sums,
        );
        let rows = Rows {
            data: &saved[block.saved_input..][..input_len(block)],
            stride: block.stride * block.width_in,
            count: block.time_out,
        };
        let size = block.kernel * block.width_in;
        let d_weights = &mut sums[block.d_weights..][..size * block.width_out];
        accumulate(simd, rows, size, &d_conv[b][inner..inner + len], block.width_out, d_weights);
        if let Some(d_in) = before.last_mut() {
            if block.stride > block.kernel {
                // Samples that no tap sees.
                d_in.fill(0.0);
            }
            for phase in &block.phases {
                let rows = Rows {
                    data: &d_conv[b][phase.from * block.width_out..],
                    stride: block.width_out,
                    count: phase.count,
                };
                let out = &mut d_in[phase.first * block.width_in..];
                multiply(simd, rows, packed, &phase.weights, None, out, block.stride * block.width_in);
            }
        }
    }
}

#[inline(always)]
fn pool_backward(pool: Pool, last: &BlockPlan, out: &[f32], features: &[f32], d: &[f32], d_out: &mut [f32]) {
    let width = last.width_out;
    let each = 1.0 / last.time_out as f32;
    for row in d_out.chunks_exact_mut(width) {
        for (o, d) in row.iter_mut().zip(d) {
            *o = d * each;
        }
    }
    if pool == Pool::MeanAndRms {
        for (row, x) in d_out.chunks_exact_mut(width).zip(out.chunks_exact(width)) {
            for c in 0..last.channels {
                row[c] += d[width + c] * each * x[c] / features[width + c];
            }
        }
    }
}
