//! The window that is looked for: grey values, gradients, and their normal matrix.
//!
//! Rows are arrays of `L` numbers, a multiple of eight and at least two more than the window is wide, so that every loop over them is
//! whole vectors. Columns past the window have gradient 0 and weigh nothing; so have pixels outside the image, whose mirrored values
//! are no measurement.

// With indices the loops read as the formulas do, and the compiler makes vectors of them.
#![allow(clippy::needless_range_loop)]

use super::config::Illumination;
use crate::frontend::image::Plane;

/// Windows of up to `L - 2` px a side.
pub(super) struct Patch<const L: usize> {
    pub(super) window: usize,
    /// Grey values.
    pub(super) grey: [[f32; L]; L],
    /// Gradient in x \[grey/px\], orthogonal to light's changes where those are fitted.
    pub(super) grad_x: [[f32; L]; L],
    /// Gradient in y.
    pub(super) grad_y: [[f32; L]; L],
    /// Grey values less their mean; used only where light's changes are fitted.
    pub(super) centred: [[f32; L]; L],
    /// 1 for columns that lie in the window and in the image, else 0.
    pub(super) columns: [f32; L],
    /// The same for rows.
    pub(super) rows: [f32; L],
    /// Sum of the squares of `centred`.
    pub(super) contrast: f32,
    /// Sums of the gradients' products: xx, xy, yy.
    pub(super) normal: [f32; 3],
}

/// Grey values of `L` columns half-way between two, `weight` to the right one.
#[inline(always)]
pub(super) fn between_columns<const L: usize>(pixels: &[u8], weight: f32) -> [f32; L] {
    let (left, right) = (&pixels[..L], &pixels[1..][..L]);
    let mut out = [0.0; L];
    for i in 0..L {
        let (a, b) = (f32::from(left[i]), f32::from(right[i]));
        out[i] = a + weight * (b - a);
    }
    out
}

/// The sum of the lanes, the same on every machine.
#[inline(always)]
pub(super) fn total<const L: usize>(lanes: &[f32; L]) -> f32 {
    let mut sums = [0.0; 8];
    for chunk in lanes.chunks_exact(8) {
        for i in 0..8 {
            sums[i] += chunk[i];
        }
    }
    ((sums[0] + sums[4]) + (sums[1] + sums[5])) + ((sums[2] + sums[6]) + (sums[3] + sums[7]))
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

impl<const L: usize> Patch<L> {
    pub(super) fn new(window: usize) -> Self {
        let zero = [[0.0; L]; L];
        Self {
            window: window.min(L - 2),
            grey: zero,
            grad_x: zero,
            grad_y: zero,
            centred: zero,
            columns: [0.0; L],
            rows: [0.0; L],
            contrast: 0.0,
            normal: [0.0; 3],
        }
    }

    /// Takes the window around `centre`; `false` where there is none.
    #[inline(always)]
    pub(super) fn take(&mut self, plane: &Plane, centre: [f32; 2], illumination: Illumination) -> bool {
        let window = self.window;
        let Some(([x, y], [fx, fy])) = corner_of(plane, centre, window) else { return false };

        // A pixel more on every side, for the gradients. Two spare rows keep the loop below free of special cases.
        let mut wide = [[0.0f32; L]; L];
        let row = |dy: usize| plane.run(x - 1, y - 1 + dy as isize, L + 1);
        let mut above = between_columns::<L>(row(0), fx);
        for (dy, out) in wide.iter_mut().enumerate().take(window + 2) {
            let below = between_columns::<L>(row(dy + 1), fx);
            for i in 0..L {
                out[i] = above[i] + fy * (below[i] - above[i]);
            }
            above = below;
        }

        self.columns = self.weights(plane.width(), x as f32 + fx);
        let mut sums = [[0.0f32; L]; 3];
        for r in 0..window {
            let in_image = y as f32 + fy + r as f32;
            let row_weight = f32::from(in_image >= 0.0 && in_image <= (plane.height() - 1) as f32);
            self.rows[r] = row_weight;
            let [a, b, c] = [&wide[r], &wide[r + 1], &wide[r + 2]];
            // Smoothed and differenced over the three rows, for x and for y.
            let mut smooth = [0.0f32; L];
            let mut slope = [0.0f32; L];
            for i in 0..L {
                smooth[i] = 3.0 * (a[i] + c[i]) + 10.0 * b[i];
                slope[i] = c[i] - a[i];
            }
            let (grey, grad_x, grad_y) = (&mut self.grey[r], &mut self.grad_x[r], &mut self.grad_y[r]);
            for i in 0..L - 2 {
                grey[i] = b[i + 1];
                grad_x[i] = (smooth[i + 2] - smooth[i]) * (1.0 / 32.0);
                grad_y[i] = (3.0 * (slope[i] + slope[i + 2]) + 10.0 * slope[i + 1]) * (1.0 / 32.0);
            }
            for i in 0..L {
                let weight = self.columns[i] * row_weight;
                grad_x[i] *= weight;
                grad_y[i] *= weight;
                sums[0][i] += grad_x[i] * grad_x[i];
                sums[1][i] += grad_x[i] * grad_y[i];
                sums[2][i] += grad_y[i] * grad_y[i];
                self.centred[r][i] = weight;
            }
        }
        self.normal = sums.map(|lanes| total(&lanes));
        if illumination == Illumination::GainOffset {
            self.project_out();
        }
        true
    }

    /// 1 for the window's columns that lie in the image, else 0.
    #[inline(always)]
    fn weights(&self, width: usize, first: f32) -> [f32; L] {
        let mut weights = [0.0; L];
        let last = (width - 1) as f32;
        for (i, weight) in weights.iter_mut().enumerate().take(self.window) {
            let x = first + i as f32;
            *weight = f32::from(x >= 0.0 && x <= last);
        }
        weights
    }

    /// Makes the gradients orthogonal to a constant and to the grey values. On entry `centred` holds the pixels' weights.
    #[inline(always)]
    fn project_out(&mut self) {
        let rows = self.window;
        let mut sums = [[0.0f32; L]; 4];
        for r in 0..rows {
            for i in 0..L {
                let weight = self.centred[r][i];
                sums[0][i] += weight;
                sums[1][i] += weight * self.grey[r][i];
                sums[2][i] += self.grad_x[r][i];
                sums[3][i] += self.grad_y[r][i];
            }
        }
        let [count, grey, x, y] = sums.map(|lanes| total(&lanes));
        let count = count.max(1.0);
        let [grey, x, y] = [grey / count, x / count, y / count];

        let mut sums = [[0.0f32; L]; 3];
        for r in 0..rows {
            for i in 0..L {
                let weight = self.centred[r][i];
                let centred = weight * (self.grey[r][i] - grey);
                self.centred[r][i] = centred;
                self.grad_x[r][i] -= weight * x;
                self.grad_y[r][i] -= weight * y;
                sums[0][i] += centred * centred;
                sums[1][i] += centred * self.grad_x[r][i];
                sums[2][i] += centred * self.grad_y[r][i];
            }
        }
        let [contrast, x, y] = sums.map(|lanes| total(&lanes));
        self.contrast = contrast;
        let inverse = if contrast > 0.0 { 1.0 / contrast } else { 0.0 };
        let [x, y] = [x * inverse, y * inverse];

        let mut sums = [[0.0f32; L]; 3];
        for r in 0..rows {
            for i in 0..L {
                let (gx, gy) = (&mut self.grad_x[r][i], &mut self.grad_y[r][i]);
                *gx -= x * self.centred[r][i];
                *gy -= y * self.centred[r][i];
                sums[0][i] += *gx * *gx;
                sums[1][i] += *gx * *gy;
                sums[2][i] += *gy * *gy;
            }
        }
        self.normal = sums.map(|lanes| total(&lanes));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use dpn_core::GrayImage;

    fn wavy(width: usize, height: usize) -> Plane {
        let image = GrayImage::from_fn(width, height, |x, y| {
            (128.0 + 60.0 * (0.21 * x as f64).sin() + 50.0 * (0.17 * y as f64 + 0.1 * x as f64).cos()) as u8
        });
        Plane::new(image.unwrap().view())
    }

    #[test]
    fn gradients_are_those_of_the_surface() {
        let plane = wavy(100, 80);
        let mut patch = Patch::<24>::new(21);
        assert!(patch.take(&plane, [50.3, 40.6], Illumination::Constant));
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
        assert!(patch.grad_x.iter().take(21).all(|row| row[21..].iter().all(|v| *v == 0.0)));
    }

    #[test]
    fn outside_the_image_nothing_weighs() {
        let plane = wavy(100, 80);
        let mut patch = Patch::<24>::new(21);
        for illumination in [Illumination::Constant, Illumination::GainOffset] {
            assert!(patch.take(&plane, [3.5, 78.25], illumination));
            // Columns -6.5 to 13.5: the first seven are outside. Rows 68.25 to 88.25: the last ten are.
            for r in 0..21 {
                for i in 0..24 {
                    let inside = (7..21).contains(&i) && r < 11;
                    let nothing = patch.grad_x[r][i] == 0.0 && patch.grad_y[r][i] == 0.0;
                    assert!(inside || nothing, "{illumination:?} {r} {i}");
                }
            }
        }
        assert!(!patch.take(&plane, [-12.0, 40.0], Illumination::Constant));
        assert!(!patch.take(&plane, [f32::NAN, 40.0], Illumination::Constant));
    }

    #[test]
    fn projected_gradients_are_orthogonal_to_a_constant_and_to_the_patch() {
        let plane = wavy(100, 80);
        let mut patch = Patch::<24>::new(21);
        assert!(patch.take(&plane, [96.2, 40.6], Illumination::GainOffset));
        let (mut constant, mut grey, mut norm) = (0.0, 0.0, 0.0);
        for r in 0..21 {
            for i in 0..24 {
                let g = f64::from(patch.grad_x[r][i]);
                constant += g;
                grey += g * f64::from(patch.grey[r][i]);
                norm += g * g;
            }
        }
        assert!(norm > 1000.0 && constant.abs() < 0.02 && grey.abs() < 2.0, "{constant} {grey} {norm}");
    }
}
