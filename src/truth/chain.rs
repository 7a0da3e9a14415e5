//! Least squares along a chain: unknowns of every key couple with their neighbours' and with a few constants.
//!
//! ```text
//!     | D_0  O_0'          B_0' |        S_0 = D_0              L_k L_k' = S_k
//! H = | O_0  D_1  O_1'     B_1' |        W_k = O_k L_k^-T       S_k+1 = D_k+1 - W_k W_k'
//!     |      O_1  D_2      B_2' |        Y_k = (B_k - Y_k-1 W_k-1') L_k^-T
//!     | B_0  B_1  B_2  ..  C    |        L_c L_c' = C - sum Y_k Y_k'
//! ```
//! Time and memory grow with the chain's length. Of the inverse, the blocks where H is not zero come from the last key to the first
//! (Takahashi; in filtering, Rauch, Tung and Striebel): with `G_k = L_k^-T W_k'` and `F_k = L_k^-T Y_k'`
//! ```text
//! P_k,k+1 = -G_k P_k+1,k+1 - F_k P_c,k+1    P_k,c = -G_k P_k+1,c - F_k P_c,c    P_k,k = S_k^-1 - P_k,k+1 G_k' - P_k,c F_k'
//! ```
//! `vio`'s factor of normal equations keeps the dense triangle, which at 100,000 unknowns is 80 GB; hence this one.

use nalgebra::{Cholesky, Const, SMatrix, SVector};

/// A square block of `N` unknowns.
pub(crate) type Block<const N: usize> = SMatrix<f64, N, N>;

/// Normal equations `H d = -g` of `N` unknowns a key and `C` constants.
#[derive(Debug, Clone)]
pub(crate) struct Chain<const N: usize, const C: usize> {
    /// `D_k`.
    pub(crate) diagonal: Vec<Block<N>>,
    /// `O_k`, rows of key k + 1, columns of key k; one fewer than keys.
    pub(crate) next: Vec<Block<N>>,
    /// `B_k`.
    pub(crate) border: Vec<SMatrix<f64, C, N>>,
    /// `C`.
    pub(crate) corner: Block<C>,
    /// Gradient by the keys.
    pub(crate) gradient: Vec<SVector<f64, N>>,
    /// Gradient by the constants.
    pub(crate) gradient_of_constants: SVector<f64, C>,
}

/// The matrix is not positive definite at this key, or at the constants: an unknown that nothing is known of.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct NotPositive {
    /// `None` for the constants.
    pub(crate) key: Option<usize>,
}

/// The factor of a chain.
#[derive(Debug)]
pub(crate) struct ChainFactor<const N: usize, const C: usize> {
    pivots: Vec<Cholesky<f64, Const<N>>>,
    /// `W_k`.
    next: Vec<Block<N>>,
    /// `Y_k`.
    border: Vec<SMatrix<f64, C, N>>,
    corner: Cholesky<f64, Const<C>>,
}

/// The inverse where the chain is not zero.
#[derive(Debug)]
pub(crate) struct ChainCovariance<const N: usize, const C: usize> {
    /// Of every key.
    pub(crate) keys: Vec<Block<N>>,
    /// Between key k (rows) and key k + 1 (columns).
    pub(crate) next: Vec<Block<N>>,
    /// Between key k (rows) and the constants (columns).
    pub(crate) with_constants: Vec<SMatrix<f64, N, C>>,
    /// Of the constants.
    pub(crate) constants: Block<C>,
}

impl<const N: usize, const C: usize> Chain<N, C> {
    /// All zero.
    pub(crate) fn zeros(keys: usize) -> Self {
        Self {
            diagonal: vec![SMatrix::zeros(); keys],
            next: vec![SMatrix::zeros(); keys.saturating_sub(1)],
            border: vec![SMatrix::zeros(); keys],
            corner: SMatrix::zeros(),
            gradient: vec![SVector::zeros(); keys],
            gradient_of_constants: SVector::zeros(),
        }
    }

    /// The factor.
    ///
    /// # Errors
    /// A pivot that is not positive.
    pub(crate) fn factor(&self) -> Result<ChainFactor<N, C>, NotPositive> {
        let keys = self.diagonal.len();
        let mut factor: ChainFactor<N, C> = ChainFactor {
            pivots: Vec::with_capacity(keys),
            next: Vec::with_capacity(keys),
            border: Vec::with_capacity(keys),
            corner: Cholesky::pack_dirty(SMatrix::identity()),
        };
        let mut corner = self.corner;
        for k in 0..keys {
            let (mut pivot, mut border) = (self.diagonal[k], self.border[k]);
            if k > 0 {
                let (w, y): (&Block<N>, &SMatrix<f64, C, N>) = (&factor.next[k - 1], &factor.border[k - 1]);
                pivot -= w * w.transpose();
                border -= y * w.transpose();
            }
            let pivot = pivot.cholesky().ok_or(NotPositive { key: Some(k) })?;
            let border = right_divided(&pivot, &border);
            corner -= border * border.transpose();
            if let Some(next) = self.next.get(k) {
                factor.next.push(right_divided(&pivot, next));
            }
            factor.border.push(border);
            factor.pivots.push(pivot);
        }
        factor.corner = corner.cholesky().ok_or(NotPositive { key: None })?;
        Ok(factor)
    }
}

/// `a L^-T`.
fn right_divided<const R: usize, const N: usize>(
    pivot: &Cholesky<f64, Const<N>>,
    a: &SMatrix<f64, R, N>,
) -> SMatrix<f64, R, N> {
    let mut turned = a.transpose();
    // The factor's diagonal is positive: the solve cannot fail.
    pivot.l_dirty().solve_lower_triangular_unchecked_mut(&mut turned);
    turned.transpose()
}

/// `L^-T a`.
fn back<const N: usize, const R: usize>(
    pivot: &Cholesky<f64, Const<N>>,
    a: &SMatrix<f64, N, R>,
) -> SMatrix<f64, N, R> {
    let mut out = *a;
    pivot.l_dirty().tr_solve_lower_triangular_mut(&mut out);
    out
}

impl<const N: usize, const C: usize> ChainFactor<N, C> {
    /// The `d` of `H d = -g`: of the keys and of the constants.
    pub(crate) fn solve(&self, chain: &Chain<N, C>) -> (Vec<SVector<f64, N>>, SVector<f64, C>) {
        let keys = self.pivots.len();
        let mut steps: Vec<SVector<f64, N>> = Vec::with_capacity(keys);
        let mut constants = -chain.gradient_of_constants;
        for k in 0..keys {
            let mut right = -chain.gradient[k];
            if k > 0 {
                right -= self.next[k - 1] * steps[k - 1];
            }
            self.pivots[k].l_dirty().solve_lower_triangular_unchecked_mut(&mut right);
            constants -= self.border[k] * right;
            steps.push(right);
        }
        let constants = self.corner.solve(&constants);
        for k in (0..keys).rev() {
            let mut right = steps[k] - self.border[k].transpose() * constants;
            if k + 1 < keys {
                right -= self.next[k].transpose() * steps[k + 1];
            }
            steps[k] = back(&self.pivots[k], &right);
        }
        (steps, constants)
    }

    /// Of the determinant of `H`.
    pub(crate) fn log_determinant(&self) -> f64 {
        let of = |pivots: &mut dyn Iterator<Item = f64>| pivots.map(f64::ln).sum::<f64>();
        let keys = self.pivots.iter().map(|pivot| of(&mut pivot.l_dirty().diagonal().iter().copied()));
        2.0 * (keys.sum::<f64>() + of(&mut self.corner.l_dirty().diagonal().iter().copied()))
    }

    /// The inverse where the chain is not zero.
    pub(crate) fn covariance(&self) -> ChainCovariance<N, C> {
        let keys = self.pivots.len();
        let constants = self.corner.inverse();
        let mut out = ChainCovariance {
            keys: vec![SMatrix::zeros(); keys],
            next: vec![SMatrix::zeros(); keys.saturating_sub(1)],
            with_constants: vec![SMatrix::zeros(); keys],
            constants,
        };
        for k in (0..keys).rev() {
            let by_constants = back(&self.pivots[k], &self.border[k].transpose());
            let mut with_constants = -(by_constants * constants);
            let mut own = self.pivots[k].inverse();
            if k + 1 < keys {
                let by_next = back(&self.pivots[k], &self.next[k].transpose());
                with_constants -= by_next * out.with_constants[k + 1];
                let next =
                    -(by_next * out.keys[k + 1]) - by_constants * out.with_constants[k + 1].transpose();
                own -= next * by_next.transpose();
                out.next[k] = next;
            }
            own -= with_constants * by_constants.transpose();
            out.keys[k] = 0.5 * (own + own.transpose());
            out.with_constants[k] = with_constants;
        }
        out
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use dpn_core::random::Stream;
    use nalgebra::{DMatrix, DVector};
    use rand::Rng;

    const KEYS: usize = 5;

    /// A random chain of three unknowns a key and two constants, and the same as a dense matrix.
    fn case(seed: u64) -> (Chain<3, 2>, DMatrix<f64>, DVector<f64>) {
        let mut rng = Stream::new(seed).named("chain").rng();
        let dim = 3 * KEYS + 2;
        let mut chain = Chain::zeros(KEYS);
        let mut draw = || rng.random_range(-1.0..1.0);
        for k in 0..KEYS {
            let half = Block::<3>::from_fn(|_, _| draw());
            chain.diagonal[k] = half * half.transpose() + Block::<3>::identity() * 6.0;
            chain.border[k] = SMatrix::from_fn(|_, _| draw());
            chain.gradient[k] = SVector::from_fn(|_, _| draw());
            if k + 1 < KEYS {
                chain.next[k] = SMatrix::from_fn(|_, _| draw());
            }
        }
        chain.corner = Block::<2>::identity() * 8.0;
        chain.gradient_of_constants = SVector::from_fn(|_, _| draw());
        let (mut dense, mut gradient) = (DMatrix::zeros(dim, dim), DVector::zeros(dim));
        for k in 0..KEYS {
            dense.view_mut((3 * k, 3 * k), (3, 3)).copy_from(&chain.diagonal[k]);
            dense.view_mut((3 * KEYS, 3 * k), (2, 3)).copy_from(&chain.border[k]);
            dense.view_mut((3 * k, 3 * KEYS), (3, 2)).copy_from(&chain.border[k].transpose());
            gradient.rows_mut(3 * k, 3).copy_from(&chain.gradient[k]);
            if k + 1 < KEYS {
                dense.view_mut((3 * k + 3, 3 * k), (3, 3)).copy_from(&chain.next[k]);
                dense.view_mut((3 * k, 3 * k + 3), (3, 3)).copy_from(&chain.next[k].transpose());
            }
        }
        dense.view_mut((3 * KEYS, 3 * KEYS), (2, 2)).copy_from(&chain.corner);
        gradient.rows_mut(3 * KEYS, 2).copy_from(&chain.gradient_of_constants);
        (chain, dense, gradient)
    }

    #[test]
    fn the_determinant_is_that_of_the_dense_matrix() {
        let (chain, dense, _) = case(7);
        let (ours, theirs) = (chain.factor().unwrap().log_determinant(), dense.determinant().ln());
        assert!((ours - theirs).abs() < 1e-9 * theirs.abs(), "{ours} {theirs}");
    }

    #[test]
    fn step_and_covariance_are_those_of_the_dense_matrix() {
        for seed in 0..20 {
            let (chain, dense, gradient) = case(seed);
            let factor = chain.factor().unwrap();
            let inverse = dense.try_inverse().unwrap();
            let expected = -&inverse * gradient;
            let (steps, constants) = factor.solve(&chain);
            let covariance = factor.covariance();
            assert_eq!(steps.len(), KEYS);
            for (k, step) in steps.iter().enumerate() {
                assert!((step - expected.fixed_rows::<3>(3 * k)).amax() < 1e-12);
                assert!((covariance.keys[k] - inverse.fixed_view::<3, 3>(3 * k, 3 * k)).amax() < 1e-12);
                let mixed = inverse.fixed_view::<3, 2>(3 * k, 3 * KEYS);
                assert!((covariance.with_constants[k] - mixed).amax() < 1e-12);
                if k + 1 < KEYS {
                    let next = inverse.fixed_view::<3, 3>(3 * k, 3 * k + 3);
                    assert!((covariance.next[k] - next).amax() < 1e-12);
                }
            }
            assert!((constants - expected.fixed_rows::<2>(3 * KEYS)).amax() < 1e-12);
            assert!((covariance.constants - inverse.fixed_view::<2, 2>(3 * KEYS, 3 * KEYS)).amax() < 1e-12);
        }
    }

    #[test]
    fn what_nothing_is_known_of_is_named() {
        let (mut chain, ..) = case(1);
        chain.diagonal[2] = Block::<3>::zeros();
        assert_eq!(chain.factor().unwrap_err(), NotPositive { key: Some(2) });
        let (mut chain, ..) = case(1);
        chain.corner = Block::<2>::zeros();
        assert_eq!(chain.factor().unwrap_err(), NotPositive { key: None });
    }
}
