//! Whether what was found looks like what was looked for.

use super::between::RowsBetween;
use super::lanes::{LANES, Lanes, Sums, part};
use super::patch::{Patch, corner_of};
use crate::frontend::image::Plane;

/// The correlation of the patch with the window of `plane` around `centre`, -1 to 1; 0 where one of the two is flat, or there is no
/// window.
#[inline(always)]
pub(super) fn likeness<S: Lanes, const L: usize, const W: usize>(
    simd: S,
    patch: &Patch<L, W>,
    plane: &Plane,
    centre: [f32; 2],
) -> f32 {
    let Some(([x, y], rest)) = corner_of(plane, centre, patch.window) else { return 0.0 };
    let zero = simd.splat_f32s(patch.light.zero);
    let mut lanes = Sums::<S, 5>::new(simd);
    for block in (0..L).step_by(LANES) {
        let mut sums = [simd.splat_f32s(0.0); 5];
        let mut rows =
            RowsBetween::new(simd, plane, [x + block as isize, y + patch.rows.start as isize], rest);
        for r in patch.rows.clone() {
            let a = simd.sub_f32s(part(&patch.grey[r], block), zero);
            let b = simd.sub_f32s(rows.next_row(), zero);
            simd.add_to(&mut sums[0], a);
            simd.add_to(&mut sums[1], b);
            simd.add_product(&mut sums[2], a, a);
            simd.add_product(&mut sums[3], a, b);
            simd.add_product(&mut sums[4], b, b);
        }
        lanes.add(&sums, part(&patch.columns, block));
    }
    let [a, b, aa, ab, bb] = lanes.totals();
    let inverse = 1.0 / patch.count().max(1.0);
    let (va, vb) = (aa - a * a * inverse, bb - b * b * inverse);
    let spread = (va * vb).sqrt();
    // NaN, where rounding made a variance negative, is not above.
    if spread > 0.0 { (ab - a * b * inverse) / spread } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use dpn_core::GrayImage;
    use pulp::Scalar256b;

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
        // In the middle, and at the edge, where half of the window is outside.
        for centre in [[30.2, 25.7], [2.5, 47.25]] {
            let mut patch = Patch::<24, 32>::new(21);
            assert!(patch.take(Scalar256b, &plane(scene), centre));
            let of =
                |value: &dyn Fn(usize, usize) -> f64| likeness(Scalar256b, &patch, &plane(value), centre);
            assert!(of(&scene) > 0.9999);
            assert!(of(&|x, y| 0.5 * scene(x, y) + 70.0) > 0.99);
            assert!(of(&|x, y| 255.0 - scene(x, y)) < -0.999);
            assert!(of(&noise).abs() < 0.2, "{}", of(&noise));
            assert_eq!(of(&|_, _| 130.0), 0.0);
        }
        let mut patch = Patch::<24, 32>::new(21);
        assert!(patch.take(Scalar256b, &plane(scene), [30.0, 25.0]));
        assert_eq!(likeness(Scalar256b, &patch, &plane(scene), [f32::NAN, 3.0]), 0.0);
    }
}
