//! A square of grey values that joins onto itself, and what can be painted on it.

use rand::Rng;

/// Side of a texture \[texels\]; a power of two.
pub(crate) const SIDE: usize = 1024;

/// Grey values around 0 to 255, row after row. What leaves it on one side comes in on the other.
pub(super) struct Canvas {
    pub(super) grey: Vec<f32>,
}

impl Canvas {
    pub(super) fn new(grey: f32) -> Self {
        Self { grey: vec![grey; SIDE * SIDE] }
    }

    /// Adds smooth noise of deviation near `strength`: random values at `columns` x `rows` places, joined by quintic curves.
    ///
    /// Source: value noise after Perlin 2002 (the quintic).
    pub(super) fn noise(&mut self, columns: usize, rows: usize, strength: f32, rng: &mut impl Rng) {
        // Uniform within 1 has a deviation of 1/sqrt(3), and joining takes about a fifth of it away.
        let values: Vec<f32> =
            (0..columns * rows).map(|_| 2.2 * strength * (rng.random::<f32>() - 0.5) * 2.0).collect();
        let across: Vec<(usize, usize, f32)> = (0..SIDE).map(|x| between(x, columns)).collect();
        for y in 0..SIDE {
            let (top, bottom, fy) = between(y, rows);
            let (top, bottom) = (&values[top * columns..][..columns], &values[bottom * columns..][..columns]);
            let row = &mut self.grey[y * SIDE..][..SIDE];
            for (grey, &(left, right, fx)) in row.iter_mut().zip(&across) {
                let a = top[left] + fx * (top[right] - top[left]);
                let b = bottom[left] + fx * (bottom[right] - bottom[left]);
                *grey += a + fy * (b - a);
            }
        }
    }

    /// Adds noise of every size from `cells` a side up to `finest`, each twice as fine and `fall` times as strong as the last.
    pub(super) fn octaves(
        &mut self,
        cells: usize,
        finest: usize,
        strength: f32,
        fall: f32,
        rng: &mut impl Rng,
    ) {
        let (mut cells, mut strength) = (cells, strength);
        while cells <= finest {
            self.noise(cells, cells, strength, rng);
            (cells, strength) = (2 * cells, strength * fall);
        }
    }

    /// Sets every texel for which `inside(dx, dy)` holds, within `reach` of (x, y), to `paint(old)`.
    pub(super) fn shape(
        &mut self,
        [x, y]: [f32; 2],
        reach: f32,
        inside: impl Fn(f32, f32) -> bool,
        mut paint: impl FnMut(f32) -> f32,
    ) {
        let reach = (reach.ceil() as i32).min(SIDE as i32 / 2 - 1);
        let (cx, cy) = (x.floor() as i32, y.floor() as i32);
        for dy in -reach..=reach {
            let row = (cy + dy).rem_euclid(SIDE as i32) as usize * SIDE;
            for dx in -reach..=reach {
                let (fx, fy) = ((cx + dx) as f32 + 0.5 - x, (cy + dy) as f32 + 0.5 - y);
                if inside(fx, fy) {
                    let at = row + (cx + dx).rem_euclid(SIDE as i32) as usize;
                    self.grey[at] = paint(self.grey[at]);
                }
            }
        }
    }

    /// A rectangle of half sides `half`, turned by `turn` \[rad\].
    pub(super) fn rectangle(&mut self, at: [f32; 2], half: [f32; 2], turn: f32, grey: f32) {
        let (sin, cos) = turn.sin_cos();
        let inside = |dx: f32, dy: f32| {
            (cos * dx + sin * dy).abs() <= half[0] && (cos * dy - sin * dx).abs() <= half[1]
        };
        self.shape(at, half[0].hypot(half[1]), inside, |_| grey);
    }

    /// An ellipse of half axes `half`, turned by `turn` \[rad\]; with `ring`, only its border of that share.
    pub(super) fn ellipse(&mut self, at: [f32; 2], half: [f32; 2], turn: f32, ring: Option<f32>, grey: f32) {
        let (sin, cos) = turn.sin_cos();
        let hole = ring.map_or(0.0, |ring| (1.0 - ring) * (1.0 - ring));
        let inside = |dx: f32, dy: f32| {
            let (a, b) = ((cos * dx + sin * dy) / half[0], (cos * dy - sin * dx) / half[1]);
            (hole..=1.0).contains(&(a * a + b * b))
        };
        self.shape(at, half[0].max(half[1]), inside, |_| grey);
    }

    /// A four-sided chip with one corner in each quadrant about `at`, turned by `turn` \[rad\].
    pub(super) fn chip(&mut self, at: [f32; 2], corners: [f32; 4], turn: f32, grey: f32) {
        let (sin, cos) = turn.sin_cos();
        let [east, north, west, south] = corners;
        let inside = |dx: f32, dy: f32| {
            let (a, b) = (cos * dx + sin * dy, cos * dy - sin * dx);
            let (along, across) =
                (if a >= 0.0 { a / east } else { -a / west }, if b >= 0.0 { b / north } else { -b / south });
            along + across <= 1.0
        };
        self.shape(at, corners.into_iter().fold(0.0, f32::max), inside, |_| grey);
    }

    /// Smooths by `(1 4 1) / 6` in rows and columns, so that no edge of a shape is a staircase.
    pub(super) fn soften(&mut self) {
        let blur = |from: &[f32], to: &mut [f32], step: [usize; 2]| {
            for y in 0..SIDE {
                for x in 0..SIDE {
                    let at = |dx: usize, dy: usize| from[((y + dy) % SIDE) * SIDE + (x + dx) % SIDE];
                    let [dx, dy] = step;
                    let back = at(dx * (SIDE - 1), dy * (SIDE - 1));
                    to[y * SIDE + x] = (back + 4.0 * at(0, 0) + at(dx, dy)) / 6.0;
                }
            }
        };
        let mut other = vec![0.0; SIDE * SIDE];
        blur(&self.grey, &mut other, [1, 0]);
        blur(&other, &mut self.grey, [0, 1]);
    }
}

/// The two of `cells` values around texel `texel`, which join onto each other, and the weight of the second.
fn between(texel: usize, cells: usize) -> (usize, usize, f32) {
    let place = (texel as f32 + 0.5) * cells as f32 / SIDE as f32;
    let cell = (place as usize).min(cells - 1);
    let f = place - cell as f32;
    (cell, (cell + 1) % cells, f * f * f * (f * (6.0 * f - 15.0) + 10.0))
}

#[cfg(test)]
mod tests {
    use super::*;
    use dpn_core::random::Stream;

    #[test]
    fn noise_has_the_strength_asked_for_and_joins_onto_itself() {
        let mut canvas = Canvas::new(100.0);
        canvas.noise(64, 32, 10.0, &mut Stream::new(1).rng());
        let n = (SIDE * SIDE) as f32;
        let mean = canvas.grey.iter().sum::<f32>() / n;
        let std = (canvas.grey.iter().map(|g| (g - mean).powi(2)).sum::<f32>() / n).sqrt();
        assert!((mean - 100.0).abs() < 1.5 && (std - 10.0).abs() < 1.0, "{mean} {std}");
        // Across the seam as smooth as anywhere.
        let step = |x: usize| {
            let rows =
                (0..SIDE).map(|y| (canvas.grey[y * SIDE + x] - canvas.grey[y * SIDE + (x + 1) % SIDE]).abs());
            rows.sum::<f32>() / SIDE as f32
        };
        let inner: f32 = (0..SIDE - 1).map(step).sum::<f32>() / (SIDE - 1) as f32;
        assert!(step(SIDE - 1) < 2.0 * inner, "{} {inner}", step(SIDE - 1));
    }

    #[test]
    fn shapes_cover_their_area_across_the_seam_too() {
        let covered = |paint: &dyn Fn(&mut Canvas)| {
            let mut canvas = Canvas::new(0.0);
            paint(&mut canvas);
            canvas.grey.iter().filter(|g| **g > 0.0).count() as f32
        };
        let near = |found: f32, expected: f32| (found / expected - 1.0).abs() < 0.03;
        assert!(near(covered(&|c| c.rectangle([2.0, 1020.0], [30.0, 20.0], 0.4, 9.0)), 2400.0));
        assert!(near(covered(&|c| c.ellipse([500.0, 1.0], [30.0, 20.0], 1.0, None, 9.0)), 1885.0));
        assert!(near(covered(&|c| c.ellipse([500.0, 1.0], [40.0, 40.0], 1.0, Some(0.5), 9.0)), 3770.0));
        assert!(near(covered(&|c| c.chip([500.0, 500.0], [20.0, 30.0, 40.0, 30.0], 0.3, 9.0)), 1800.0));
    }

    #[test]
    fn softening_keeps_the_sum() {
        let mut canvas = Canvas::new(0.0);
        canvas.grey[0] = 36.0;
        canvas.soften();
        assert_eq!(canvas.grey[0], 16.0);
        assert_eq!(canvas.grey[SIDE - 1], 4.0);
        assert_eq!(canvas.grey.iter().sum::<f32>(), 36.0);
    }
}
