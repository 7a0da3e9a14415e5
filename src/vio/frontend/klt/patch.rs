//! The window that is looked for: grey values, gradients, and their normal matrix.
//!
//! Rows are arrays of `L` numbers, a multiple of [`LANES`] and at least two more than the window is wide, so that every loop over them is
//! whole vectors. Sums are taken down the rows of [`LANES`] columns, which stay in registers, then of the next. What columns past the
//! window, or outside the image, add to a sum is taken out of its lanes in the end; rows outside the image are left out. Their mirrored
//! values are no measurement.
//!
//! Light may change by a gain and an offset of each patch's own: gradients made orthogonal to a constant and to the grey values `I` stand in the normal equations. They need not
//! be made: with `c = I - mean I` and `k = sum(c g) / sum(c c)`, sums over `g - mean g - k c` follow from sums over `g`, `I` and 1.

use super::between::RowsBetween;
use super::lanes::{LANES, Lanes, OnLanes, Sums, part, put};
use crate::frontend::image::Plane;
use std::ops::Range;

/// What is done with windows, whose rows are arrays of a length that the compiler knows.
pub(super) trait OnWindows {
    /// A window's side \[px\].
    fn window(&self) -> usize;
    /// Does it, with [`Patch`]es of `L` and `W`.
    fn each<S: Lanes, const L: usize, const W: usize>(self, simd: S);
}

impl<T: OnWindows> OnLanes for T {
    #[inline(always)]
    fn run<S: Lanes>(self, simd: S) {
        match self.window() {
            0..=14 => self.each::<S, 16, 24>(simd),
            15..=22 => self.each::<S, 24, 32>(simd),
            _ => self.each::<S, 32, 40>(simd),
        }
    }
}

/// Windows of up to `L - 2` px a side; `W` is at least `L + 2`.
pub(super) struct Patch<const L: usize, const W: usize> {
    pub(super) window: usize,
    /// Rows that lie in the image.
    pub(super) rows: Range<usize>,
    /// Grey values.
    pub(super) grey: [[f32; L]; L],
    /// Gradient in x \[grey/px\].
    pub(super) grad_x: [[f32; L]; L],
    /// Gradient in y.
    pub(super) grad_y: [[f32; L]; L],
    /// Sums of the gradients' products: xx, xy, yy, of what is orthogonal to light's changes.
    pub(super) normal: [f32; 3],
    /// Grey values and their means, for differences to be rid of changes of light.
    pub(super) light: Light,
    /// 1 for columns that lie in the window and in the image, else 0.
    pub(super) columns: [f32; L],
    /// The interpolated window with a pixel more on every side.
    wide: [[f32; W]; W],
}

/// What is needed to take changes of light out of sums.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Light {
    /// A grey value of the patch, from which others are counted where squares are summed.
    pub(super) zero: f32,
    /// Mean grey value, above `zero`.
    mean: f32,
    /// Sum of the squares of grey values less their mean.
    contrast: f32,
    /// Mean gradient.
    gradient: [f32; 2],
    /// The gradients' slope over the grey values.
    slope: [f32; 2],
}

/// A position as whole pixels and what is left, or nothing where a window there would leave the border.
#[inline(always)]
pub(super) fn corner_of(plane: &Plane, centre: [f32; 2], window: usize) -> Option<([isize; 2], [f32; 2])> {
    let half = (window / 2) as f32;
    let corner = centre.map(|c| c - half);
    let whole = corner.map(f32::floor);
    let reach = -(window as f32);
    let inside = whole[0] >= reach
        && whole[1] >= reach
        && whole[0] < plane.width() as f32
        && whole[1] < plane.height() as f32;
    // NaN is not inside.
    inside.then(|| (whole.map(|w| w as isize), [corner[0] - whole[0], corner[1] - whole[1]]))
}

impl<const L: usize, const W: usize> Patch<L, W> {
    pub(super) fn new(window: usize) -> Self {
        let zero = [[0.0; L]; L];
        Self {
            window: window.min(L - 2),
            rows: 0..0,
            grey: zero,
            grad_x: zero,
            grad_y: zero,
            normal: [0.0; 3],
            light: Light::default(),
            columns: [0.0; L],
            wide: [[0.0; W]; W],
        }
    }

    /// How many pixels count.
    pub(super) fn count(&self) -> f32 {
        self.rows.len() as f32 * self.columns.iter().sum::<f32>()
    }

    /// Takes the window around `centre`; `false` where there is none.
    #[inline(always)]
    pub(super) fn take<S: Lanes>(&mut self, simd: S, plane: &Plane, centre: [f32; 2]) -> bool {
        let window = self.window;
        let Some(([x, y], [fx, fy])) = corner_of(plane, centre, window) else { return false };

        for block in (0..W).step_by(LANES) {
            let mut rows = RowsBetween::new(simd, plane, [x - 1 + block as isize, y - 1], [fx, fy]);
            for out in &mut self.wide[..window + 2] {
                put(out, block, rows.next_row());
            }
        }
        self.columns = inside(x as f32 + fx, plane.width(), window);
        let rows: [f32; L] = inside(y as f32 + fy, plane.height(), window);
        let first = rows.iter().position(|row| *row > 0.0).unwrap_or(0);
        let count = rows.iter().filter(|row| **row > 0.0).count();
        self.rows = first..first + count;
        self.sum_up(simd);
        true
    }

    /// Sums over the gradients as they are, as if light did not change.
    #[cfg(test)]
    pub(super) fn keep_light(&mut self) {
        self.light = Light { zero: self.light.zero, ..Light::default() };
        self.normal = [0.0; 3];
        for r in self.rows.clone() {
            for ((weight, x), y) in self.columns.iter().zip(&self.grad_x[r]).zip(&self.grad_y[r]) {
                for (sum, product) in self.normal.iter_mut().zip([x * x, x * y, y * y]) {
                    *sum += weight * product;
                }
            }
        }
    }

    /// Gradients, and the sums over them.
    #[inline(always)]
    fn sum_up<S: Lanes>(&mut self, simd: S) {
        let middle = self.window / 2;
        let zero = self.wide[middle + 1][middle + 1];
        let [three, ten, share] = [simd.splat_f32s(3.0), simd.splat_f32s(10.0), simd.splat_f32s(1.0 / 32.0)];
        let zeros = simd.splat_f32s(zero);
        let mut lanes = Sums::<S, 9>::new(simd);
        for block in (0..L).step_by(LANES) {
            let mut sums = [simd.splat_f32s(0.0); 9];
            for r in self.rows.clone() {
                let [a, b, c] = [&self.wide[r], &self.wide[r + 1], &self.wide[r + 2]];
                let [a0, a1, a2] = [part(a, block), part(a, block + 1), part(a, block + 2)];
                let [b0, b1, b2] = [part(b, block), part(b, block + 1), part(b, block + 2)];
                let [c0, c1, c2] = [part(c, block), part(c, block + 1), part(c, block + 2)];
                let left = simd.add_f32s(simd.mul_f32s(three, simd.add_f32s(a0, c0)), simd.mul_f32s(ten, b0));
                let right =
                    simd.add_f32s(simd.mul_f32s(three, simd.add_f32s(a2, c2)), simd.mul_f32s(ten, b2));
                let sides = simd.add_f32s(simd.sub_f32s(c0, a0), simd.sub_f32s(c2, a2));
                let gx = simd.mul_f32s(simd.sub_f32s(right, left), share);
                let down = simd.mul_f32s(ten, simd.sub_f32s(c1, a1));
                let gy = simd.mul_f32s(simd.add_f32s(simd.mul_f32s(three, sides), down), share);
                simd.add_product(&mut sums[0], gx, gx);
                simd.add_product(&mut sums[1], gx, gy);
                simd.add_product(&mut sums[2], gy, gy);
                let above = simd.sub_f32s(b1, zeros);
                simd.add_to(&mut sums[3], above);
                simd.add_product(&mut sums[4], above, above);
                simd.add_to(&mut sums[5], gx);
                simd.add_to(&mut sums[6], gy);
                simd.add_product(&mut sums[7], above, gx);
                simd.add_product(&mut sums[8], above, gy);
                put(&mut self.grey[r], block, b1);
                put(&mut self.grad_x[r], block, gx);
                put(&mut self.grad_y[r], block, gy);
            }
            lanes.add(&sums, part(&self.columns, block));
        }
        let [xx, xy, yy, grey, squares, x, y, grey_x, grey_y] = lanes.totals();
        let inverse = 1.0 / self.count().max(1.0);
        let (mean, gradient) = (grey * inverse, [x * inverse, y * inverse]);
        let contrast = (squares - mean * grey).max(0.0);
        // Of c times the gradient.
        let [cx, cy] = [grey_x - mean * x, grey_y - mean * y];
        let slope = if contrast > 0.0 { [cx / contrast, cy / contrast] } else { [0.0; 2] };
        self.light = Light { zero, mean, contrast, gradient, slope };
        self.normal = [
            xx - gradient[0] * x - slope[0] * cx,
            xy - gradient[0] * y - slope[0] * cy,
            yy - gradient[1] * y - slope[1] * cy,
        ];
    }
}

impl Light {
    /// From sums of differences times gradient in x and y, times grey values, and alone: the first two with changes of light taken out, and
    /// the gain's excess over 1.
    #[inline(always)]
    pub(super) fn taken_out(&self, [x, y, grey, alone]: [f32; 4]) -> [f32; 3] {
        let centred = grey - (self.mean + self.zero) * alone;
        let gain = if self.contrast > 0.0 { centred / self.contrast } else { 0.0 };
        [
            x - self.gradient[0] * alone - self.slope[0] * centred,
            y - self.gradient[1] * alone - self.slope[1] * centred,
            gain,
        ]
    }
}

/// 1 for those of `window` pixels from `first` on that lie in an image of `size` pixels, else 0.
#[inline(always)]
fn inside<const L: usize>(first: f32, size: usize, window: usize) -> [f32; L] {
    let mut weights = [0.0; L];
    let last = (size - 1) as f32;
    for (i, weight) in weights.iter_mut().enumerate() {
        let at = first + i as f32;
        *weight = f32::from((at >= 0.0) & (at <= last) & (i < window));
    }
    weights
}

#[cfg(test)]
mod tests {
    use super::*;
    use dpn_core::GrayImage;
    use pulp::Scalar256b;

    type Small = Patch<24, 32>;

    fn wavy(width: usize, height: usize) -> Plane {
        let image = GrayImage::from_fn(width, height, |x, y| {
            (128.0 + 60.0 * (0.21 * x as f64).sin() + 50.0 * (0.17 * y as f64 + 0.1 * x as f64).cos()) as u8
        });
        Plane::new(image.unwrap().view())
    }

    #[test]
    fn gradients_are_those_of_the_surface() {
        let plane = wavy(100, 80);
        let mut patch = Small::new(21);
        assert!(patch.take(Scalar256b, &plane, [50.3, 40.6]));
        for r in 0..21 {
            for i in 0..21 {
                let (x, y) = (40.3 + i as f64, 30.6 + r as f64);
                let phase = 0.17 * y + 0.1 * x;
                let dx = 60.0 * 0.21 * (0.21 * x).cos() - 5.0 * phase.sin();
                let dy = -50.0 * 0.17 * phase.sin();
                // The image is rounded to whole grey values.
                assert!((f64::from(patch.grad_x[r][i]) - dx).abs() < 0.6, "{r} {i}");
                assert!((f64::from(patch.grad_y[r][i]) - dy).abs() < 0.6, "{r} {i}");
            }
        }
    }

    /// The pixels that count, with grey value and gradient.
    fn pixels(patch: &Small) -> Vec<[f64; 3]> {
        let of =
            |r: usize, i: usize| [patch.grey[r][i], patch.grad_x[r][i], patch.grad_y[r][i]].map(f64::from);
        let columns = |r: usize| (0..24).filter(|i| patch.columns[*i] > 0.0).map(move |i| of(r, i));
        patch.rows.clone().flat_map(columns).collect()
    }

    #[test]
    fn outside_the_image_nothing_weighs() {
        let plane = wavy(100, 80);
        let mut patch = Small::new(21);
        assert!(patch.take(Scalar256b, &plane, [3.5, 78.25]));
        // Columns -6.5 to 13.5: the first seven are outside. Rows 68.25 to 88.25: the last ten are.
        assert_eq!(patch.rows, 0..11);
        assert_eq!((patch.count(), pixels(&patch).len()), (14.0 * 11.0, 14 * 11));
        assert!(patch.take(Scalar256b, &plane, [50.0, -3.25]));
        assert_eq!(patch.rows, 14..21);
        assert!(!patch.take(Scalar256b, &plane, [-12.0, 40.0]));
        assert!(!patch.take(Scalar256b, &plane, [f32::NAN, 40.0]));
    }

    #[test]
    fn sums_without_light_are_those_over_gradients_made_orthogonal() {
        let plane = wavy(100, 80);
        let mut patch = Small::new(21);
        for centre in [[50.2, 40.6], [96.2, 40.6], [3.5, 78.25]] {
            assert!(patch.take(Scalar256b, &plane, centre));
            let pixels = pixels(&patch);
            let n = pixels.len() as f64;
            let mean = [0, 1, 2].map(|k| pixels.iter().map(|p| p[k]).sum::<f64>() / n);
            let contrast: f64 = pixels.iter().map(|p| (p[0] - mean[0]).powi(2)).sum();
            let slope = [1, 2]
                .map(|k| pixels.iter().map(|p| (p[0] - mean[0]) * (p[k] - mean[k])).sum::<f64>() / contrast);
            // As it is defined: gradients less their mean and their share of the centred grey values.
            let made = |p: &[f64; 3]| [0, 1].map(|k| p[k + 1] - mean[k + 1] - slope[k] * (p[0] - mean[0]));
            let sum = |value: &dyn Fn(&[f64; 3]) -> f64| pixels.iter().map(value).sum::<f64>();
            let normal = [
                sum(&|p| made(p)[0].powi(2)),
                sum(&|p| made(p)[0] * made(p)[1]),
                sum(&|p| made(p)[1].powi(2)),
            ];
            for (ours, theirs) in patch.normal.iter().zip(normal) {
                assert!((f64::from(*ours) - theirs).abs() < 1e-3 * normal[0], "{centre:?}: {ours} {theirs}");
            }
            // A difference of everything: light, a shift, and something else.
            let difference = |p: &[f64; 3]| 7.0 + 0.1 * p[0] + 0.3 * p[1] - 0.2 * p[2] + (p[0] * 0.7).sin();
            let raw = [
                sum(&|p| difference(p) * p[1]),
                sum(&|p| difference(p) * p[2]),
                sum(&|p| difference(p) * p[0]),
                sum(&difference),
            ];
            let [x, y, excess] = patch.light.taken_out(raw.map(|v| v as f32));
            for (k, ours) in [x, y].into_iter().enumerate() {
                let theirs = sum(&|p| difference(p) * made(p)[k]);
                assert!((f64::from(ours) - theirs).abs() < 2e-3 * normal[0], "{centre:?}: {ours} {theirs}");
            }
            let gain = sum(&|p| difference(p) * (p[0] - mean[0])) / contrast;
            assert!((f64::from(excess) - gain).abs() < 1e-3, "{excess} {gain}");
        }
    }
}
