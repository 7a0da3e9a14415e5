//! The two matrix products everything comes down to, blocked so that sums stay in registers.
//!
//! Rows of the left factor may overlap (they begin `stride` apart and are as long as the right factor is high): that makes a
//! convolution a product without a copy. Every function is inlined into a body that [`pulp`] compiles for the machine's vectors.

use super::plan::Panels;
use pulp::Simd;

/// A matrix whose rows may overlap.
#[derive(Clone, Copy)]
pub(crate) struct Rows<'a> {
    /// First row's first number first.
    pub(crate) data: &'a [f32],
    /// From one row's begin to the next.
    pub(crate) stride: usize,
    /// How many rows.
    pub(crate) count: usize,
}

/// `out[i] = start + rows[i] * weights` for every row `i`; row `i` of the output begins at `i * out_stride`.
#[inline(always)]
pub(crate) fn multiply<S: Simd>(
    simd: S,
    rows: Rows<'_>,
    packed: &[f32],
    weights: &Panels,
    start: Option<&[f32]>,
    out: &mut [f32],
    out_stride: usize,
) {
    let (lanes, inner) = (S::F32_LANES, weights.inner);
    let mut column = 0;
    let mut panels = &packed[weights.at..weights.at + inner * weights.columns];
    while column < weights.columns {
        let width = (2 * lanes).min(weights.columns - column);
        let (panel, rest) = panels.split_at(inner * width);
        let start = start.map(|s| &s[column..column + width]);
        if width == 2 * lanes {
            if S::REGISTER_COUNT >= 32 {
                panel_rows::<S, 10, 2>(simd, rows, panel, inner, start, out, out_stride, column);
            } else {
                panel_rows::<S, 5, 2>(simd, rows, panel, inner, start, out, out_stride, column);
            }
        } else {
            panel_rows::<S, 10, 1>(simd, rows, panel, inner, start, out, out_stride, column);
        }
        panels = rest;
        column += width;
    }
}

#[inline(always)]
#[expect(clippy::too_many_arguments, reason = "the innermost loop's operands, each used once")]
fn panel_rows<S: Simd, const ROWS: usize, const VECTORS: usize>(
    simd: S,
    rows: Rows<'_>,
    panel: &[f32],
    inner: usize,
    start: Option<&[f32]>,
    out: &mut [f32],
    out_stride: usize,
    column: usize,
) {
    let mut sums = [simd.splat_f32s(0.0); VECTORS];
    if let Some(start) = start {
        sums.copy_from_slice(&S::as_simd_f32s(start).0[..VECTORS]);
    }
    let mut row = 0;
    while row + ROWS <= rows.count {
        tile::<S, ROWS, VECTORS>(simd, rows, row, panel, inner, sums, out, out_stride, column);
        row += ROWS;
    }
    while row + 5 <= rows.count {
        tile::<S, 5, VECTORS>(simd, rows, row, panel, inner, sums, out, out_stride, column);
        row += 5;
    }
    while row < rows.count {
        tile::<S, 1, VECTORS>(simd, rows, row, panel, inner, sums, out, out_stride, column);
        row += 1;
    }
}

#[inline(always)]
#[expect(clippy::too_many_arguments, reason = "the innermost loop's operands, each used once")]
fn tile<S: Simd, const ROWS: usize, const VECTORS: usize>(
    simd: S,
    rows: Rows<'_>,
    row: usize,
    panel: &[f32],
    inner: usize,
    start: [S::f32s; VECTORS],
    out: &mut [f32],
    out_stride: usize,
    column: usize,
) {
    let mut a: [&[f32]; ROWS] = [&[]; ROWS];
    for (i, a) in a.iter_mut().enumerate() {
        *a = &rows.data[(row + i) * rows.stride..][..inner];
    }
    let mut sums = [start; ROWS];
    let (vectors, _) = S::as_simd_f32s(panel);
    for (p, b) in (0..inner).zip(vectors.chunks_exact(VECTORS)) {
        for i in 0..ROWS {
            let factor = simd.splat_f32s(a[i][p]);
            for v in 0..VECTORS {
                sums[i][v] = simd.mul_add_e_f32s(factor, b[v], sums[i][v]);
            }
        }
    }
    for i in 0..ROWS {
        let place = &mut out[(row + i) * out_stride + column..][..VECTORS * S::F32_LANES];
        let (place, _) = S::as_mut_simd_f32s(place);
        place[..VECTORS].copy_from_slice(&sums[i]);
    }
}

/// `out += rows^T * right`, with `right` `[rows.count, columns]` and `out` `[inner, columns]`, both row by row.
#[inline(always)]
pub(crate) fn accumulate<S: Simd>(
    simd: S,
    rows: Rows<'_>,
    inner: usize,
    right: &[f32],
    columns: usize,
    out: &mut [f32],
) {
    let lanes = S::F32_LANES;
    let mut column = 0;
    while column < columns {
        if column + 2 * lanes <= columns {
            if S::REGISTER_COUNT >= 32 {
                strip::<S, 8, 2>(simd, rows, inner, right, columns, out, column);
            } else {
                strip::<S, 4, 2>(simd, rows, inner, right, columns, out, column);
            }
            column += 2 * lanes;
        } else {
            strip::<S, 8, 1>(simd, rows, inner, right, columns, out, column);
            column += lanes;
        }
    }
}

#[inline(always)]
fn strip<S: Simd, const ROWS: usize, const VECTORS: usize>(
    simd: S,
    rows: Rows<'_>,
    inner: usize,
    right: &[f32],
    columns: usize,
    out: &mut [f32],
    column: usize,
) {
    let mut p = 0;
    while p + ROWS <= inner {
        outer_tile::<S, ROWS, VECTORS>(simd, rows, p, right, columns, out, column);
        p += ROWS;
    }
    while p + 4 <= inner {
        outer_tile::<S, 4, VECTORS>(simd, rows, p, right, columns, out, column);
        p += 4;
    }
    while p < inner {
        outer_tile::<S, 1, VECTORS>(simd, rows, p, right, columns, out, column);
        p += 1;
    }
}

#[inline(always)]
fn outer_tile<S: Simd, const ROWS: usize, const VECTORS: usize>(
    simd: S,
    rows: Rows<'_>,
    p: usize,
    right: &[f32],
    columns: usize,
    out: &mut [f32],
    column: usize,
) {
    let width = VECTORS * S::F32_LANES;
    let mut sums = [[simd.splat_f32s(0.0); VECTORS]; ROWS];
    for i in 0..ROWS {
        let (place, _) = S::as_simd_f32s(&out[(p + i) * columns + column..][..width]);
        sums[i].copy_from_slice(&place[..VECTORS]);
    }
    for (m, right) in (0..rows.count).zip(right.chunks_exact(columns)) {
        let a = &rows.data[m * rows.stride + p..][..ROWS];
        let (b, _) = S::as_simd_f32s(&right[column..column + width]);
        for i in 0..ROWS {
            let factor = simd.splat_f32s(a[i]);
            for v in 0..VECTORS {
                sums[i][v] = simd.mul_add_e_f32s(factor, b[v], sums[i][v]);
            }
        }
    }
    for i in 0..ROWS {
        let (place, _) = S::as_mut_simd_f32s(&mut out[(p + i) * columns + column..][..width]);
        place[..VECTORS].copy_from_slice(&sums[i]);
    }
}

/// `sum += row`, number by number.
#[inline(always)]
pub(crate) fn add_row<S: Simd>(simd: S, sum: &mut [f32], row: &[f32]) {
    let (sum, _) = S::as_mut_simd_f32s(sum);
    let (row, _) = S::as_simd_f32s(row);
    for (s, r) in sum.iter_mut().zip(row) {
        *s = simd.add_f32s(*s, *r);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use pulp::{Arch, WithSimd};

    /// Numbers whose products and sums are exact in single precision, so that any order of summing gives the same bits.
    fn whole(count: usize, seed: usize) -> Vec<f32> {
        (0..count).map(|i| ((i * 7 + seed * 13) % 11) as f32 - 5.0).collect()
    }

    struct Multiply<'a> {
        rows: Rows<'a>,
        right: &'a [f32],
        inner: usize,
        columns: usize,
        start: &'a [f32],
        out: &'a mut [f32],
        out_stride: usize,
    }

    impl WithSimd for Multiply<'_> {
        type Output = ();

        #[inline(always)]
        fn with_simd<S: Simd>(self, simd: S) {
            // The panels that the plan would make.
            let (mut packed, mut column) = (Vec::new(), 0);
            while column < self.columns {
                let width = (2 * S::F32_LANES).min(self.columns - column);
                for row in self.right.chunks_exact(self.columns) {
                    packed.extend_from_slice(&row[column..column + width]);
                }
                column += width;
            }
            let weights = Panels { at: 0, inner: self.inner, columns: self.columns };
            multiply(simd, self.rows, &packed, &weights, Some(self.start), self.out, self.out_stride);
        }
    }

    struct Accumulate<'a>(Rows<'a>, usize, &'a [f32], usize, &'a mut [f32]);

    impl WithSimd for Accumulate<'_> {
        type Output = ();

        #[inline(always)]
        fn with_simd<S: Simd>(self, simd: S) {
            accumulate(simd, self.0, self.1, self.2, self.3, self.4);
        }
    }

    proptest! {
        #[test]
        fn products_with_overlapping_rows_are_the_sums_by_definition(
            count in 1usize..27,
            stride in 1usize..20,
            inner in 1usize..40,
            lanes in 1usize..6,
            gap in 0usize..3,
        ) {
            let columns = 16 * lanes;
            let out_stride = columns + 16 * gap;
            let data = whole((count - 1) * stride + inner, 1);
            let (right, start) = (whole(inner * columns, 2), whole(columns, 3));
            let rows = Rows { data: &data, stride, count };
            for arch in [Arch::Scalar, Arch::new()] {
                let mut out = vec![99.0; count * out_stride];
                arch.dispatch(Multiply { rows, right: &right, inner, columns, start: &start, out: &mut out, out_stride });
                for i in 0..count {
                    for c in 0..columns {
                        let sum: f32 = (0..inner).map(|p| data[i * stride + p] * right[p * columns + c]).sum();
                        prop_assert_eq!(out[i * out_stride + c], start[c] + sum);
                    }
                    // What lies between the rows is not touched.
                    prop_assert!(out[i * out_stride + columns..(i + 1) * out_stride].iter().all(|v| *v == 99.0));
                }
            }
        }

        #[test]
        fn transposed_products_are_the_sums_by_definition(
            count in 1usize..27,
            stride in 1usize..20,
            inner in 1usize..40,
            lanes in 1usize..6,
        ) {
            let columns = 16 * lanes;
            let data = whole((count - 1) * stride + inner, 4);
            let right = whole(count * columns, 5);
            let rows = Rows { data: &data, stride, count };
            for arch in [Arch::Scalar, Arch::new()] {
                let mut out = whole(inner * columns, 6);
                arch.dispatch(Accumulate(rows, inner, &right, columns, &mut out));
                let before = whole(inner * columns, 6);
                for p in 0..inner {
                    for c in 0..columns {
                        let sum: f32 = (0..count).map(|m| data[m * stride + p] * right[m * columns + c]).sum();
                        prop_assert_eq!(out[p * columns + c], before[p * columns + c] + sum);
                    }
                }
            }
        }
    }
}
