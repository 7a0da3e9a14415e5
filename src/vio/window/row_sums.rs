//! Weighted sums of rows, in vectors of the machine.

// Small fixed loops over rows: with indices they read as the formulas do.
#![allow(clippy::needless_range_loop)]

use super::normal::Normal;
use pulp::Simd;

/// Numbers that are worked on together: a block of six is filled up with zeros to one vector.
pub(super) const LANES: usize = Normal::MARGIN;

/// `to += factors . rows`, all of one length, a multiple of [`LANES`].
///
/// In vectors by hand: left to the compiler, loops over blocks of eight become gathers and shuffles. Each product is added without
/// being rounded first: half the instructions, and the same bits on vectors of any width.
#[inline(always)]
pub(super) fn add_weighted<S: Simd, const N: usize>(
    simd: S,
    to: &mut [f64],
    factors: [f64; N],
    rows: [&[f64]; N],
) {
    add_weighted_to_each(simd, [to], [factors], rows);
}

/// [`add_weighted`] to each of `to`, with factors of its own.
#[inline(always)]
pub(super) fn add_weighted_to_each<S: Simd, const R: usize, const N: usize>(
    simd: S,
    to: [&mut [f64]; R],
    factors: [[f64; N]; R],
    rows: [&[f64]; N],
) {
    let length = rows[0].len();
    let rows = rows.map(|row| S::as_simd_f64s(&row[..length]).0);
    let to = to.map(|row| S::as_mut_simd_f64s(&mut row[..length]).0);
    let vectors = rows[0].len();
    let factors = factors.map(|of_row| of_row.map(|factor| simd.splat_f64s(factor)));
    for k in 0..vectors {
        for r in 0..R {
            let mut sum = to[r][k];
            for n in 0..N {
                sum = simd.mul_add_f64s(factors[r][n], rows[n][k], sum);
            }
            to[r][k] = sum;
        }
    }
}

/// `row *= factor`, its length a multiple of [`LANES`].
#[inline(always)]
pub(super) fn scale<S: Simd>(simd: S, row: &mut [f64], factor: f64) {
    for v in S::as_mut_simd_f64s(row).0 {
        *v = simd.mul_f64s(*v, simd.splat_f64s(factor));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use pulp::{Arch, Scalar, WithSimd};

    /// Two rows, each with three others added to it, then halved.
    struct Sums<'a> {
        to: [Vec<f64>; 2],
        factors: [[f64; 3]; 2],
        rows: [&'a [f64]; 3],
    }

    impl WithSimd for Sums<'_> {
        type Output = [Vec<f64>; 2];

        fn with_simd<S: Simd>(mut self, simd: S) -> Self::Output {
            add_weighted_to_each(simd, self.to.each_mut().map(|row| &mut row[..]), self.factors, self.rows);
            for row in &mut self.to {
                scale(simd, row, 0.5);
            }
            self.to
        }
    }

    proptest! {
        #[test]
        fn sums_are_those_of_the_formula_to_the_same_bits_on_vectors_of_any_width(
            values in prop::collection::vec(-2.0..2.0f64, 5 * 24),
            factors in prop::array::uniform2(prop::array::uniform3(-3.0..3.0f64)),
        ) {
            let row = |k: usize| &values[24 * k..24 * (k + 1)];
            let rows = [row(0), row(1), row(2)];
            let sums = || Sums { to: [row(3).to_vec(), row(4).to_vec()], factors, rows };
            let wide = Arch::new().dispatch(sums());
            prop_assert_eq!(&wide, &sums().with_simd(Scalar::new()));
            for (r, to) in wide.iter().enumerate() {
                for (k, value) in to.iter().enumerate() {
                    let expected = row(3 + r)[k] + (0..3).map(|n| factors[r][n] * rows[n][k]).sum::<f64>();
                    prop_assert!((2.0 * value - expected).abs() < 1e-14 * 20.0);
                }
            }
        }
    }
}
