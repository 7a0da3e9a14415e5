//! The backward pass over a chunk of windows, by hand.

use super::buffer::{Buffer, zeros};
use super::chunk::{Arithmetic, Chunk};
use super::kernel::{Rows, accumulate, add_row, multiply};
use super::norm::{self, Sums};
use super::plan::{LANE, Plan};
use super::pool::pool_backward;
use pulp::{Simd, WithSimd};

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
    /// `[count, outputs]`: gradient of every answer.
    pub(crate) d_answers: &'a [f32],
    pub(crate) gradients: &'a mut Gradients,
}

impl WithSimd for Backward<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { of, packed, chunk, d_answers, gradients } = self;
        let plan = &of.plan;
        let count = d_answers.len() / of.head.outputs();
        let last = plan.linears.len();
        let z = &chunk.levels[last];
        let d_last = &mut gradients.levels[last];
        d_last.fill(0.0);
        for ((z, d), d_z) in z
            .chunks_exact(LANE)
            .zip(d_answers.chunks_exact(of.head.outputs()))
            .zip(d_last.chunks_exact_mut(LANE))
        {
            of.head.backward(z, d, d_z);
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
    let last = plan.blocks.last().expect("a network has a block");
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
            data: &saved[block.saved_input..][..block.input_len()],
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
