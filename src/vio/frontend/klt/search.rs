//! The Gauss-Newton search on one level.

use super::between::RowsBetween;
use super::config::KltConfig;
use super::lanes::{LANES, Lanes, Sums, part};
use super::patch::{Patch, corner_of};
use crate::frontend::image::Plane;

/// A gain is trusted between these when a step is scaled by it; far from the goal it says nothing.
const GAIN: std::ops::RangeInclusive<f32> = 0.5..=2.0;

/// How a search ended.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Outcome {
    /// At this place.
    At([f32; 2]),
    /// The window left the image.
    Outside,
    /// The window's texture determines no shift.
    Flat,
}

/// Sums of one look at the second image: difference times gradient in x and y, times grey value, and alone.
#[inline(always)]
fn look<S: Lanes, const L: usize, const W: usize>(
    simd: S,
    patch: &Patch<L, W>,
    plane: &Plane,
    [x, y]: [isize; 2],
    rest: [f32; 2],
) -> [f32; 4] {
    let mut lanes = Sums::<S, 4>::new(simd);
    for block in (0..L).step_by(LANES) {
        let mut sums = [simd.splat_f32s(0.0); 4];
        let mut rows =
            RowsBetween::new(simd, plane, [x + block as isize, y + patch.rows.start as isize], rest);
        for r in patch.rows.clone() {
            let grey = part(&patch.grey[r], block);
            let difference = simd.sub_f32s(rows.next_row(), grey);
            simd.add_product(&mut sums[0], difference, part(&patch.grad_x[r], block));
            simd.add_product(&mut sums[1], difference, part(&patch.grad_y[r], block));
            simd.add_product(&mut sums[2], difference, grey);
            simd.add_to(&mut sums[3], difference);
        }
        lanes.add(&sums, part(&patch.columns, block));
    }
    lanes.totals()
}

/// Where the patch is in `plane`, from `start` on, to a step of `epsilon` \[px of this level\].
#[inline(always)]
pub(super) fn search<S: Lanes, const L: usize, const W: usize>(
    simd: S,
    patch: &Patch<L, W>,
    plane: &Plane,
    start: [f32; 2],
    config: &KltConfig,
    epsilon: f32,
) -> Outcome {
    let [xx, xy, yy] = patch.normal;
    let determinant = xx * yy - xy * xy;
    let area = (patch.window * patch.window) as f32;
    let smallest = (xx + yy - ((xx - yy) * (xx - yy) + 4.0 * xy * xy).sqrt()) / (2.0 * area);
    if smallest < config.min_eigenvalue as f32 || determinant < f32::EPSILON {
        return Outcome::Flat;
    }
    let inverse = 1.0 / determinant;

    let mut place = start;
    let mut before = [0.0f32; 2];
    for iteration in 0..config.iterations {
        let Some((corner, rest)) = corner_of(plane, place, patch.window) else { return Outcome::Outside };
        let [bx, by, excess] = patch.light.taken_out(look(simd, patch, plane, corner, rest));
        let gain = (1.0 + excess).clamp(*GAIN.start(), *GAIN.end());
        let scale = -inverse / gain;
        let step = [(yy * bx - xy * by) * scale, (xx * by - xy * bx) * scale];
        place = [place[0] + step[0], place[1] + step[1]];
        if step[0] * step[0] + step[1] * step[1] <= epsilon * epsilon {
            break;
        }
        // Two steps that undo each other: the goal is half-way.
        if iteration > 0 && (step[0] + before[0]).abs() < 0.01 && (step[1] + before[1]).abs() < 0.01 {
            place = [place[0] - 0.5 * step[0], place[1] - 0.5 * step[1]];
            break;
        }
        before = step;
    }
    Outcome::At(place)
}
