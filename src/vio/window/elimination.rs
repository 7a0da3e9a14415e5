//! Unknowns taken out of a system by Schur complement: what they say about the others stays.
//!
//! With `A` the block of those that go, `W` their couplings to those that stay and `g` their gradient, what stays is `H - W^T A^-1 W` and
//! `g_kept - W^T A^-1 g`. With `A = L L^T` that is a sum of rank-one updates by the rows of `L^-1 W`. A system of many frames is mostly zeros: only
//! unknowns that meet one of those that go are touched.

use super::normal::Normal;
use super::row_sums::{LANES, add_weighted, scale};
use pulp::{Arch, Simd, WithSimd};

/// A pivot up to here says nothing of its unknown: far below any information a measurement gives (1e-3 and more), far above rounding.
const SAYS_NOTHING: f64 = 1e-9;
/// Rows that are worked on together, so that what is added to is read once.
const ROWS: usize = 5;

impl Normal {
    /// The system of the others once the unknowns `places` are taken out, in the order they had. An unknown of which nothing is known goes with its
    /// couplings.
    #[must_use]
    pub(crate) fn without(&self, places: &[usize]) -> Self {
        let kept: Vec<usize> = (0..self.dim()).filter(|k| !places.contains(k)).collect();
        let mut out = self.select(&kept);
        let met: Vec<usize> =
            (0..kept.len()).filter(|k| places.iter().any(|place| self.at(kept[*k], *place) != 0.0)).collect();
        if met.is_empty() {
            return out;
        }
        let stride = met.len().next_multiple_of(LANES);
        let mut rows = vec![0.0; places.len().next_multiple_of(ROWS) * stride];
        for (row, place) in rows.chunks_exact_mut(stride).zip(places) {
            for (coupling, k) in row.iter_mut().zip(&met) {
                *coupling = self.at(kept[*k], *place);
            }
        }
        let own = places.iter().map(|r| places.iter().map(|c| self.at(*r, *c)).collect()).collect();
        let gradient = places.iter().map(|place| self.gradient()[*place]).collect();
        Arch::new().dispatch(Elimination { own, gradient, rows, stride, met: &met, out: &mut out });
        out
    }
}

struct Elimination<'a> {
    /// The block of those that go; its upper triangle is read.
    own: Vec<Vec<f64>>,
    gradient: Vec<f64>,
    /// Their couplings to those they meet, a row each, `stride` long, and rows of zeros up to a multiple of [`ROWS`].
    rows: Vec<f64>,
    stride: usize,
    /// Where those they meet stand in `out`.
    met: &'a [usize],
    out: &'a mut Normal,
}

impl WithSimd for Elimination<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(mut self, simd: S) {
        for k in 0..self.own.len() {
            self.factor_row(simd, k);
        }
        let mut sums = vec![0.0; self.stride];
        for (r, place) in self.met.iter().enumerate() {
            let whole = (r + 1).next_multiple_of(LANES);
            sums[..whole].fill(0.0);
            for rows in self.rows.chunks_exact(ROWS * self.stride) {
                let rows: [&[f64]; ROWS] =
                    std::array::from_fn(|k| &rows[k * self.stride..(k + 1) * self.stride]);
                add_weighted(simd, &mut sums[..whole], rows.map(|row| row[r]), rows.map(|row| &row[..whole]));
            }
            let row = self.out.row_mut(*place);
            for (column, sum) in self.met[..=r].iter().zip(&sums) {
                row[*column] -= sum;
            }
            let by_gradient: f64 =
                self.rows.chunks_exact(self.stride).zip(&self.gradient).map(|(row, g)| row[r] * g).sum();
            self.out.gradient_mut()[*place] -= by_gradient;
        }
    }
}

impl Elimination<'_> {
    /// Makes row `k` one of `L^-1 W` and takes it out of those below.
    #[inline(always)]
    fn factor_row<S: Simd>(&mut self, simd: S, k: usize) {
        let (done, below) = self.rows.split_at_mut((k + 1) * self.stride);
        let row = &mut done[k * self.stride..];
        let pivot = self.own[k][k];
        // What it says nothing of must not be changed by what rounding has left.
        let inverse = if pivot > SAYS_NOTHING { 1.0 / pivot.sqrt() } else { 0.0 };
        scale(simd, row, inverse);
        self.own[k].iter_mut().for_each(|v| *v *= inverse);
        self.gradient[k] *= inverse;
        for i in k + 1..self.own.len() {
            let factor = self.own[k][i];
            if factor == 0.0 {
                continue;
            }
            let at = (i - k - 1) * self.stride;
            add_weighted(simd, &mut below[at..at + self.stride], [-factor], [&*row]);
            self.gradient[i] -= factor * self.gradient[k];
            for j in i..self.own.len() {
                self.own[i][j] -= factor * self.own[k][j];
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::normal::{Factor, tests::system};
    use super::*;
    use nalgebra::DVector;
    use proptest::prelude::*;
    use std::collections::BTreeSet;

    const DIM: usize = 30;

    proptest! {
        #[test]
        fn the_others_solution_stays(
            values in prop::collection::vec(-1.0..1.0f64, 97),
            places in prop::collection::btree_set(0..DIM, 1..16),
        ) {
            let (normal, dense) = system(&values, DIM);
            let all = dense.cholesky().unwrap().solve(&-DVector::from_column_slice(normal.gradient()));
            let places: Vec<usize> = places.into_iter().collect();
            let small = normal.without(&places);
            let mut factor = Factor::default();
            small.factor(|_| 0.0, &mut factor).unwrap();
            let mut d = small.gradient().to_vec();
            factor.solve_negated(&mut d);
            let kept = (0..DIM).filter(|k| !places.contains(k));
            for (k, d) in kept.zip(&d) {
                prop_assert!((all[k] - d).abs() < 1e-12, "{k}: {} and {d}", all[k]);
            }
        }

        #[test]
        fn of_one_that_says_nothing_nothing_stays(
            values in prop::collection::vec(-1.0..1.0f64, 97),
            places in prop::collection::btree_set(0..DIM, 1..4),
        ) {
            let (full, _) = system(&values, DIM);
            // All they say is what rounding has left.
            let silent = |k: usize| places.contains(&k);
            let mut normal = Normal::zeros(DIM);
            for r in 0..DIM {
                for c in 0..=r {
                    let value = if silent(r) || silent(c) { 1e-17 } else { full.at(r, c) };
                    normal.add(r, c, value);
                }
                normal.gradient_mut()[r] = if silent(r) { 1e-17 } else { full.gradient()[r] };
            }
            let kept: BTreeSet<usize> = (0..DIM).filter(|k| !silent(*k)).collect();
            let small = normal.without(&places.iter().copied().collect::<Vec<_>>());
            for (r, from_r) in kept.iter().enumerate() {
                prop_assert_eq!(small.gradient()[r], full.gradient()[*from_r]);
                for (c, from_c) in kept.iter().enumerate() {
                    prop_assert_eq!(small.at(r, c), full.at(*from_r, *from_c));
                }
            }
        }
    }
}
