//! The response of every pixel, and its local maxima, in one pass over the rows.
//!
//! Sums over 3 x 3 pixels of products of 8-bit gradients fit the 24 bits of an `f32`, so they are exact in any order.

// With indices the loops read as the formulas do, and the compiler makes vectors of them.
#![allow(clippy::needless_range_loop)]

use super::mask::Mask;
use crate::frontend::image::Plane;
use pulp::{Simd, WithSimd};

/// Sobel's operator sums to 8, in both factors; nine pixels are summed.
const SCALE: f32 = 1.0 / (8.0 * 8.0 * 9.0);

/// A pixel whose response is a local maximum.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Candidate {
    pub(super) response: f32,
    pub(super) x: u32,
    pub(super) y: u32,
}

/// Rows at work.
#[derive(Debug, Clone, Default)]
pub(super) struct Rows {
    /// Column sums and differences of three pixel rows.
    smooth: Vec<i16>,
    slope: Vec<i16>,
    /// Products of the gradients (xx, xy, yy) in three rows, one after the other.
    products: [[Vec<f32>; 3]; 3],
    /// Their sums over three rows.
    sums: [Vec<f32>; 3],
    /// Responses of three rows.
    responses: [Vec<f32>; 3],
    /// Largest of three responses above each other.
    tallest: Vec<f32>,
    keep: Vec<u8>,
}

impl Rows {
    fn fit(&mut self, width: usize) {
        self.smooth.resize(width + 4, 0);
        self.slope.resize(width + 4, 0);
        self.products.iter_mut().flatten().for_each(|row| row.resize(width + 2, 0.0));
        self.sums.iter_mut().for_each(|row| row.resize(width + 2, 0.0));
        self.responses.iter_mut().for_each(|row| row.resize(width, 0.0));
        self.tallest.resize(width, 0.0);
        self.keep.resize(width, 0);
    }
}

/// Finds the candidates of a plane; `found` is cleared first.
pub(super) struct Find<'a> {
    pub(super) plane: &'a Plane,
    pub(super) mask: &'a Mask,
    pub(super) quality: f32,
    pub(super) least: f32,
    pub(super) edge: usize,
    pub(super) rows: &'a mut Rows,
    pub(super) found: &'a mut Vec<Candidate>,
}

impl WithSimd for Find<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let Self { plane, mask, quality, least, edge, rows, found } = self;
        found.clear();
        let (width, height) = (plane.width(), plane.height());
        let edge = edge.max(1);
        if width <= 2 * edge || height <= 2 * edge || mask.size() != (width, height) {
            return;
        }
        rows.fit(width);
        let mut largest = 0.0f32;
        products(plane, -1, rows);
        products(plane, 0, rows);
        for y in 0..height {
            products(plane, y as isize + 1, rows);
            sum_rows(rows);
            responses(&rows.sums, &mut rows.responses[y % 3]);
            largest = larger(largest, largest_free(&rows.responses[y % 3], mask.row(y)));
            // Row y - 1 has both its neighbours now. The threshold only grows: what it refuses would be refused later.
            if y > edge && y < height - edge + 1 {
                let threshold = larger(quality * largest, least);
                maxima(rows, mask.row(y - 1), y - 1, edge, threshold, found);
            }
        }
        let threshold = larger(quality * largest, least);
        found.retain(|candidate| candidate.response >= threshold);
    }
}

#[inline(always)]
fn larger(a: f32, b: f32) -> f32 {
    if a > b { a } else { b }
}

/// Products of the gradients in row `y`, columns -1 to `width`.
#[inline(always)]
fn products(plane: &Plane, y: isize, rows: &mut Rows) {
    let n = plane.width() + 4;
    let row = |dy: isize| plane.run(-2, y + dy, n);
    let (a, b, c) = (&row(-1)[..n], &row(0)[..n], &row(1)[..n]);
    let (smooth, slope) = (&mut rows.smooth[..n], &mut rows.slope[..n]);
    for i in 0..n {
        let [a, b, c] = [a[i], b[i], c[i]].map(i16::from);
        smooth[i] = a + 2 * b + c;
        slope[i] = c - a;
    }
    let n = n - 2;
    let [xx, xy, yy] = &mut rows.products[(y + 1) as usize % 3];
    let (xx, xy, yy) = (&mut xx[..n], &mut xy[..n], &mut yy[..n]);
    let (s0, s2) = (&smooth[..n], &smooth[2..][..n]);
    let (d0, d1, d2) = (&slope[..n], &slope[1..][..n], &slope[2..][..n]);
    for i in 0..n {
        let dx = f32::from(s2[i] - s0[i]);
        let dy = f32::from(d0[i] + 2 * d1[i] + d2[i]);
        xx[i] = dx * dx;
        xy[i] = dx * dy;
        yy[i] = dy * dy;
    }
}

#[inline(always)]
fn sum_rows(rows: &mut Rows) {
    let [a, b, c] = &rows.products;
    for k in 0..3 {
        let n = rows.sums[k].len();
        let (out, a, b, c) = (&mut rows.sums[k][..n], &a[k][..n], &b[k][..n], &c[k][..n]);
        for i in 0..n {
            out[i] = a[i] + b[i] + c[i];
        }
    }
}

#[inline(always)]
fn responses(sums: &[Vec<f32>; 3], out: &mut [f32]) {
    let n = out.len();
    let [xx, xy, yy] = sums;
    let three = |row: &[f32], i: usize| row[i] + row[i + 1] + row[i + 2];
    let (xx, xy, yy) = (&xx[..n + 2], &xy[..n + 2], &yy[..n + 2]);
    for i in 0..n {
        let (a, b, c) = (0.5 * three(xx, i), three(xy, i), 0.5 * three(yy, i));
        out[i] = SCALE * ((a + c) - ((a - c) * (a - c) + b * b).sqrt());
    }
}

/// The largest response where a corner may be.
#[inline(always)]
fn largest_free(responses: &[f32], free: &[u8]) -> f32 {
    let mut lanes = [0.0f32; 16];
    let (chunks, rest) = responses.as_chunks::<16>();
    let (free_chunks, free_rest) = free.as_chunks::<16>();
    for (chunk, free) in chunks.iter().zip(free_chunks) {
        for i in 0..16 {
            lanes[i] = larger(lanes[i], if free[i] != 0 { chunk[i] } else { 0.0 });
        }
    }
    for (response, free) in rest.iter().zip(free_rest) {
        lanes[0] = larger(lanes[0], if *free != 0 { *response } else { 0.0 });
    }
    lanes.into_iter().fold(0.0, larger)
}

/// Local maxima of row `y`, the middle one of the three responses.
#[inline(always)]
fn maxima(rows: &mut Rows, free: &[u8], y: usize, edge: usize, threshold: f32, found: &mut Vec<Candidate>) {
    let n = rows.tallest.len();
    let [a, b, c] = &rows.responses;
    let (a, b, c, tallest) = (&a[..n], &b[..n], &c[..n], &mut rows.tallest[..n]);
    for i in 0..n {
        tallest[i] = larger(larger(a[i], b[i]), c[i]);
    }
    let m = n - 2;
    let middle = &rows.responses[y % 3][1..][..m];
    let (t0, t1, t2) = (&tallest[..m], &tallest[1..][..m], &tallest[2..][..m]);
    let (free, keep) = (&free[1..][..m], &mut rows.keep[..m]);
    for i in 0..m {
        let neighbours = larger(larger(t0[i], t1[i]), t2[i]);
        let peak = (middle[i] >= neighbours) & (middle[i] >= threshold);
        keep[i] = u8::from(peak) & free[i];
    }
    for (block, flags) in keep.chunks(16).enumerate() {
        if flags.iter().fold(0, |any, flag| any | flag) == 0 {
            continue;
        }
        for (i, _) in flags.iter().enumerate().filter(|(_, flag)| **flag != 0) {
            let x = 16 * block + i + 1;
            if x >= edge && x < n - edge {
                found.push(Candidate { response: middle[x - 1], x: x as u32, y: y as u32 });
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use dpn_core::GrayImage;
    use proptest::prelude::*;
    use pulp::Arch;

    /// The definition at one pixel.
    fn plain(plane: &Plane, x: isize, y: isize) -> f64 {
        let at = |x: isize, y: isize| f64::from(plane.run(x, y, 1)[0]);
        let (mut xx, mut xy, mut yy) = (0.0, 0.0, 0.0);
        for v in y - 1..=y + 1 {
            for u in x - 1..=x + 1 {
                let mut d = [0.0; 2];
                for (k, w) in [(-1, 1.0), (0, 2.0), (1, 1.0)] {
                    d[0] += w * (at(u + 1, v + k) - at(u - 1, v + k)) / 8.0;
                    d[1] += w * (at(u + k, v + 1) - at(u + k, v - 1)) / 8.0;
                }
                xx += d[0] * d[0] / 9.0;
                xy += d[0] * d[1] / 9.0;
                yy += d[1] * d[1] / 9.0;
            }
        }
        let half = (xx + yy) / 2.0;
        half - (((xx - yy) / 2.0).powi(2) + xy * xy).sqrt()
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(40))]
        #[test]
        fn candidates_are_the_local_maxima_above_the_threshold(
            width in 5..70usize, height in 5..40usize, seed in any::<u32>(), quality in 0.0..0.6f32, edge in 1..3usize,
        ) {
            let noise = |i: u32| (seed ^ i).wrapping_mul(2_654_435_761) >> 24;
            let image = GrayImage::from_fn(width, height, |x, y| noise((x / 2 + 977 * (y / 2)) as u32) as u8).unwrap();
            let plane = Plane::new(image.view());
            let mut mask = Mask::free(width, height);
            mask.take_disc([width as f32 / 2.0, 2.0], 4.0);
            let (mut rows, mut found) = (Rows::default(), Vec::new());
            Arch::new().dispatch(Find {
                plane: &plane, mask: &mask, quality, least: 0.5, edge, rows: &mut rows, found: &mut found,
            });
            let response = |x: usize, y: usize| plain(&plane, x as isize, y as isize);
            let mut largest: f64 = 0.0;
            for y in 0..height {
                for x in 0..width {
                    if mask.is_free(x, y) {
                        largest = largest.max(response(x, y));
                    }
                }
            }
            let threshold = (f64::from(quality) * largest).max(0.5);
            for y in edge..height - edge {
                for x in edge..width - edge {
                    let here = response(x, y);
                    let around = (y - 1..=y + 1)
                        .flat_map(|v| (x - 1..=x + 1).map(move |u| (u, v)))
                        .filter(|place| *place != (x, y))
                        .map(|(u, v)| response(u, v))
                        .fold(0.0, f64::max);
                    let listed = found.iter().find(|c| (c.x as usize, c.y as usize) == (x, y));
                    if let Some(listed) = listed {
                        prop_assert!((f64::from(listed.response) - here).abs() < 1e-3 * (1.0 + here));
                        prop_assert!(mask.is_free(x, y) && here > around - 1e-2 && here > threshold - 1e-2);
                    } else {
                        // Within rounding of a bound either answer is right.
                        let clear = here > around + 1e-2 && here > threshold + 1e-2 && mask.is_free(x, y);
                        prop_assert!(!clear, "missed {x}, {y}: {here} of {around}, {threshold}");
                    }
                }
            }
        }
    }
}
