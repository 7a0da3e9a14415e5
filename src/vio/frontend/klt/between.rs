//! Grey values between pixels, by bilinear interpolation: rows of a window that lies anywhere in an image.

use super::lanes::{LANES, Lanes};
use crate::frontend::image::Plane;
use pulp::f32x8;

/// [`LANES`] columns of a window, row after row downwards.
pub(super) struct RowsBetween<'a, S: Lanes> {
    simd: S,
    plane: &'a Plane,
    x: isize,
    /// The pixel row below the next row of the window.
    y: isize,
    right: f32x8,
    down: f32x8,
    /// The pixel row above it, interpolated in its columns.
    above: f32x8,
}

impl<'a, S: Lanes> RowsBetween<'a, S> {
    /// From pixel `[x, y]` on, `rest` of a pixel to the right and down.
    #[inline(always)]
    pub(super) fn new(simd: S, plane: &'a Plane, [x, y]: [isize; 2], rest: [f32; 2]) -> Self {
        let [right, down] = [simd.splat_f32s(rest[0]), simd.splat_f32s(rest[1])];
        let above = simd.between_columns(plane.run(x, y, LANES + 1), right);
        Self { simd, plane, x, y: y + 1, right, down, above }
    }

    /// The next row.
    #[inline(always)]
    pub(super) fn next_row(&mut self) -> f32x8 {
        let below = self.simd.between_columns(self.plane.run(self.x, self.y, LANES + 1), self.right);
        let row = self.simd.between(self.above, below, self.down);
        (self.y, self.above) = (self.y + 1, below);
        row
    }
}
