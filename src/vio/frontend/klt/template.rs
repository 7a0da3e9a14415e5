//! The window that a track began with, to which it is held.
//!
//! From image to image the window looked for is that of the last image, so that what each search errs adds up: the point slides over the
//! surface that it began on. Where frames are handed over the first window, the template `I`, is held against the image about the place
//! that the search found, `p`, as far turned, grown and sheared as it was the last time, `W`:
//!
//! ```text
//! J(p + W x) = I(x - s - M x)   gives   W <- W (1 + M),   p <- p + W s
//! ```
//!
//! One step of the affine model ([`affine`](super::affine)) a frame is enough, because the next begins where it ended. Where it says nothing,
//! is long, or the two no longer look alike, the surface is seen in another way than it was: the window as it is now is the template from
//! then on, and the error from there to the first stays.
//!
//! Source: Matthews, Ishikawa and Baker 2004, "The template update problem" (drift correction by the first template); Baker and Matthews 2004
//! (composing a step with the warp).

use super::affine::{Bent, Products, products, solve, with_differences};
use super::config::KltConfig;
use super::lanes::{LANES, Lanes, Sums, part, sum_of};
use super::patch::{OnWindows, Patch};
use crate::frontend::image::Plane;

/// Deviation of each entry of `M` from one frame that is handed over to the next.
const BEND_STD: f64 = 0.05;
/// Least correlation of the template with what is seen, gain and offset aside.
const LEAST_ALIKE: f32 = 0.85;
/// How much smaller or larger in area a template may be seen: beyond it one of the two has detail that the other cannot show.
const AREA: std::ops::RangeInclusive<f32> = 0.6..=1.7;
/// Images with a longer side have no templates: positions have 16 bits before the point \[px\].
const LONGEST_PX: usize = 1 << 15;

/// The window around a point as it was when it began.
#[derive(Debug, Clone)]
pub(crate) struct Template {
    /// Grey values, then gradients in x and in y, row after row, each row in whole vectors.
    rows: Box<[f32]>,
    /// The grey value from which others are counted.
    zero: f32,
    /// What no image changes of the sums.
    products: Box<Products>,
    /// From offsets in the template to offsets in the image, row after row.
    warp: [[f32; 2]; 2],
}

impl Template {
    /// The window around `centre`; `None` where it is not wholly in the image.
    #[inline(always)]
    fn take<S: Lanes, const L: usize, const W: usize>(
        simd: S,
        patch: &mut Patch<L, W>,
        plane: &Plane,
        centre: [f32; 2],
    ) -> Option<Self> {
        let whole = inside(plane, centre, [(patch.window / 2) as f32; 2])
            && plane.width().max(plane.height()) < LONGEST_PX
            && patch.take(simd, plane, centre);
        if !whole {
            return None;
        }
        let products = products(simd, patch, plane, centre).expect("the window is in the image");
        let kept = [&patch.grey, &patch.grad_x, &patch.grad_y];
        let rows = kept.iter().flat_map(|rows| rows[..patch.window].as_flattened()).copied().collect();
        Some(Self {
            rows,
            zero: patch.light.zero,
            products: Box::new(products),
            warp: [[1.0, 0.0], [0.0, 1.0]],
        })
    }

    /// Grey values of `plane` where the template's pixels are about `place`; `false` where some are outside.
    #[inline(always)]
    fn sample<const L: usize>(
        &self,
        plane: &Plane,
        place: [f32; 2],
        window: usize,
        seen: &mut [[f32; L]; L],
    ) -> bool {
        let [[xx, xy], [yx, yy]] = self.warp;
        let half = (window / 2) as f32;
        if !inside(plane, place, [half * (xx.abs() + xy.abs()), half * (yx.abs() + yy.abs())]) {
            return false;
        }
        for (r, row) in seen[..window].iter_mut().enumerate() {
            let down = r as f32 - half;
            let first = [place[0] + xy * down - xx * half, place[1] + yy * down - yx * half];
            plane.along(first, [xx, yx], &mut row[..window]);
        }
        true
    }

    /// How the template has to move to what was `seen` of it.
    #[inline(always)]
    fn bend<S: Lanes, const L: usize>(&self, simd: S, seen: &[[f32; L]; L], window: usize) -> Option<Bent> {
        let half = (window / 2) as f32;
        let zero = simd.splat_f32s(self.zero);
        let (grey, rest) = self.rows.split_at(window * L);
        let (grad_x, grad_y) = rest.split_at(window * L);
        // Gradients x and y by difference, each with 1 and y: over columns as they are, and weighed by x.
        let mut once = Sums::<S, 7>::new(simd);
        let mut across = [simd.splat_f32s(0.0); 4];
        for block in (0..L).step_by(LANES) {
            let mut sums = [simd.splat_f32s(0.0); 7];
            for r in 0..window {
                let own = part(&grey[r * L..], block);
                let difference = simd.sub_f32s(part(&seen[r], block), own);
                let down = simd.splat_f32s(r as f32 - half);
                let x = simd.mul_f32s(part(&grad_x[r * L..], block), difference);
                let y = simd.mul_f32s(part(&grad_y[r * L..], block), difference);
                simd.add_to(&mut sums[0], x);
                simd.add_product(&mut sums[1], down, x);
                simd.add_to(&mut sums[2], y);
                simd.add_product(&mut sums[3], down, y);
                simd.add_product(&mut sums[4], difference, simd.sub_f32s(own, zero));
                simd.add_to(&mut sums[5], difference);
                simd.add_product(&mut sums[6], difference, difference);
            }
            let (mut columns, mut weights) = ([0.0f32; LANES], [0.0f32; LANES]);
            for i in (0..LANES).filter(|i| block + i < window) {
                (columns[i], weights[i]) = (1.0, (block + i) as f32 - half);
            }
            once.add(&sums, part(&columns, 0));
            for (across, sum) in across.iter_mut().zip(&sums) {
                simd.add_product(across, *sum, part(&weights, 0));
            }
        }
        let once = once.totals().map(f64::from);
        let by_gradient = [0, 1, 2, 3].map(|k| [once[k], f64::from(sum_of(across[k]))]);
        let total = with_differences(&self.products, by_gradient, [once[4], once[5], once[6]]);
        solve(&total, (window * window) as f64, BEND_STD)
    }

    /// One step: where the template is; `None` where it does not say.
    #[inline(always)]
    fn step<S: Lanes, const L: usize>(
        &mut self,
        simd: S,
        seen: &mut [[f32; L]; L],
        plane: &Plane,
        place: [f32; 2],
        config: &KltConfig,
    ) -> Option<[f32; 2]> {
        if !self.sample(plane, place, config.window, seen) {
            return None;
        }
        let bent = self.bend(simd, seen, config.window)?;
        let [[mxx, mxy], [myx, myy]] = bent.matrix;
        let warp = self.warp.map(|[a, b]| [a + a * mxx + b * myx, b + a * mxy + b * myy]);
        let area = warp[0][0] * warp[1][1] - warp[0][1] * warp[1][0];
        if bent.alike < LEAST_ALIKE || !AREA.contains(&area) {
            return None;
        }
        self.warp = warp;
        let [sx, sy] = bent.shift;
        Some([0, 1].map(|i| place[i] + warp[i][0] * sx + warp[i][1] * sy))
    }
}

/// Whether all within `reach` of `place` lie in the image, right and lower neighbours too; a pixel is left for rounding.
fn inside(plane: &Plane, place: [f32; 2], reach: [f32; 2]) -> bool {
    let size = [plane.width(), plane.height()];
    // NaN is not inside.
    (0..2).all(|i| place[i] - reach[i] >= 1.0 && place[i] + reach[i] <= size[i] as f32 - 3.0)
}

/// Points of one image with their templates: each is held to its own, or begins one.
pub(super) struct Held<'a, I> {
    pub(super) config: &'a KltConfig,
    pub(super) plane: &'a Plane,
    pub(super) points: I,
}

impl<'a, I: Iterator<Item = (&'a mut Option<Template>, &'a mut [f32; 2])>> OnWindows for Held<'a, I> {
    fn window(&self) -> usize {
        self.config.window
    }

    #[inline(always)]
    fn each<S: Lanes, const L: usize, const W: usize>(self, simd: S) {
        let mut patch = Patch::<L, W>::new(self.config.window);
        let mut seen = [[0.0; L]; L];
        for (template, px) in self.points {
            let held = template.as_mut().and_then(|t| t.step(simd, &mut seen, self.plane, *px, self.config));
            match held {
                Some(place) => *px = place,
                None => *template = Template::take(simd, &mut patch, self.plane, *px),
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::tracker::tests::surface;
    use super::super::{Klt, Shift};
    use super::*;
    use crate::frontend::image::Pyramid;
    use dpn_core::GrayImage;
    use proptest::prelude::*;

    const SIZE: [usize; 2] = [160, 140];

    /// The surface about `from` as seen about `to`: `warp` takes offsets from the one to offsets from the other.
    fn seen(
        from: [f64; 2],
        to: [f64; 2],
        warp: [[f64; 2]; 2],
        noise: impl Fn(usize, usize) -> f64,
    ) -> GrayImage {
        let [[a, b], [c, d]] = warp;
        let det = a * d - b * c;
        let value = |x: usize, y: usize| {
            let [u, v] = [x as f64 - to[0], y as f64 - to[1]];
            let back = [from[0] + (d * u - b * v) / det, from[1] + (a * v - c * u) / det];
            (surface(back[0], back[1]) + noise(x, y)).round().clamp(0.0, 255.0) as u8
        };
        GrayImage::from_fn(SIZE[0], SIZE[1], value).unwrap()
    }

    fn f64s(px: [f32; 2]) -> [f64; 2] {
        px.map(f64::from)
    }

    fn distance(a: [f32; 2], b: [f64; 2]) -> f64 {
        (f64::from(a[0]) - b[0]).hypot(f64::from(a[1]) - b[1])
    }

    fn take(config: KltConfig, plane: &Plane, px: [f32; 2]) -> Option<Template> {
        let (mut template, mut px) = (None, px);
        Klt::new(config).hold(plane, std::iter::once((&mut template, &mut px)));
        template
    }

    fn hold(config: KltConfig, image: &GrayImage, template: &mut Option<Template>, px: &mut [f32; 2]) {
        Klt::new(config).hold(&Plane::new(image.view()), std::iter::once((template, px)));
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(24))]
        #[test]
        fn what_turns_and_grows_bit_by_bit_is_followed_with_its_warp(
            turn in -0.02..0.02f64, grow in -0.01..0.01f64, x in 60.0..90.0f32, y in 60.0..80.0f32, window in 9..15usize,
        ) {
            let config = KltConfig { window: 2 * window + 1, ..KltConfig::default() };
            let first = [x, y];
            let image = seen(f64s(first), f64s(first), [[1.0, 0.0], [0.0, 1.0]], |_, _| 0.0);
            let mut template = take(config, &Plane::new(image.view()), first);
            let (mut px, mut goal, mut warp) = (first, f64s(first), [[1.0, 0.0], [0.0, 1.0]]);
            for k in 1..=15 {
                let scale = (grow * f64::from(k)).exp();
                let (sin, cos) = (turn * f64::from(k)).sin_cos();
                warp = [[scale * cos, -scale * sin], [scale * sin, scale * cos]];
                goal = [goal[0] + 0.21, goal[1] - 0.13];
                // What a search found, a fifth of a pixel off.
                px = [(goal[0] + 0.15) as f32, (goal[1] - 0.13) as f32];
                hold(config, &seen(f64s(first), goal, warp, |_, _| 0.0), &mut template, &mut px);
            }
            prop_assert!(distance(px, goal) < 0.03, "{} px", distance(px, goal));
            let found = template.unwrap().warp;
            for i in 0..2 {
                for j in 0..2 {
                    let error = f64::from(found[i][j]) - warp[i][j];
                    prop_assert!(error.abs() < 0.02, "{found:?} for {warp:?}");
                }
            }
        }
    }

    #[test]
    fn over_a_hundred_noisy_images_a_held_track_stays_and_another_slides() {
        let noise = |k: u32| {
            move |x: usize, y: usize| {
                let hash = (x as u32 * 7919 + y as u32 * 104_729 + k * 1_299_709).wrapping_mul(2_654_435_761);
                let hash = (hash ^ (hash >> 15)).wrapping_mul(2_246_822_519);
                24.0 * (f64::from(hash >> 16) / 65536.0 - 0.5)
            }
        };
        let config = KltConfig::default();
        let klt = Klt::new(config);
        let firsts: Vec<[f32; 2]> =
            (0..12).map(|i| [45.0 + 18.0 * (i % 4) as f32, 45.0 + 20.0 * (i / 4) as f32]).collect();
        let mean_error = |held: bool| {
            let mut last =
                Pyramid::new(seen([0.0; 2], [0.0; 2], [[1.0, 0.0], [0.0, 1.0]], noise(0)).view(), 2);
            let mut points: Vec<(Option<Template>, [f32; 2])> =
                firsts.iter().map(|px| (take(config, &last.planes()[0], *px), *px)).collect();
            let shift = |k: u32| [3.0 * (0.17 * f64::from(k)).sin(), 2.0 * (0.11 * f64::from(k)).sin()];
            for k in 1..=100 {
                let to = shift(k);
                let image = Pyramid::new(seen([0.0; 2], to, [[1.0, 0.0], [0.0, 1.0]], noise(k)).view(), 2);
                let shifts: Vec<Shift> =
                    points.iter().map(|(_, px)| Shift { from: *px, guess: *px }).collect();
                for (point, place) in points.iter_mut().zip(klt.track(&last, &image, &shifts, 2)) {
                    point.1 = place.expect("a strong corner");
                }
                if held {
                    klt.hold(&image.planes()[0], points.iter_mut().map(|(template, px)| (template, px)));
                }
                last = image;
            }
            let to = shift(100);
            let goals = firsts.iter().map(|px| [f64::from(px[0]) + to[0], f64::from(px[1]) + to[1]]);
            points.iter().zip(goals).map(|((_, px), goal)| distance(*px, goal)).sum::<f64>() / 12.0
        };
        let (held, free) = (mean_error(true), mean_error(false));
        eprintln!("after 100 images: held {held:.3} px, free {free:.3} px");
        assert!(held < 0.12 && held < 0.4 * free, "held {held} px, free {free} px");
    }

    #[test]
    fn a_window_that_changed_altogether_is_the_template_from_then_on() {
        let config = KltConfig::default();
        let here = [70.3f32, 65.6];
        let still = [[1.0, 0.0], [0.0, 1.0]];
        let image = seen([0.0; 2], [0.0; 2], still, |_, _| 0.0);
        let mut template = take(config, &Plane::new(image.view()), here);
        let first = template.clone().unwrap();
        // Another place of the surface.
        let other = seen([40.0, -25.0], [0.0; 2], still, |_, _| 0.0);
        let mut px = here;
        hold(config, &other, &mut template, &mut px);
        assert_eq!(px, here);
        assert_ne!(template.unwrap().rows, first.rows);
    }

    #[test]
    fn at_the_edge_there_is_no_template_and_no_place_makes_it_panic() {
        let config = KltConfig::default();
        let plane = Plane::new(seen([0.0; 2], [0.0; 2], [[1.0, 0.0], [0.0, 1.0]], |_, _| 0.0).view());
        let bounds = [11.0, SIZE[0] as f32 - 13.0];
        for x in [bounds[0], bounds[1]] {
            assert!(take(config, &plane, [x, 60.0]).is_some(), "{x}");
        }
        let tiny = Plane::new(GrayImage::from_fn(9, 5, |x, y| (x * y) as u8).unwrap().view());
        for x in [f32::NAN, f32::INFINITY, -1e9, -3.0, 0.0, 10.9, 148.0, 159.0, 1e9] {
            assert!(take(config, &plane, [x, 60.0]).is_none(), "{x}");
            let inner = take(config, &plane, [80.0, 60.0]);
            for image in [&plane, &tiny] {
                let (mut template, mut px) = (inner.clone(), [60.0, x]);
                Klt::new(config).hold(image, std::iter::once((&mut template, &mut px)));
            }
        }
    }
}
