//! The response of every pixel that may be asked for, and its local maxima, in one pass over the rows.
//!
//! Most of an image lies within the discs of its tracks, where no corner may be. Work is done on runs of blocks of [`BLOCK`] columns in which, or
//! beside which, one may; what the other columns hold is never looked at.
//!
//! Sums over 3 x 3 pixels of products of 8-bit gradients fit the 24 bits of an `f32`, so they are exact in any order.

// With indices the loops read as the formulas do, and the compiler makes vectors of them.
#![allow(clippy::needless_range_loop)]

use super::mask::Mask;
use crate::frontend::image::Plane;
use pulp::{Simd, WithSimd};
use std::ops::Range;

/// Columns that are worked on together or not at all.
const BLOCK: usize = 32;

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
    /// For every block of every row, whether a corner may be in it or a pixel beside it.
    open: Vec<u8>,
    /// The same of one row and those near it.
    near: Vec<u8>,
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
        self.near.resize(width.div_ceil(BLOCK), 0);
    }

    /// Asks the mask which blocks are open.
    #[inline(always)]
    fn open(&mut self, mask: &Mask) {
        let (width, height) = mask.size();
        let blocks = self.near.len();
        self.open.resize(blocks * height, 0);
        for (y, open) in self.open.chunks_exact_mut(blocks).enumerate() {
            let row = mask.row(y);
            for (block, open) in open.iter_mut().enumerate() {
                let from = (BLOCK * block).saturating_sub(1);
                let to = (BLOCK * (block + 1) + 1).min(width);
                let mut any = 0;
                for free in &row[from..to] {
                    any |= free;
                }
                *open = any;
            }
        }
    }

    /// Puts into `near` which blocks are open in one of the rows from `first` to `last`, as far as there are such.
    #[inline(always)]
    fn near(&mut self, first: isize, last: isize) {
        let blocks = self.near.len();
        self.near.fill(0);
        for y in first.max(0)..=last {
            if let Some(open) = self.open.get(blocks * y as usize..).and_then(|rows| rows.get(..blocks)) {
                for (near, open) in self.near.iter_mut().zip(open) {
                    *near |= open;
                }
            }
        }
    }

    /// The next run of columns from block `block` on that `near` names, and the block after it.
    #[inline(always)]
    fn next_run(&self, block: usize, width: usize) -> Option<(Range<usize>, usize)> {
        let first = block + self.near[block..].iter().position(|near| *near != 0)?;
        let after = first + self.near[first..].iter().take_while(|near| **near != 0).count();
        Some((BLOCK * first..(BLOCK * after).min(width), after))
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
        rows.open(mask);
        let mut largest = 0.0f32;
        products(plane, -1, rows);
        products(plane, 0, rows);
        for y in 0..height {
            let here = y as isize;
            products(plane, here + 1, rows);
            rows.near(here - 1, here + 1);
            let mut block = 0;
            while let Some((run, after)) = rows.next_run(block, width) {
                sum_rows(rows, &run);
                let out = &mut rows.responses[y % 3][run.clone()];
                responses(&rows.sums, &run, out);
                largest = larger(largest, largest_free(out, &mask.row(y)[run]));
                block = after;
            }
            // Row y - 1 has both its neighbours now. The threshold only grows: what it refuses would be refused later.
            if y > edge && y < height - edge + 1 {
                let threshold = larger(quality * largest, least);
                rows.near(here - 1, here - 1);
                let mut block = 0;
                while let Some((run, after)) = rows.next_run(block, width) {
                    maxima(rows, mask.row(y - 1), y - 1, run, edge, threshold, found);
                    block = after;
                }
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

/// Products of the gradients in row `y` for all that is asked of it and the rows beside it.
#[inline(always)]
fn products(plane: &Plane, y: isize, rows: &mut Rows) {
    // Responses are asked for a row beside open ones, and ask for the rows beside themselves.
    rows.near(y - 2, y + 2);
    let mut block = 0;
    while let Some((run, after)) = rows.next_run(block, plane.width()) {
        products_of_run(plane, y, rows, run);
        block = after;
    }
}

/// Products of the gradients in row `y`, for the columns of `run` and one on both sides.
#[inline(always)]
fn products_of_run(plane: &Plane, y: isize, rows: &mut Rows, run: Range<usize>) {
    let n = run.len() + 4;
    let row = |dy: isize| plane.run(run.start as isize - 2, y + dy, n);
    let (a, b, c) = (&row(-1)[..n], &row(0)[..n], &row(1)[..n]);
    let (smooth, slope) = (&mut rows.smooth[..n], &mut rows.slope[..n]);
    for i in 0..n {
        let [a, b, c] = [a[i], b[i], c[i]].map(i16::from);
        smooth[i] = a + 2 * b + c;
        slope[i] = c - a;
    }
    let n = n - 2;
    let [xx, xy, yy] = &mut rows.products[(y + 1) as usize % 3];
    let at = run.start;
    let (xx, xy, yy) = (&mut xx[at..][..n], &mut xy[at..][..n], &mut yy[at..][..n]);
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
fn sum_rows(rows: &mut Rows, run: &Range<usize>) {
    let [a, b, c] = &rows.products;
    let (at, n) = (run.start, run.len() + 2);
    for k in 0..3 {
        let (out, a) = (&mut rows.sums[k][at..][..n], &a[k][at..][..n]);
        let (b, c) = (&b[k][at..][..n], &c[k][at..][..n]);
        for i in 0..n {
            out[i] = a[i] + b[i] + c[i];
        }
    }
}

#[inline(always)]
fn responses(sums: &[Vec<f32>; 3], run: &Range<usize>, out: &mut [f32]) {
    let n = out.len();
    let [xx, xy, yy] = sums;
    let at = run.start;
    let three = |row: &[f32], i: usize| row[i] + row[i + 1] + row[i + 2];
    let (xx, xy, yy) = (&xx[at..][..n + 2], &xy[at..][..n + 2], &yy[at..][..n + 2]);
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

/// Local maxima of row `y`, the middle one of the three responses, in the columns of `run`.
#[inline(always)]
fn maxima(
    rows: &mut Rows,
    free: &[u8],
    y: usize,
    run: Range<usize>,
    edge: usize,
    threshold: f32,
    found: &mut Vec<Candidate>,
) {
    let width = rows.tallest.len();
    // Without the image's first and last column, which have no neighbours on one side.
    let (from, to) = (run.start.max(1), run.end.min(width - 1));
    if from >= to {
        return;
    }
    let m = to - from;
    let n = m + 2;
    let [a, b, c] = &rows.responses;
    let at = from - 1;
    let (a, b, c) = (&a[at..][..n], &b[at..][..n], &c[at..][..n]);
    let tallest = &mut rows.tallest[..n];
    for i in 0..n {
        tallest[i] = larger(larger(a[i], b[i]), c[i]);
    }
    let middle = &rows.responses[y % 3][from..][..m];
    let (t0, t1, t2) = (&tallest[..m], &tallest[1..][..m], &tallest[2..][..m]);
    let (free, keep) = (&free[from..][..m], &mut rows.keep[..m]);
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
            let x = from + 16 * block + i;
            if x >= edge && x < width - edge {
                found.push(Candidate { response: middle[x - from], x: x as u32, y: y as u32 });
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
            width in 5..150usize, height in 5..40usize, seed in any::<u32>(), quality in 0.0..0.6f32, edge in 1..3usize,
            radius in 0.5..60.0f64, middle in 0.0..1.0f32,
        ) {
            let noise = |i: u32| (seed ^ i).wrapping_mul(2_654_435_761) >> 24;
            let image = GrayImage::from_fn(width, height, |x, y| noise((x / 2 + 977 * (y / 2)) as u32) as u8).unwrap();
            let plane = Plane::new(image.view());
            let mut mask = Mask::free(width, height);
            // Large ones close whole blocks.
            mask.take_disc([middle * width as f32, 2.0], radius);
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
