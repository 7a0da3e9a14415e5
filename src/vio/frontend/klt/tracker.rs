//! Points from one pyramid to the next.

use super::affine::refine;
use super::config::KltConfig;
use super::lanes::{Lanes, dispatch};
use super::likeness::likeness;
use super::patch::{OnWindows, Patch};
use super::search::{Outcome, search};
use super::template::{Held, Template};
use crate::frontend::image::{Plane, Pyramid};
use crate::frontend::report::LostBy;

/// What is not the last search ends at so many times the step.
const COARSE: f32 = 4.0;

/// A point in the first image, and where to begin looking for it in the second \[px\].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Shift {
    /// Where it is.
    pub from: [f32; 2],
    /// Where it is expected.
    pub guess: [f32; 2],
}

/// Tracks points between pyramids.
#[derive(Debug, Clone, Copy)]
pub struct Klt {
    config: KltConfig,
}

impl Klt {
    /// A tracker with `config`, which [validates](dpn_core::config::Validate).
    pub fn new(config: KltConfig) -> Self {
        Self { config }
    }

    /// Where each point of `from` is in `to` \[px\], in order; `levels` images of both pyramids are used, as far as there are so many.
    ///
    /// The same numbers come out on machines with other vectors: sums are taken in one order.
    pub fn track(
        &self,
        from: &Pyramid,
        to: &Pyramid,
        points: &[Shift],
        levels: usize,
    ) -> Vec<Result<[f32; 2], LostBy>> {
        let mut out = Vec::with_capacity(points.len());
        let job = Job { config: &self.config, from, to, points, levels, out: &mut out };
        dispatch(job);
        out
    }

    /// Moves points of `image` to where their templates are, by part of a pixel; one without a template, or whose template says nothing here,
    /// stays and begins one.
    pub(crate) fn hold<'a>(
        &'a self,
        image: &'a Plane,
        points: impl Iterator<Item = (&'a mut Option<Template>, &'a mut [f32; 2])>,
    ) {
        dispatch(Held { config: &self.config, plane: image, points });
    }
}

struct Job<'a> {
    config: &'a KltConfig,
    from: &'a Pyramid,
    to: &'a Pyramid,
    points: &'a [Shift],
    levels: usize,
    out: &'a mut Vec<Result<[f32; 2], LostBy>>,
}

impl OnWindows for Job<'_> {
    fn window(&self) -> usize {
        self.config.window
    }

    #[inline(always)]
    fn each<S: Lanes, const L: usize, const W: usize>(self, simd: S) {
        let levels = self.levels.min(self.from.planes().len()).min(self.to.planes().len());
        let mut patch = Patch::<L, W>::new(self.config.window);
        for point in self.points {
            self.out.push(one(simd, &mut patch, self.config, self.from, self.to, point, levels));
        }
    }
}

#[inline(always)]
fn one<S: Lanes, const L: usize, const W: usize>(
    simd: S,
    patch: &mut Patch<L, W>,
    config: &KltConfig,
    from: &Pyramid,
    to: &Pyramid,
    point: &Shift,
    levels: usize,
) -> Result<[f32; 2], LostBy> {
    let mut shift = [point.guess[0] - point.from[0], point.guess[1] - point.from[1]];
    for level in (0..levels).rev() {
        let scale = 1.0 / (1u32 << level) as f32;
        let centre = point.from.map(|c| c * scale);
        let start = [centre[0] + shift[0] * scale, centre[1] + shift[1] * scale];
        // On a coarse level a point that cannot be found keeps its guess; the finest decides.
        if !patch.take(simd, &from.planes()[level], centre) {
            if level == 0 {
                return Err(LostBy::Outside);
            }
            continue;
        }
        // A finer level, or the affine step, goes on from here.
        let coarse = level > 0 || config.affine;
        let epsilon = if coarse { COARSE } else { 1.0 } * config.epsilon_px as f32;
        match search(simd, patch, &to.planes()[level], start, config, epsilon) {
            Outcome::At(place) => shift = [0, 1].map(|i| (place[i] - centre[i]) / scale),
            Outcome::Outside if level == 0 => return Err(LostBy::Outside),
            Outcome::Flat if level == 0 => return Err(LostBy::Flat),
            Outcome::Outside | Outcome::Flat => {}
        }
    }
    let mut place = [point.from[0] + shift[0], point.from[1] + shift[1]];
    let base = to.planes().first().ok_or(LostBy::Outside)?;
    if config.affine && levels > 0 {
        // Where nothing finer can be told the shift stands; whether it looks alike is asked below.
        let step = refine(simd, patch, base, place).unwrap_or_default();
        place = [place[0] + step[0], place[1] + step[1]];
    }
    let inside = (0.0..=(base.width() - 1) as f32).contains(&place[0])
        && (0.0..=(base.height() - 1) as f32).contains(&place[1]);
    if !inside {
        return Err(LostBy::Outside);
    }
    // With one level at least the patch is the finest one's now.
    let least = config.min_correlation as f32;
    let alike = least == 0.0 || levels == 0 || likeness(simd, patch, base, place) >= least;
    if alike { Ok(place) } else { Err(LostBy::Unlike) }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use dpn_core::{GrayImage, GrayView};
    use proptest::prelude::*;

    /// A smooth surface without a period in the image, so that only one shift fits.
    pub(in super::super) fn surface(x: f64, y: f64) -> f64 {
        128.0
            + 30.0 * (0.31 * x + 0.11 * y).sin()
            + 30.0 * (0.27 * y - 0.07 * x).cos()
            + 25.0 * (0.083 * x * 0.7 + 0.05 * y).sin() * (0.061 * y).cos()
            + 20.0 * (0.0009 * (x * x + 0.5 * y * y)).sin()
    }

    /// Where points are by shifts in a light that does not change, as OpenCV's tracker takes it.
    struct Steady<'a>(Job<'a>);

    impl OnWindows for Steady<'_> {
        fn window(&self) -> usize {
            self.0.window()
        }

        fn each<S: Lanes, const L: usize, const W: usize>(self, simd: S) {
            let Self(Job { config, from, to, points, levels, out }) = self;
            let mut patch = Patch::<L, W>::new(config.window);
            for point in points {
                let mut shift = [point.guess[0] - point.from[0], point.guess[1] - point.from[1]];
                let mut found = Err(LostBy::Outside);
                for level in (0..levels).rev() {
                    let scale = 1.0 / (1u32 << level) as f32;
                    let centre = point.from.map(|c| c * scale);
                    let start = [centre[0] + shift[0] * scale, centre[1] + shift[1] * scale];
                    if !patch.take(simd, &from.planes()[level], centre) {
                        continue;
                    }
                    patch.keep_light();
                    let epsilon = if level > 0 { COARSE } else { 1.0 } * config.epsilon_px as f32;
                    if let Outcome::At(place) =
                        search(simd, &patch, &to.planes()[level], start, config, epsilon)
                    {
                        shift = [0, 1].map(|i| (place[i] - centre[i]) / scale);
                        found = Ok([point.from[0] + shift[0], point.from[1] + shift[1]]);
                    }
                }
                out.push(found);
            }
        }
    }

    pub(in super::super::super) fn track_in_steady_light(
        config: KltConfig,
        [from, to]: [&Pyramid; 2],
        points: &[Shift],
        levels: usize,
    ) -> Vec<Result<[f32; 2], LostBy>> {
        let mut out = Vec::new();
        dispatch(Steady(Job { config: &config, from, to, points, levels, out: &mut out }));
        out
    }

    fn pyramid(shift: [f64; 2], gain: f64, offset: f64) -> Pyramid {
        let image = GrayImage::from_fn(160, 140, |x, y| {
            (gain * surface(x as f64 - shift[0], y as f64 - shift[1]) + offset).round().clamp(0.0, 255.0)
                as u8
        });
        Pyramid::new(image.unwrap().view(), 4)
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(24))]
        #[test]
        fn a_shifted_surface_is_found_to_a_thirtieth_pixel(
            // With fewer than 13 pixels a side some other part of so smooth a surface looks the same under another light (2 of 525
            // random places).
            dx in -9.0..9.0f64, dy in -9.0..9.0f64, px in 40.0..120.0f32, py in 40.0..100.0f32, window in 6..15usize,
        ) {
            let (from, to) = (pyramid([0.0; 2], 1.0, 0.0), pyramid([dx, dy], 1.0, 0.0));
            let klt = Klt::new(KltConfig { window: 2 * window + 1, ..KltConfig::default() });
            let guess = [px + (0.8 * dx) as f32, py + (0.8 * dy) as f32];
            let found = klt.track(&from, &to, &[Shift { from: [px, py], guess }], 4)[0].unwrap();
            let error = (f64::from(found[0]) - f64::from(px) - dx).hypot(f64::from(found[1]) - f64::from(py) - dy);
            // Rounding to whole grey values moves small windows more.
            prop_assert!(error < if window < 7 { 0.08 } else { 0.033 }, "window {window}: {error}");
        }
    }

    #[test]
    fn gain_and_offset_move_nothing() {
        let from = pyramid([0.0; 2], 1.0, 0.0);
        let points: Vec<Shift> = (0..5)
            .map(|i| [40.0 + 17.0 * i as f32, 50.0 + 9.0 * i as f32])
            .map(|from| Shift { from, guess: from })
            .collect();
        for (gain, offset) in [(0.6, 60.0), (0.5, 0.0), (1.2, -40.0)] {
            let to = pyramid([2.3, -1.6], gain, offset);
            let found = Klt::new(KltConfig::default()).track(&from, &to, &points, 4);
            let worst = points.iter().zip(found).fold(0.0f32, |worst, (point, found)| {
                let error = found.map_or(f32::INFINITY, |found| {
                    (found[0] - point.from[0] - 2.3).hypot(found[1] - point.from[1] + 1.6)
                });
                worst.max(error)
            });
            assert!(worst < 0.03, "{gain} {offset}: {worst}");
        }
    }

    #[test]
    fn flat_and_striped_windows_are_not_tracked() {
        let flat = GrayImage::from_fn(100, 100, |_, _| 77).unwrap();
        let stripes = GrayImage::from_fn(100, 100, |x, _| if x % 8 < 4 { 50 } else { 200 }).unwrap();
        let point = Shift { from: [50.0, 50.0], guess: [50.0, 50.0] };
        for image in [flat, stripes] {
            let pyramid = Pyramid::new(image.view(), 3);
            let found = Klt::new(KltConfig::default()).track(&pyramid, &pyramid, &[point], 3);
            assert_eq!(found, [Err(LostBy::Flat)]);
        }
    }

    #[test]
    fn no_position_and_no_image_makes_it_panic() {
        let noise: Vec<u8> = (0..70 * 50u32).map(|i| (i.wrapping_mul(2_654_435_761) >> 24) as u8).collect();
        let sizes = [(70, 50), (1, 1), (9, 33), (33, 9)];
        let pyramids = sizes.map(|(w, h)| Pyramid::new(GrayView::new(w, h, w, &noise).unwrap(), 4));
        let places = [-1e9, -31.0, -10.5, -0.1, 0.0, 8.5, 49.0, 75.0, 1e9, f32::NAN, f32::INFINITY];
        let mut points = Vec::new();
        for x in places {
            for y in places {
                points.push(Shift { from: [x, y], guess: [y, x] });
                points.push(Shift { from: [5.0, 5.0], guess: [y, x] });
            }
        }
        for from in &pyramids {
            for to in &pyramids {
                for window in [7, 13, 15, 21, 29] {
                    let klt = Klt::new(KltConfig {
                        window,
                        min_eigenvalue: 0.0,
                        min_correlation: 0.0,
                        ..KltConfig::default()
                    });
                    let found = klt.track(from, to, &points, 4);
                    assert!(found.iter().flatten().all(|place| place.iter().all(|c| c.is_finite())));
                }
            }
        }
    }
}
