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
//! Column weights are the same in every row: sums are taken over rows for every column, and weighed by `x` once, in the end.
//!
//! Source: Shi and Tomasi 1994, sec. 3 (the model); the prior and the single step are ours.

// With indices the loops read as the formulas do, and the compiler makes vectors of them.
#![allow(clippy::needless_range_loop)]

use super::patch::{Patch, between_columns, corner_of};
use crate::frontend::image::Plane;
use nalgebra::{SMatrix, SVector};

/// Deviation of each entry of `M`: at ten pixels from the centre a fifth of a pixel.
const BEND_STD: f64 = 0.02;
/// Least squares of differences a pixel \[grey^2\], for windows that match better than their own noise.
const LEAST_SQUARE: f64 = 0.1;
/// What `M` lowers the squares by, for each of its entries, over what is left for each pixel. Of independent pixels 1 window of 100 is
/// above 3.3 by chance; interpolation ties neighbours, and a false `M` costs more than a missed one.
const LEAST_F: f64 = 10.0;
/// A longer step is none: the model does not hold, and the shift alone is better \[px\].
const MOST_PX: f64 = 0.5;
/// Unknowns: shift, `M` by columns (by x, then by y), gain, offset.
const DIM: usize = 8;

/// What is to be added to `place`, where the patch was found in `plane`; nothing where the window does not say.
#[inline(always)]
pub(super) fn refine<const L: usize, const W: usize>(
    patch: &Patch<L, W>,
    plane: &Plane,
    place: [f32; 2],
    gained: bool,
) -> Option<[f32; 2]> {
    let ([x, y], [fx, fy]) = corner_of(plane, place, patch.window)?;
    let zero = patch.light.zero;
    let half = (patch.window / 2) as f32;
    // Products of gradients xx, xy, yy with 1, y and y^2; gradients x and y by grey, 1 and difference, each with 1 and y; differences by
    // grey and 1; grey, its square, the difference's square.
    let mut squares = [[[0.0f32; L]; 3]; 3];
    let mut lines = [[[0.0f32; L]; 2]; 6];
    let mut plain = [[0.0f32; L]; 5];
    let row = |dy: usize| plane.run(x, y + dy as isize, L + 1);
    let mut above = between_columns::<L>(row(patch.rows.start), fx);
    for r in patch.rows.clone() {
        let below = between_columns::<L>(row(r + 1), fx);
        let (grey, grad_x, grad_y) = (&patch.grey[r], &patch.grad_x[r], &patch.grad_y[r]);
        let down = r as f32 - half;
        for i in 0..L {
            let difference = above[i] + fy * (below[i] - above[i]) - grey[i];
            let (value, gx, gy) = (grey[i] - zero, grad_x[i], grad_y[i]);
            let products = [gx * gx, gx * gy, gy * gy];
            for k in 0..3 {
                let sloped = down * products[k];
                squares[k][0][i] += products[k];
                squares[k][1][i] += sloped;
                squares[k][2][i] += down * sloped;
            }
            let terms = [gx * value, gy * value, gx, gy, gx * difference, gy * difference];
            for k in 0..6 {
                lines[k][0][i] += terms[k];
                lines[k][1][i] += down * terms[k];
            }
            plain[0][i] += difference * value;
            plain[1][i] += difference;
            plain[2][i] += value;
            plain[3][i] += value * value;
            plain[4][i] += difference * difference;
        }
        above = below;
    }

    // A column's weight is a power of its x.
    let weighed = |lanes: &[f32; L], power: usize| {
        let mut weighed = *lanes;
        for (i, lane) in weighed.iter_mut().enumerate() {
            let across = i as f32 - half;
            *lane *= [1.0, across, across * across][power];
        }
        f64::from(patch.total(&weighed))
    };
    let mut normal = SMatrix::<f64, DIM, DIM>::zeros();
    let mut side = SVector::<f64, DIM>::zeros();
    // Unknowns come in pairs by axis of the gradient: constant, by x, by y.
    let powers = [[0, 0], [1, 0], [0, 1]];
    for (p, &[px, py]) in powers.iter().enumerate() {
        for (q, &[qx, qy]) in powers.iter().enumerate().take(p + 1) {
            let [xx, xy, yy] = [0, 1, 2].map(|k| weighed(&squares[k][py + qy], px + qx));
            let mut put = |a: usize, b: usize, v: f64| {
                normal[(a, b)] = v;
                normal[(b, a)] = v;
            };
            put(2 * p, 2 * q, xx);
            put(2 * p, 2 * q + 1, xy);
            put(2 * p + 1, 2 * q, xy);
            put(2 * p + 1, 2 * q + 1, yy);
        }
        let [xv, yv, x1, y1, xd, yd] = [0, 1, 2, 3, 4, 5].map(|k| weighed(&lines[k][py], px));
        for (axis, (by_value, by_one, by_difference)) in [(xv, x1, xd), (yv, y1, yd)].into_iter().enumerate()
        {
            let place = 2 * p + axis;
            side[place] = -by_difference;
            if gained {
                normal[(place, 6)] = -by_value;
                normal[(6, place)] = -by_value;
                normal[(place, 7)] = -by_one;
                normal[(7, place)] = -by_one;
            }
        }
    }
    let [dv, d1, v, vv, dd] = [0, 1, 2, 3, 4].map(|k| weighed(&plain[k], 0));
    let count = patch.rows.len() as f64 * f64::from(patch.total(&[1.0; L]));
    if gained {
        normal[(6, 6)] = vv.max(1e-6);
        normal[(6, 7)] = v;
        normal[(7, 6)] = v;
        normal[(7, 7)] = count;
        side[6] = dv;
        side[7] = d1;
    } else {
        normal[(6, 6)] = 1.0;
        normal[(7, 7)] = 1.0;
    }
    // Without M: the search ended there, but for the light.
    let alike = {
        let few = [0, 1, 6, 7];
        let normal = SMatrix::<f64, 4, 4>::from_fn(|r, c| normal[(few[r], few[c])]);
        let side = SVector::<f64, 4>::from_fn(|r, _| side[few[r]]);
        dd - side.dot(&normal.cholesky()?.solve(&side))
    };
    let own = (alike / (count - 4.0).max(1.0)).max(LEAST_SQUARE);
    for k in 2..6 {
        normal[(k, k)] += own / (BEND_STD * BEND_STD);
    }
    let step = normal.cholesky()?.solve(&side);
    let lowered = alike - (dd - side.dot(&step));
    if lowered < 4.0 * LEAST_F * own {
        return None;
    }
    let gain = if gained { (1.0 + step[6]).clamp(0.5, 2.0) } else { 1.0 };
    let [sx, sy] = [step[0] / gain, step[1] / gain];
    (sx.hypot(sy) <= MOST_PX).then_some([sx as f32, sy as f32])
}
