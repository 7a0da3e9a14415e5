//! The last step of a search: how the window turned, grew and sheared, so that none of it is taken for a shift.
//!
//! About the place that a shift alone found, with `x` from the window's centre,
//!
//! ```text
//! J(x + d) - I(x) = -g.(s + M x) + a I(x) + o
//! ```
//! is solved for the shift `s`, the 2 x 2 `M`, and the light's gain and offset, by least squares with a prior of zero on `M`, as wide as what
//! a camera does to a window between two images. It is one Gauss-Newton step from `M = 0`: over one camera's period the corners of
//! a window move against its middle by parts of a pixel, within which images are straight enough. The image is not resampled.
//!
//! Four more unknowns make the shift noisier: `M` is believed where it lowers the squares by more than noise would (an F test), else the
//! shift alone stands.
//!
//! A column's `x` is the same in every row: sums are taken over rows for every column, and weighed by `x` once, in the end.
//!
//! Source: Shi and Tomasi 1994, sec. 3 (the model); the prior and the single step are ours.

// With indices the loops read as the formulas do.
#![allow(clippy::needless_range_loop)]

use super::between::RowsBetween;
use super::lanes::{LANES, Lanes, part, sum_of};
use super::patch::{Patch, corner_of};
use crate::frontend::image::Plane;

/// Deviation of each entry of `M` from one image to the next: at ten pixels from the centre a fifth of a pixel.
const BEND_STD: f64 = 0.02;
/// Least squares of differences a pixel \[grey^2\], for windows that match better than their own noise.
const LEAST_SQUARE: f64 = 0.1;
/// What `M` lowers the squares by, for each of its entries, over what is left for each pixel. Of independent pixels 1 window of 100 is
/// above 3.3 by chance; interpolation ties neighbours, and a false `M` costs more than a missed one.
const LEAST_F: f64 = 10.0;
/// A longer step is none: the model does not hold, and the shift alone is better \[px\].
const MOST_PX: f64 = 0.5;
/// Unknowns: shift, gain and offset, `M` by columns (by x, then by y).
const DIM: usize = 8;
/// Where gain and offset stand.
const LIGHT: usize = 2;
/// Where `M` stands.
const BEND: usize = 4;
/// Sums over rows. First the gradients' products xx, xy, yy, each with 1, y and y^2.
const SUMS: usize = 26;
/// Gradients x and y by grey, alone, and by difference, each with 1 and y.
const LINES: usize = 9;
/// Difference by grey, difference, grey, grey squared, difference squared.
const PLAIN: usize = 21;

/// What is to be added to `place`, where the patch was found in `plane`; nothing where the window does not say.
#[inline(always)]
pub(super) fn refine<S: Lanes, const L: usize, const W: usize>(
    simd: S,
    patch: &Patch<L, W>,
    plane: &Plane,
    place: [f32; 2],
) -> Option<[f32; 2]> {
    let total = products(simd, patch, plane, place)?;
    Some(solve(&total, f64::from(patch.count()), BEND_STD)?.shift)
}

/// What a window did.
#[derive(Debug, Clone, Copy)]
pub(super) struct Bent {
    /// By how much it is elsewhere, `s` \[px\].
    pub(super) shift: [f32; 2],
    /// How it turned, grew and sheared, `M`, row after row; 0 where it is not believed.
    pub(super) matrix: [[f32; 2]; 2],
    /// The correlation of the patch with what it was held against, before the step.
    pub(super) alike: f32,
}

/// Sums over the window, weighed by 1, x and x^2 of the column.
pub(super) type Products = [[f64; 3]; SUMS];

/// Products of gradients, grey values and differences, summed over the window; `None` where `plane` has no window at `place`.
#[inline(always)]
pub(super) fn products<S: Lanes, const L: usize, const W: usize>(
    simd: S,
    patch: &Patch<L, W>,
    plane: &Plane,
    place: [f32; 2],
) -> Option<Products> {
    let ([x, y], rest) = corner_of(plane, place, patch.window)?;
    let zero = simd.splat_f32s(patch.light.zero);
    let half = (patch.window / 2) as f32;
    // Sums over rows for every column, weighed by 1, x and x^2 of the column and taken over columns modulo eight.
    let mut lanes = [[simd.splat_f32s(0.0); 3]; SUMS];
    for block in (0..L).step_by(LANES) {
        let mut sums = [simd.splat_f32s(0.0); SUMS];
        let mut rows =
            RowsBetween::new(simd, plane, [x + block as isize, y + patch.rows.start as isize], rest);
        for r in patch.rows.clone() {
            let (gx, gy) = (part(&patch.grad_x[r], block), part(&patch.grad_y[r], block));
            let grey = part(&patch.grey[r], block);
            let down = simd.splat_f32s(r as f32 - half);
            let difference = simd.sub_f32s(rows.next_row(), grey);
            let value = simd.sub_f32s(grey, zero);
            let products = [simd.mul_f32s(gx, gx), simd.mul_f32s(gx, gy), simd.mul_f32s(gy, gy)];
            for k in 0..3 {
                let sloped = simd.mul_f32s(down, products[k]);
                simd.add_to(&mut sums[3 * k], products[k]);
                simd.add_to(&mut sums[3 * k + 1], sloped);
                simd.add_product(&mut sums[3 * k + 2], down, sloped);
            }
            let by_value = [simd.mul_f32s(gx, value), simd.mul_f32s(gy, value)];
            let by_difference = [simd.mul_f32s(gx, difference), simd.mul_f32s(gy, difference)];
            let terms = [by_value[0], by_value[1], gx, gy, by_difference[0], by_difference[1]];
            for k in 0..6 {
                simd.add_to(&mut sums[LINES + 2 * k], terms[k]);
                simd.add_product(&mut sums[LINES + 2 * k + 1], down, terms[k]);
            }
            simd.add_product(&mut sums[PLAIN], difference, value);
            simd.add_to(&mut sums[PLAIN + 1], difference);
            simd.add_to(&mut sums[PLAIN + 2], value);
            simd.add_product(&mut sums[PLAIN + 3], value, value);
            simd.add_product(&mut sums[PLAIN + 4], difference, difference);
        }
        let mut across = [0.0f32; LANES];
        for i in 0..LANES {
            across[i] = (block + i) as f32 - half;
        }
        let (columns, across) = (part(&patch.columns, block), part(&across, 0));
        let once = simd.mul_f32s(columns, across);
        let weights = [columns, once, simd.mul_f32s(once, across)];
        for k in 0..SUMS {
            for power in 0..3 {
                simd.add_product(&mut lanes[k][power], sums[k], weights[power]);
            }
        }
    }
    let mut total = [[0.0f64; 3]; SUMS];
    for k in 0..SUMS {
        for power in 0..3 {
            total[k][power] = f64::from(sum_of(lanes[k][power]));
        }
    }
    Some(total)
}

/// The same with other differences: by gradients x and y each with 1 and y, weighed by 1 and x of the column, by grey value, alone, squared.
pub(super) fn with_differences(
    products: &Products,
    by_gradient: [[f64; 2]; 4],
    [value, alone, squared]: [f64; 3],
) -> Products {
    let mut total = *products;
    for (sum, [once, across]) in total[LINES + 8..LINES + 12].iter_mut().zip(by_gradient) {
        *sum = [once, across, 0.0];
    }
    for (sum, plain) in [(PLAIN, value), (PLAIN + 1, alone), (PLAIN + 4, squared)] {
        total[sum][0] = plain;
    }
    total
}

/// The step from the sums over `count` pixels, entries of `M` deviating by `std`: unknowns are taken out one by one, `M` last, so that what the others lower is known before it.
#[inline(always)]
pub(super) fn solve(total: &Products, count: f64, std: f64) -> Option<Bent> {
    let [dv, d1, v, vv, dd] = [0, 1, 2, 3, 4].map(|k| total[PLAIN + k][0]);
    let mut normal = [[0.0f64; DIM]; DIM];
    let mut side = [0.0f64; DIM];
    // Unknowns come in pairs by axis of the gradient: shift, M by x, M by y.
    let pairs = [(0, 0, 0), (BEND, 1, 0), (BEND + 2, 0, 1)];
    for (p, &(at, px, py)) in pairs.iter().enumerate() {
        for &(other, qx, qy) in &pairs[..=p] {
            let (x, y) = (px + qx, py + qy);
            let [xx, xy, yy] = [total[y][x], total[3 + y][x], total[6 + y][x]];
            normal[at][other] = xx;
            normal[at][other + 1] = xy;
            normal[at + 1][other] = xy;
            normal[at + 1][other + 1] = yy;
        }
        for axis in 0..2 {
            let line = |k: usize| total[LINES + 4 * k + 2 * axis + py][px];
            side[at + axis] = -line(2);
            // Below the diagonal: light stands behind the shift and before M.
            for (light, sum) in [(LIGHT, line(0)), (LIGHT + 1, line(1))] {
                let (row, column) = if at == 0 { (light, axis) } else { (at + axis, light) };
                normal[row][column] = -sum;
            }
        }
    }
    normal[LIGHT][LIGHT] = vv.max(1e-6);
    normal[LIGHT + 1][LIGHT] = v;
    normal[LIGHT + 1][LIGHT + 1] = count;
    side[LIGHT] = dv;
    side[LIGHT + 1] = d1;

    // L D L^T in place; `side` becomes L^-1 of itself, and each unknown lowers the squares by side^2 / D.
    let (mut left, mut own, mut lowered) = (dd, 0.0, 0.0);
    let mut inverses = [0.0f64; DIM];
    for k in 0..DIM {
        if k == BEND {
            own = (left / (count - 4.0).max(1.0)).max(LEAST_SQUARE);
            for m in BEND..DIM {
                normal[m][m] += own / (std * std);
            }
            lowered = left;
        }
        let pivot = normal[k][k];
        if pivot.is_nan() || pivot <= 1e-9 {
            return None;
        }
        let inverse = 1.0 / pivot;
        inverses[k] = inverse;
        left -= side[k] * side[k] * inverse;
        for r in k + 1..DIM {
            let factor = normal[r][k] * inverse;
            for c in k + 1..=r {
                normal[r][c] -= factor * normal[c][k];
            }
            side[r] -= factor * side[k];
        }
    }
    lowered -= left;
    // What stands below the diagonal is L D. Without M the rest is solved as if it were not there.
    let solved = if lowered < 4.0 * LEAST_F * own { BEND } else { DIM };
    let mut step = [0.0f64; DIM];
    for k in (0..solved).rev() {
        let mut value = side[k];
        for r in k + 1..solved {
            value -= normal[r][k] * step[r];
        }
        step[k] = value * inverses[k];
    }
    let gain = (1.0 + step[LIGHT]).clamp(0.5, 2.0);
    let step = step.map(|value| (value / gain) as f32);
    let [x, y, _, _, xx, yx, xy, yy] = step;
    // Grey values of the two windows, counted from the patch's mean.
    let (own, both, other) = (
        vv - v * v / count,
        vv + dv - v * (v + d1) / count,
        vv + 2.0 * dv + dd - (v + d1) * (v + d1) / count,
    );
    let alike = (both / (own * other).max(f64::MIN_POSITIVE).sqrt()) as f32;
    let short = f64::from(x).hypot(f64::from(y)) <= MOST_PX;
    short.then_some(Bent { shift: [x, y], matrix: [[xx, xy], [yx, yy]], alike })
}
