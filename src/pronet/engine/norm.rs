//! A block's normalisation and leaky ReLU, forth and back, row by row (a row is one time step's channels).
//!
//! With `n = (x - mean) / sqrt(var + 1e-5)`, the block gives `act(gain n + offset)` of the convolution's output `x = c`, or in the paper's
//! other order `gain n + offset` of `x = act(c)`. Back through the normalisation: `dx = (dn - mean(dn) - n mean(dn n)) / sqrt(..)` with
//! `dn = gain * dz`, means taken over the channels. Padded channels have gain and mask zero and stay out of every sum.

use super::plan::BlockPlan;
use crate::config::{BlockOrder, NormAxes};
use crate::definition::NORM_EPSILON;
use pulp::Simd;

/// What does not change within a network.
#[derive(Debug, Clone, Copy)]
pub(crate) struct NormKind {
    pub(crate) order: BlockOrder,
    pub(crate) axes: NormAxes,
    pub(crate) leak: f32,
}

/// A block's packed channel rows.
struct Rows<'a, V> {
    gain: &'a [V],
    offset: &'a [V],
    mask: &'a [V],
}

impl<'a, V> Rows<'a, V> {
    #[inline(always)]
    fn of<S: Simd<f32s = V>>(block: &BlockPlan, packed: &'a [f32]) -> Self {
        let row = |at: usize| S::as_simd_f32s(&packed[at..at + block.width_out]).0;
        Self { gain: row(block.gain), offset: row(block.offset), mask: row(block.mask) }
    }
}

#[inline(always)]
fn leaky<S: Simd>(simd: S, leak: S::f32s, x: S::f32s) -> S::f32s {
    // The slope is at most one, so the larger of the two is the right one.
    simd.max_f32s(x, simd.mul_f32s(leak, x))
}

/// `gradient` where `x > 0`, `leak * gradient` elsewhere.
#[inline(always)]
fn leaky_back<S: Simd>(simd: S, leak: S::f32s, x: S::f32s, gradient: S::f32s) -> S::f32s {
    let positive = simd.greater_than_f32s(x, simd.splat_f32s(0.0));
    simd.select_f32s(positive, gradient, simd.mul_f32s(leak, gradient))
}

/// The number normalised: the convolution's output, or its leaky ReLU in the paper's other order.
#[inline(always)]
fn normalised<S: Simd>(simd: S, order: BlockOrder, leak: S::f32s, conv: S::f32s) -> S::f32s {
    match order {
        BlockOrder::ConvNormAct => conv,
        BlockOrder::ConvActNorm => leaky(simd, leak, conv),
    }
}

/// From the convolution's output `conv` to the block's output `out`, both `[time out, width out]`; leaves mean and reciprocal
/// deviation of every row in `stats`.
#[inline(always)]
pub(crate) fn forward<S: Simd>(
    simd: S,
    kind: NormKind,
    block: &BlockPlan,
    packed: &[f32],
    conv: &[f32],
    stats: &mut [f32],
    out: &mut [f32],
) {
    let width = block.width_out;
    let leak = simd.splat_f32s(kind.leak);
    let rows = Rows::of::<S>(block, packed);
    match kind.axes {
        NormAxes::None => {
            let (out, _) = S::as_mut_simd_f32s(out);
            for (o, c) in out.iter_mut().zip(S::as_simd_f32s(conv).0) {
                *o = leaky(simd, leak, *c);
            }
        }
        NormAxes::Channels => {
            let each = 1.0 / block.channels as f32;
            let iter =
                conv.chunks_exact(width).zip(out.chunks_exact_mut(width)).zip(stats.chunks_exact_mut(2));
            for ((conv, out), stats) in iter {
                let mean = sum(simd, kind.order, leak, conv) * each;
                let variance = sum_of_squares(simd, kind.order, leak, rows.mask, conv, mean) * each;
                let inverse = 1.0 / (variance + NORM_EPSILON).sqrt();
                (stats[0], stats[1]) = (mean, inverse);
                apply(simd, kind.order, leak, &rows, conv, (mean, inverse), out);
            }
        }
    }
}

#[inline(always)]
fn sum<S: Simd>(simd: S, order: BlockOrder, leak: S::f32s, conv: &[f32]) -> f32 {
    let mut total = simd.splat_f32s(0.0);
    for c in S::as_simd_f32s(conv).0 {
        total = simd.add_f32s(total, normalised(simd, order, leak, *c));
    }
    simd.reduce_sum_f32s(total)
}

#[inline(always)]
fn sum_of_squares<S: Simd>(
    simd: S,
    order: BlockOrder,
    leak: S::f32s,
    mask: &[S::f32s],
    conv: &[f32],
    mean: f32,
) -> f32 {
    let mean = simd.splat_f32s(mean);
    let mut total = simd.splat_f32s(0.0);
    for (c, m) in S::as_simd_f32s(conv).0.iter().zip(mask) {
        let x = simd.mul_f32s(*m, simd.sub_f32s(normalised(simd, order, leak, *c), mean));
        total = simd.mul_add_e_f32s(x, x, total);
    }
    simd.reduce_sum_f32s(total)
}

#[inline(always)]
fn apply<S: Simd>(
    simd: S,
    order: BlockOrder,
    leak: S::f32s,
    rows: &Rows<'_, S::f32s>,
    conv: &[f32],
    (mean, inverse): (f32, f32),
    out: &mut [f32],
) {
    let (mean, inverse) = (simd.splat_f32s(mean), simd.splat_f32s(inverse));
    let (out, _) = S::as_mut_simd_f32s(out);
    for (((o, c), gain), offset) in
        out.iter_mut().zip(S::as_simd_f32s(conv).0).zip(rows.gain).zip(rows.offset)
    {
        let x = normalised(simd, order, leak, *c);
        let n = simd.mul_f32s(simd.sub_f32s(x, mean), inverse);
        let z = simd.mul_add_e_f32s(n, *gain, *offset);
        *o = match order {
            BlockOrder::ConvNormAct => leaky(simd, leak, z),
            BlockOrder::ConvActNorm => z,
        };
    }
}

/// Sums of a block's gradients over rows and windows, each `[width out]`.
pub(crate) struct Sums<'a> {
    pub(crate) bias: &'a mut [f32],
    pub(crate) gain: &'a mut [f32],
    pub(crate) offset: &'a mut [f32],
}

/// From the gradient `d` of the block's output to that of the convolution's output, in `d_conv`; both `[time out, width out]`.
/// `d` is overwritten on the way.
#[inline(always)]
#[expect(clippy::too_many_arguments, reason = "one call, whose operands are all named slices")]
pub(crate) fn backward<S: Simd>(
    simd: S,
    kind: NormKind,
    block: &BlockPlan,
    packed: &[f32],
    conv: &[f32],
    stats: &[f32],
    d: &mut [f32],
    d_conv: &mut [f32],
    sums: &mut Sums<'_>,
) {
    let width = block.width_out;
    let leak = simd.splat_f32s(kind.leak);
    let rows = Rows::of::<S>(block, packed);
    let (bias, _) = S::as_mut_simd_f32s(&mut *sums.bias);
    let (gain, _) = S::as_mut_simd_f32s(&mut *sums.gain);
    let (offset, _) = S::as_mut_simd_f32s(&mut *sums.offset);
    match kind.axes {
        NormAxes::None => {
            let iter =
                conv.chunks_exact(width).zip(d.chunks_exact(width)).zip(d_conv.chunks_exact_mut(width));
            for ((conv, d), d_conv) in iter {
                let (conv, d, d_conv) =
                    (S::as_simd_f32s(conv).0, S::as_simd_f32s(d).0, S::as_mut_simd_f32s(d_conv).0);
                for (((b, o), c), d) in bias.iter_mut().zip(d_conv).zip(conv).zip(d) {
                    *o = leaky_back(simd, leak, *c, *d);
                    *b = simd.add_f32s(*b, *o);
                }
            }
        }
        NormAxes::Channels => {
            let each = 1.0 / block.channels as f32;
            let iter = conv
                .chunks_exact(width)
                .zip(d.chunks_exact_mut(width))
                .zip(d_conv.chunks_exact_mut(width))
                .zip(stats.chunks_exact(2));
            for (((conv, d), d_conv), stats) in iter {
                let stats = (stats[0], stats[1]);
                let (s1, s2) = to_normal(simd, kind.order, leak, &rows, conv, stats, d, gain, offset);
                let means = (s1 * each, s2 * each);
                through(simd, kind.order, leak, rows.mask, conv, stats, means, d, d_conv, bias);
            }
        }
    }
}

/// Turns one row's `d` into the gradient of the normalised numbers, adds to gain's and offset's gradients, and returns the sums of
/// `dn` and of `dn n`.
#[inline(always)]
#[expect(clippy::too_many_arguments, reason = "one call, whose operands are all named slices")]
fn to_normal<S: Simd>(
    simd: S,
    order: BlockOrder,
    leak: S::f32s,
    rows: &Rows<'_, S::f32s>,
    conv: &[f32],
    (mean, inverse): (f32, f32),
    d: &mut [f32],
    d_gain: &mut [S::f32s],
    d_offset: &mut [S::f32s],
) -> (f32, f32) {
    let (mean, inverse) = (simd.splat_f32s(mean), simd.splat_f32s(inverse));
    let (mut s1, mut s2) = (simd.splat_f32s(0.0), simd.splat_f32s(0.0));
    let (conv, d) = (S::as_simd_f32s(conv).0, S::as_mut_simd_f32s(d).0);
    let channel = rows.gain.iter().zip(rows.offset).zip(d_gain.iter_mut().zip(d_offset.iter_mut()));
    for ((c, d), ((gain, offset), (d_gain, d_offset))) in conv.iter().zip(d.iter_mut()).zip(channel) {
        let x = normalised(simd, order, leak, *c);
        let n = simd.mul_f32s(simd.sub_f32s(x, mean), inverse);
        let dz = match order {
            BlockOrder::ConvNormAct => {
                let z = simd.mul_add_e_f32s(n, *gain, *offset);
                leaky_back(simd, leak, z, *d)
            }
            BlockOrder::ConvActNorm => *d,
        };
        *d_gain = simd.mul_add_e_f32s(dz, n, *d_gain);
        *d_offset = simd.add_f32s(*d_offset, dz);
        let dn = simd.mul_f32s(dz, *gain);
        s1 = simd.add_f32s(s1, dn);
        s2 = simd.mul_add_e_f32s(dn, n, s2);
        *d = dn;
    }
    (simd.reduce_sum_f32s(s1), simd.reduce_sum_f32s(s2))
}

/// From one row's `dn` to the gradient of the convolution's output; adds it to the bias's gradient.
#[inline(always)]
#[expect(clippy::too_many_arguments, reason = "one call, whose operands are all named slices")]
fn through<S: Simd>(
    simd: S,
    order: BlockOrder,
    leak: S::f32s,
    mask: &[S::f32s],
    conv: &[f32],
    (mean, inverse): (f32, f32),
    (mean_dn, mean_dn_n): (f32, f32),
    d: &[f32],
    d_conv: &mut [f32],
    d_bias: &mut [S::f32s],
) {
    let (mean, inverse) = (simd.splat_f32s(mean), simd.splat_f32s(inverse));
    let (m1, m2) = (simd.splat_f32s(mean_dn), simd.splat_f32s(mean_dn_n));
    let (conv, d, d_conv) = (S::as_simd_f32s(conv).0, S::as_simd_f32s(d).0, S::as_mut_simd_f32s(d_conv).0);
    let channel = mask.iter().zip(d_bias.iter_mut());
    for (((o, c), dn), (mask, d_bias)) in d_conv.iter_mut().zip(conv).zip(d).zip(channel) {
        let x = normalised(simd, order, leak, *c);
        let n = simd.mul_f32s(simd.sub_f32s(x, mean), inverse);
        let rest = simd.sub_f32s(simd.sub_f32s(*dn, m1), simd.mul_f32s(n, m2));
        let dx = simd.mul_f32s(*mask, simd.mul_f32s(inverse, rest));
        let dc = match order {
            BlockOrder::ConvNormAct => dx,
            BlockOrder::ConvActNorm => leaky_back(simd, leak, *c, dx),
        };
        *o = dc;
        *d_bias = simd.add_f32s(*d_bias, dc);
    }
}
