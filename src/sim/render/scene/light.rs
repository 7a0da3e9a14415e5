//! Lamps under the ceiling, a window's light from one side, and what all surfaces throw back.
//!
//! Light on a matt surface: ambient + sum of `max(0, n . l) h^2 / d^2` over lamps + `max(0, n . s)`, l towards the lamp, d its distance, h
//! the room's half height, s towards the window. It is taken on a grid over each rectangle and kept as its best quadratic; there are
//! no shadows. A world's light is 1 in the mean over its surfaces.

use super::rect::{LIGHT_TERMS, Rect};
use nalgebra::{Matrix6, Vector3, Vector6};
use rand::Rng;

/// Points a side at which light is taken.
const GRID: usize = 6;

/// Floor that one lamp lights \[m^2\].
const LAMP_AREA: f64 = 14.0;

/// Light of a window on a surface that faces it.
const WINDOW: f64 = 0.7;

/// The lights of a world.
pub(super) struct Lights {
    lamps: Vec<Vector3<f64>>,
    height: f64,
    ambient: f64,
    to_window: Vector3<f64>,
}

impl Lights {
    /// Lights of the room from `low` to `high`; `ambient` comes from everywhere, beside a lamp's 1.
    pub(super) fn new(low: &Vector3<f64>, high: &Vector3<f64>, ambient: f64, rng: &mut impl Rng) -> Self {
        let size = high - low;
        let count = (size.x * size.y / LAMP_AREA).ceil().clamp(1.0, 40.0) as usize;
        let lamps = (0..count).map(|_| {
            Vector3::new(
                low.x + size.x * (0.1 + 0.8 * rng.random::<f64>()),
                low.y + size.y * (0.1 + 0.8 * rng.random::<f64>()),
                high.z - 0.15 * size.z,
            )
        });
        let lamps = lamps.collect();
        let (sin, cos) = (std::f64::consts::TAU * rng.random::<f64>()).sin_cos();
        Self { lamps, height: 0.5 * size.z, ambient, to_window: Vector3::new(0.9 * cos, 0.9 * sin, 0.436) }
    }

    /// Light on a surface with unit normal `normal` at `point`.
    fn at(&self, point: &Vector3<f64>, normal: &Vector3<f64>) -> f64 {
        let lamps = self.lamps.iter().map(|lamp| {
            let to = lamp - point;
            // A lamp has a size: nothing is nearer to it than half a metre.
            let square = to.norm_squared() + 0.25;
            (normal.dot(&to) / square.sqrt()).max(0.0) * self.height * self.height / square
        });
        self.ambient + lamps.sum::<f64>() + WINDOW * normal.dot(&self.to_window).max(0.0)
    }

    /// Lights all rectangles but those that shine themselves; `texels_per_m` is the unit of the courses.
    pub(super) fn shine(&self, rects: &mut [Rect], texels_per_m: f64) {
        let (mut sum, mut area) = (0.0, 0.0);
        for rect in rects.iter_mut() {
            let course = self.course(rect);
            let of_rect = rect.size[0] * rect.size[1];
            sum += of_rect * mean(&course, rect.size);
            area += of_rect;
            let scale = 1.0 / (texels_per_m * rect.skin.fineness);
            let units = [1.0, scale, scale, scale * scale, scale * scale, scale * scale];
            for ((to, from), unit) in rect.light.iter_mut().zip(&course).zip(units) {
                *to = (from * unit) as f32;
            }
        }
        let level = (sum / area) as f32;
        rects.iter_mut().for_each(|rect| rect.light.iter_mut().for_each(|v| *v /= level));
    }

    /// The best quadratic in u and v \[m\].
    fn course(&self, rect: &Rect) -> [f64; LIGHT_TERMS] {
        let normal = rect.normal();
        let (mut squares, mut sides) = (Matrix6::zeros(), Vector6::zeros());
        let place = |i: usize| (i as f64 + 0.5) / GRID as f64;
        for i in 0..GRID * GRID {
            let (s, t) = (place(i % GRID), place(i / GRID));
            let light = self.at(&rect.point(s * rect.size[0], t * rect.size[1]), &normal);
            let row = Vector6::new(1.0, s, t, s * s, s * t, t * t);
            squares += row * row.transpose();
            sides += light * row;
        }
        // A grid of 6 x 6 determines six terms.
        let found = squares.cholesky().map_or_else(Vector6::zeros, |cholesky| cholesky.solve(&sides));
        let [a, b] = rect.size;
        let units = [1.0, a, b, a * a, a * b, b * b];
        std::array::from_fn(|i| found[i] / units[i])
    }
}

/// Mean of a course over a rectangle of `size`.
fn mean(course: &[f64; LIGHT_TERMS], [a, b]: [f64; 2]) -> f64 {
    let [c, u, v, uu, uv, vv] = course;
    c + u * a / 2.0 + v * b / 2.0 + uu * a * a / 3.0 + uv * a * b / 4.0 + vv * b * b / 3.0
}

#[cfg(test)]
mod tests {
    use super::super::super::texture::Material;
    use super::super::rect::Skin;
    use super::*;
    use dpn_core::random::Stream;

    #[test]
    fn courses_follow_the_light_and_are_one_in_the_mean() {
        let (low, high) = (Vector3::zeros(), Vector3::new(6.0, 5.0, 3.0));
        let lights = Lights::new(&low, &high, 1.2, &mut Stream::new(4).rng());
        let skin = Skin::at(Material::Cloth, [0.0; 2], 1.0, 1.0);
        let (x, y, z) = (Vector3::x(), Vector3::y(), Vector3::z());
        let floor = Rect::new(low, [x, y], [6.0, 5.0], skin);
        let small = Rect::new(Vector3::new(2.0, 0.3, 1.0), [x, z], [1.0, 0.8], skin);
        let mut rects = vec![floor, small];
        lights.shine(&mut rects, 250.0);
        let at = |rect: &Rect, u: f64, v: f64| {
            let (u, v) = (250.0 * u as f32, 250.0 * v as f32);
            let [c, a, b, aa, ab, bb] = rect.light;
            f64::from(c + a * u + b * v + aa * u * u + ab * u * v + bb * v * v)
        };
        let true_ratio = |rect: &Rect, u: f64, v: f64| lights.at(&rect.point(u, v), &rect.normal());
        let level = true_ratio(&rects[1], 0.5, 0.4) / at(&rects[1], 0.5, 0.4);
        // On a small rectangle a quadratic is right; over a floor it is a smooth stand-in.
        for (u, v) in [(0.1, 0.1), (0.9, 0.2), (0.3, 0.7)] {
            let (fit, light) = (at(&rects[1], u, v) * level, true_ratio(&rects[1], u, v));
            assert!((fit / light - 1.0).abs() < 0.01, "{fit} {light}");
        }
        for (u, v) in [(1.0, 1.0), (3.0, 2.5), (5.0, 4.0)] {
            let (fit, light) = (at(&rects[0], u, v) * level, true_ratio(&rects[0], u, v));
            assert!((fit / light - 1.0).abs() < 0.35, "{fit} {light}");
        }
        let mut sum = 0.0;
        for i in 0..100 {
            sum += at(&rects[0], 0.06 * f64::from(i % 10) * 10.0 + 0.3, 0.5 * f64::from(i / 10) + 0.25);
        }
        assert!((sum / 100.0 - 1.0).abs() < 0.1, "{}", sum / 100.0);
    }
}
