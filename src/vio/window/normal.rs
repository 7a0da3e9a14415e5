//! Dense symmetric normal equations `H d = -g` with an envelope Cholesky factorisation.
//!
//! Rows of the lower triangle are kept whole and contiguous: factor and solve are dot products of rows, which the compiler turns
//! into vector code. A row's factor begins where the row does, so that the zeros in front of it cost nothing.

// Small fixed loops over rows and columns: with indices they read as the formulas do.
#![allow(clippy::needless_range_loop)]

use pulp::Arch;

/// Half of a least-squares problem's second-order model: `cost(d) = cost(0) + g.d + d.H d / 2`.
#[derive(Debug, Clone)]
pub struct Normal {
    dim: usize,
    /// From one row to the next: `dim` and room for vectors that reach beyond the last column.
    stride: usize,
    /// Lower triangle of H, row by row, `stride` apart; what is above the diagonal is never read.
    h: Vec<f64>,
    /// Gradient, `stride` long.
    g: Vec<f64>,
}

/// The matrix met a pivot that is not positive: no direction of descent can be had from it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NotPositive {
    /// Row of the pivot.
    pub row: usize,
    /// Its value.
    pub pivot: f64,
}

impl Normal {
    /// By how much a vector may reach beyond a row's last column.
    pub(crate) const MARGIN: usize = 8;

    /// All zero.
    pub fn zeros(dim: usize) -> Self {
        let mut normal = Self { dim: 0, stride: 0, h: Vec::new(), g: Vec::new() };
        normal.reset(dim);
        normal
    }

    /// Back to zero, of a new size, keeping the memory.
    pub fn reset(&mut self, dim: usize) {
        self.dim = dim;
        self.stride = (dim + Self::MARGIN).next_multiple_of(Self::MARGIN);
        self.h.clear();
        self.h.resize(dim * self.stride, 0.0);
        self.g.clear();
        self.g.resize(self.stride, 0.0);
    }

    /// How many unknowns it has.
    pub(crate) fn dim(&self) -> usize {
        self.dim
    }

    /// The gradient.
    pub fn gradient(&self) -> &[f64] {
        &self.g[..self.dim]
    }

    /// The gradient, to add to.
    pub fn gradient_mut(&mut self) -> &mut [f64] {
        &mut self.g[..self.dim]
    }

    /// The gradient with [`Self::MARGIN`] entries and more behind the last, which are never read.
    #[inline(always)]
    pub(crate) fn whole_gradient_mut(&mut self) -> &mut [f64] {
        &mut self.g
    }

    /// Row `r` of H up to and with the diagonal, to add to.
    #[inline]
    pub(crate) fn row_mut(&mut self, r: usize) -> &mut [f64] {
        &mut self.whole_row_mut(r)[..=r]
    }

    /// Row `r` of H with [`Self::MARGIN`] columns and more behind the last, to add whole vectors to: what lands above the diagonal is
    /// never read.
    #[inline(always)]
    pub(crate) fn whole_row_mut(&mut self, r: usize) -> &mut [f64] {
        let start = r * self.stride;
        &mut self.h[start..start + self.stride]
    }

    /// `N` rows from `r` on, each as [`Self::whole_row_mut`] gives it.
    #[inline(always)]
    pub(crate) fn whole_rows_mut<const N: usize>(&mut self, r: usize) -> [&mut [f64]; N] {
        let mut rows = self.h[r * self.stride..].chunks_exact_mut(self.stride);
        std::array::from_fn(|_| rows.next().expect("the rows asked for are rows of H"))
    }

    /// Row `r` of H up to and with the diagonal.
    #[inline]
    pub fn row(&self, r: usize) -> &[f64] {
        let start = r * self.stride;
        &self.h[start..=start + r]
    }

    /// The entry of H at row `r`, column `c`, whichever triangle.
    #[inline]
    pub(crate) fn at(&self, r: usize, c: usize) -> f64 {
        let (r, c) = if r >= c { (r, c) } else { (c, r) };
        self.h[r * self.stride + c]
    }

    /// Adds to the entry at row `r`, column `c`, once: `(r, c)` and `(c, r)` are one entry.
    #[inline]
    pub fn add(&mut self, r: usize, c: usize, value: f64) {
        let (r, c) = if r >= c { (r, c) } else { (c, r) };
        self.h[r * self.stride + c] += value;
    }

    /// Adds `weight * a^T b` of two sets of rows, `a` at place `at_a`, `b` at place `at_b`: for an off-diagonal block.
    ///
    /// # Panics
    /// Where the blocks overlap; a diagonal block is [`Self::add_square`].
    #[inline]
    pub(crate) fn add_product<const R: usize, const A: usize, const B: usize>(
        &mut self,
        at_a: usize,
        a: &[[f64; A]; R],
        at_b: usize,
        b: &[[f64; B]; R],
    ) {
        if at_a > at_b {
            self.add_ordered(at_a, a, at_b, b);
        } else {
            self.add_ordered(at_b, b, at_a, a);
        }
    }

    #[inline]
    fn add_ordered<const R: usize, const A: usize, const B: usize>(
        &mut self,
        at_a: usize,
        a: &[[f64; A]; R],
        at_b: usize,
        b: &[[f64; B]; R],
    ) {
        debug_assert!(at_b + B <= at_a, "blocks overlap");
        for i in 0..A {
            let row = &mut self.whole_row_mut(at_a + i)[at_b..at_b + B];
            for j in 0..B {
                let mut sum = 0.0;
                for r in 0..R {
                    sum += a[r][i] * b[r][j];
                }
                row[j] += sum;
            }
        }
    }

    /// Adds `a^T a` on the diagonal at place `at`.
    #[inline]
    pub(crate) fn add_square<const R: usize, const A: usize>(&mut self, at: usize, a: &[[f64; A]; R]) {
        for i in 0..A {
            let row = &mut self.whole_row_mut(at + i)[at..at + A];
            // The upper half of the block is computed and never read: a full row is one vector loop.
            for j in 0..A {
                let mut sum = 0.0;
                for r in 0..R {
                    sum += a[r][i] * a[r][j];
                }
                row[j] += sum;
            }
        }
    }

    /// The first unknown of which something is said; `dim` where nothing is. H is positive semi-definite: where its diagonal is zero, so is the row.
    pub(crate) fn first_told(&self) -> usize {
        (0..self.dim).find(|k| self.at(*k, *k) != 0.0).unwrap_or(self.dim)
    }

    /// `H d` for a full vector.
    pub(crate) fn times(&self, d: &[f64]) -> Vec<f64> {
        let mut out = vec![0.0; self.dim];
        let first = self.first_told();
        for r in first..self.dim {
            let row = &self.row(r)[first..r];
            let (above, rest) = out.split_at_mut(r);
            rest[0] += self.at(r, r) * d[r] + dot(row, &d[first..r]);
            for (out, h) in above[first..].iter_mut().zip(row) {
                *out += h * d[r];
            }
        }
        out
    }

    /// The system of the unknowns `kept`, which are named in increasing order.
    pub(super) fn select(&self, kept: &[usize]) -> Self {
        let mut out = Self::zeros(kept.len());
        for (r, &from_r) in kept.iter().enumerate() {
            out.g[r] = self.g[from_r];
            let from = self.row(from_r);
            let mut at = 0;
            for run in kept[..=r].chunk_by(|a, b| a + 1 == *b) {
                out.h[r * out.stride + at..][..run.len()].copy_from_slice(&from[run[0]..][..run.len()]);
                at += run.len();
            }
        }
        out
    }

    /// Factors H with `extra(k)` added to its k-th diagonal entry.
    ///
    /// # Errors
    /// A pivot that is not positive.
    pub fn factor(&self, extra: impl Fn(usize) -> f64, into: &mut Factor) -> Result<(), NotPositive> {
        Arch::new().dispatch(
            #[inline(always)]
            || into.factor(self, extra),
        )
    }
}

/// A lower-triangular Cholesky factor, memory to be used again.
#[derive(Debug, Clone, Default)]
pub struct Factor {
    dim: usize,
    l: Vec<f64>,
    /// One over each diagonal entry: a division would hold up every entry that waits for it.
    inverse_pivot: Vec<f64>,
    /// First nonzero column of each row.
    first: Vec<usize>,
}

/// Dot product in four running sums, so that the order of additions does not depend on the vector width chosen.
#[inline(always)]
fn dot(a: &[f64], b: &[f64]) -> f64 {
    let mut sums = [0.0; 4];
    let (chunks_a, rest_a) = a.as_chunks::<4>();
    let (chunks_b, rest_b) = b.as_chunks::<4>();
    for (x, y) in chunks_a.iter().zip(chunks_b) {
        for k in 0..4 {
            sums[k] += x[k] * y[k];
        }
    }
    let mut sum = (sums[0] + sums[1]) + (sums[2] + sums[3]);
    for (x, y) in rest_a.iter().zip(rest_b) {
        sum += x * y;
    }
    sum
}

impl Factor {
    #[inline(always)]
    fn factor(&mut self, normal: &Normal, extra: impl Fn(usize) -> f64) -> Result<(), NotPositive> {
        let dim = normal.dim;
        self.dim = dim;
        self.l.resize(dim * dim, 0.0);
        self.first.clear();
        self.inverse_pivot.clear();
        for r in 0..dim {
            let source = normal.row(r);
            let first = source.iter().position(|v| *v != 0.0).unwrap_or(r);
            self.first.push(first);
            let (done, rest) = self.l.split_at_mut(r * dim);
            let row = &mut rest[..dim];
            row[..first].fill(0.0);
            row[first..r].copy_from_slice(&source[first..r]);
            for c in first..r {
                let from = first.max(self.first[c]);
                let other = &done[c * dim..c * dim + dim];
                row[c] = (row[c] - dot(&row[from..c], &other[from..c])) * self.inverse_pivot[c];
            }
            let pivot = source[r] + extra(r) - dot(&row[first..r], &row[first..r]);
            // Also false for NaN.
            if !(pivot > 0.0 && pivot.is_finite()) {
                return Err(NotPositive { row: r, pivot });
            }
            row[r] = pivot.sqrt();
            self.inverse_pivot.push(1.0 / row[r]);
        }
        Ok(())
    }

    /// Solves `H d = -g` in place: `x` holds g, then d.
    pub fn solve_negated(&self, x: &mut [f64]) {
        let dim = self.dim;
        for r in 0..dim {
            let first = self.first[r];
            let row = &self.l[r * dim..=r * dim + r];
            x[r] = (-x[r] - dot(&row[first..r], &x[first..r])) * self.inverse_pivot[r];
        }
        for r in (0..dim).rev() {
            let first = self.first[r];
            let row = &self.l[r * dim..=r * dim + r];
            let value = x[r] * self.inverse_pivot[r];
            x[r] = value;
            for (x, l) in x[first..r].iter_mut().zip(&row[first..r]) {
                *x -= value * l;
            }
        }
    }

    /// Solves `L x = b` in place for a `b` whose first `from` entries are zero.
    pub(crate) fn solve_lower(&self, x: &mut [f64], from: usize) {
        let dim = self.dim;
        for r in from..dim {
            let first = self.first[r].max(from);
            let row = &self.l[r * dim..=r * dim + r];
            // A row may begin behind `from`, never behind its diagonal.
            x[r] = (x[r] - dot(&row[first..r], &x[first..r])) * self.inverse_pivot[r];
        }
    }

    /// The entry of the factor at row `r`, column `c <= r`.
    pub(crate) fn at(&self, r: usize, c: usize) -> f64 {
        self.l[r * self.dim + c]
    }

    /// The last `N x N` corner of the factor: `(L L^T)^-1` is the covariance of the last `N` unknowns.
    pub(crate) fn last_corner<const N: usize>(&self) -> nalgebra::SMatrix<f64, N, N> {
        let start = self.dim - N;
        nalgebra::SMatrix::from_fn(|r, c| if c <= r { self.at(start + r, start + c) } else { 0.0 })
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use nalgebra::{DMatrix, DVector};
    use proptest::prelude::*;

    /// A sparse positive definite system: rows of a random envelope.
    pub(crate) fn system(values: &[f64], dim: usize) -> (Normal, DMatrix<f64>) {
        let mut normal = Normal::zeros(dim);
        let mut k = 0;
        let mut next = || {
            k += 1;
            values[k % values.len()]
        };
        for r in 0..dim {
            let first = ((next().abs() * 7.0) as usize).min(r);
            for c in first..r {
                normal.add(r, c, next());
            }
            normal.add(r, r, 2.0 * dim as f64);
            normal.gradient_mut()[r] = next();
        }
        let dense = DMatrix::from_fn(dim, dim, |r, c| normal.at(r, c));
        (normal, dense)
    }

    proptest! {
        #[test]
        fn the_step_solves_the_equations(values in prop::collection::vec(-1.0..1.0f64, 97), dim in 1usize..30) {
            let (normal, dense) = system(&values, dim);
            let mut factor = Factor::default();
            normal.factor(|_| 0.0, &mut factor).unwrap();
            let mut d = normal.gradient().to_vec();
            factor.solve_negated(&mut d);
            let residual = dense * DVector::from_vec(d.clone()) + DVector::from_column_slice(normal.gradient());
            prop_assert!(residual.amax() < 1e-11);
            let product = DVector::from_vec(normal.times(&d)) + DVector::from_column_slice(normal.gradient());
            prop_assert!(product.amax() < 1e-11);
        }
    }

    #[test]
    fn the_last_corner_is_the_last_unknowns_covariance() {
        let (normal, dense) = system(&[0.3, -0.8, 0.5, 0.9, -0.1], 9);
        let mut factor = Factor::default();
        normal.factor(|_| 0.0, &mut factor).unwrap();
        let corner = factor.last_corner::<3>();
        let covariance = (corner * corner.transpose()).try_inverse().unwrap();
        let full = dense.try_inverse().unwrap();
        assert!((covariance - full.fixed_view::<3, 3>(6, 6)).amax() < 1e-14);
    }

    #[test]
    fn an_indefinite_matrix_is_named_by_its_row() {
        let mut normal = Normal::zeros(2);
        normal.add(0, 0, 1.0);
        normal.add(1, 0, 2.0);
        normal.add(1, 1, 1.0);
        let error = normal.factor(|_| 0.0, &mut Factor::default()).unwrap_err();
        assert_eq!(error, NotPositive { row: 1, pivot: -3.0 });
    }

    #[test]
    fn blocks_land_where_they_belong_in_either_order() {
        let (a, b) = ([[1.0, 2.0]], [[3.0, 5.0, 7.0]]);
        let mut one = Normal::zeros(5);
        one.add_product(0, &a, 2, &b);
        let mut other = Normal::zeros(5);
        other.add_product(2, &b, 0, &a);
        for (i, x) in a[0].iter().enumerate() {
            for (j, y) in b[0].iter().enumerate() {
                assert_eq!(one.at(i, 2 + j), x * y);
                assert_eq!(other.at(2 + j, i), x * y);
            }
        }
    }
}
