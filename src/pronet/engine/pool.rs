//! Pooling of the last block's channels over time, forth and back.

use super::kernel::add_row;
use super::plan::BlockPlan;
use crate::config::Pool;
use crate::definition::POOL_EPSILON;
use pulp::Simd;

/// Means of `out` over time into `features` and, with [`Pool::MeanAndRms`], root mean squares behind them; with [`Pool::LogRms`] the logarithms of these
/// alone.
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
    if pool == Pool::LogRms {
        add_squares(out, mean);
        for f in &mut mean[..last.channels] {
            *f = 0.5 * (*f * each + POOL_EPSILON).ln();
        }
        return;
    }
    mean.fill(0.0);
    for row in out.chunks_exact(width) {
        add_row(simd, mean, row);
    }
    for m in mean.iter_mut() {
        *m *= each;
    }
    if pool == Pool::MeanAndRms {
        let rms = &mut rest[..width];
        add_squares(out, rms);
        for r in &mut rms[..last.channels] {
            *r = (*r * each + POOL_EPSILON).sqrt();
        }
    }
}

/// Sums of the squares of every column of `out` into `sums`.
#[inline(always)]
fn add_squares(out: &[f32], sums: &mut [f32]) {
    sums.fill(0.0);
    for row in out.chunks_exact(sums.len()) {
        for (r, v) in sums.iter_mut().zip(row) {
            *r += v * v;
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
    if pool == Pool::LogRms {
        for (row, x) in d_out.chunks_exact_mut(width).zip(out.chunks_exact(width)) {
            row.fill(0.0);
            for c in 0..last.channels {
                // The mean square is exp(2 feature).
                row[c] = d[c] * each * x[c] * (-2.0 * features[c]).exp();
            }
        }
        return;
    }
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
