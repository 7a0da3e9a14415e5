//! Whether what was found looks like what was looked for.

// With indices the loops read as the formulas do, and the compiler makes vectors of them.
#![allow(clippy::needless_range_loop)]

use super::patch::{Patch, between_columns, corner_of};
use crate::frontend::image::Plane;

/// The correlation of the patch with the window of `plane` around `centre`, -1 to 1; 0 where one of the two is flat, or there is no
/// window.
#[inline(always)]
pub(super) fn likeness<const L: usize, const W: usize>(
    patch: &Patch<L, W>,
    plane: &Plane,
    centre: [f32; 2],
) -> f32 {
    let Some(([x, y], [fx, fy])) = corner_of(plane, centre, patch.window) else { return 0.0 };
    let zero = patch.light.zero;
    let mut sums = [[0.0f32; L]; 5];
    let row = |dy: usize| plane.run(x, y + dy as isize, L + 1);
    let mut above = between_columns::<L>(row(patch.rows.start), fx);
    for r in patch.rows.clone() {
        let below = between_columns::<L>(row(r + 1), fx);
        let grey = &patch.grey[r];
        for i in 0..L {
            let a = grey[i] - zero;
            let b = above[i] + fy * (below[i] - above[i]) - zero;
            sums[0][i] += a;
            sums[1][i] += b;
            sums[2][i] += a * a;
            sums[3][i] += a * b;
            sums[4][i] += b * b;
        }
        above = below;
    }
    let [s0, s1, s2, s3, s4] = &sums;
    let [a, b] = [patch.total(s0), patch.total(s1)];
    let [aa, ab, bb] = [patch.total(s2), patch.total(s3), patch.total(s4)];
    let inverse = 1.0 / (patch.rows.len() as f32 * patch.total(&[1.0; L])).max(1.0);
    let (va, vb) = (aa - a * a * inverse, bb - b * b * inverse);
    let spread = (va * vb).sqrt();
    // NaN, where rounding made a variance negative, is not above.
    if spread > 0.0 { (ab - a * b * inverse) / spread } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::super::Illumination;
    use super::*;
    use dpn_core::GrayImage;

    fn plane(value: impl Fn(usize, usize) -> f64) -> Plane {
        Plane::new(GrayImage::from_fn(60, 50, |x, y| value(x, y).round() as u8).unwrap().view())
    }

    fn scene(x: usize, y: usize) -> f64 {
        120.0 + 40.0 * (0.3 * x as f64).sin() + 30.0 * (0.4 * y as f64 + 0.1 * x as f64).cos()
    }

    fn noise(x: usize, y: usize) -> f64 {
        f64::from(((x * 7919 + y * 104_729) as u32).wrapping_mul(2_654_435_761) >> 24)
    }

    #[test]
    fn itself_under_another_light_is_alike_its_negative_is_not_and_noise_is_in_between() {
        for illumination in [Illumination::Constant, Illumination::GainOffset] {
            // In the middle, and at the edge, where half of the window is outside.
            for centre in [[30.2, 25.7], [2.5, 47.25]] {
                let mut patch = Patch::<24, 32>::new(21);
                assert!(patch.take(&plane(scene), centre, illumination));
                let of = |value: &dyn Fn(usize, usize) -> f64| likeness(&patch, &plane(value), centre);
                assert!(of(&scene) > 0.9999);
                assert!(of(&|x, y| 0.5 * scene(x, y) + 70.0) > 0.99);
                assert!(of(&|x, y| 255.0 - scene(x, y)) < -0.999);
                assert!(of(&noise).abs() < 0.2, "{}", of(&noise));
                assert_eq!(of(&|_, _| 130.0), 0.0);
            }
            let mut patch = Patch::<24, 32>::new(21);
            assert!(patch.take(&plane(scene), [30.0, 25.0], illumination));
            assert_eq!(likeness(&patch, &plane(scene), [f32::NAN, 3.0]), 0.0);
        }
    }
}
