//! Pooling of the last block's channels over time, forth and back.

use super::kernel::add_row;
use super::plan::BlockPlan;
use crate::config::Pool;
use crate::definition::POOL_EPSILON;
use pulp::Simd;

/// Means of `out` over time into `features` and, with [`Pool::MeanAndRms`], root mean squares behind them.
///
/// # Shapes
/// `out`: `[time, width]`; `features`: `[width]` or `[2 width]`.
#[inline(always)]
pub(super) fn pool_forward<S: Simd>(
    simd: S,
    pool: Pool,
    last: &BlockPlan,
    out: &[f32],
    features: &mut [f32],
) {
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

/// Gradient of `out` from `d`, that of the features.
///
/// # Shapes
/// `out` and `d_out`: `[time, width]`; `features` and `d`: `[width]` or `[2 width]`.
#[inline(always)]
pub(super) fn pool_backward(
    pool: Pool,
    last: &BlockPlan,
    out: &[f32],
    features: &[f32],
    d: &[f32],
    d_out: &mut [f32],
) {
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
