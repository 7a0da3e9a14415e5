//! Orthonormal polynomials on evenly spaced places.
//!
//! Each degree is the abscissa, scaled to \[-1, 1\], times the degree before it, orthogonalised twice against all lower ones, so
//! that every degree is good to rounding (Kahan and Parlett: twice is enough).

/// Orthonormal polynomials of degree `0 ..= order` on `window` even places of \[-1, 1\], each as its values there.
pub(super) fn orthonormal_polynomials(window: usize, order: usize) -> Vec<Vec<f64>> {
    let half = (window / 2) as f64;
    let abscissa: Vec<f64> = (0..window).map(|i| (i as f64 - half) / half.max(1.0)).collect();
    let mut basis: Vec<Vec<f64>> = vec![vec![1.0 / (window as f64).sqrt(); window]];
    for degree in 1..=order {
        let mut next: Vec<f64> = abscissa.iter().zip(&basis[degree - 1]).map(|(x, q)| x * q).collect();
        // Twice is enough (Kahan, Parlett): the second pass removes what rounding left of the first.
        for _ in 0..2 {
            for q in &basis {
                let along = dot(q.iter().zip(&next));
                next.iter_mut().zip(q).for_each(|(v, q)| *v -= along * q);
            }
        }
        let norm = dot(next.iter().zip(&next)).sqrt();
        next.iter_mut().for_each(|v| *v /= norm);
        basis.push(next);
    }
    basis
}

/// Sum of products.
pub(super) fn dot<'a>(pairs: impl Iterator<Item = (&'a f64, &'a f64)>) -> f64 {
    pairs.map(|(a, b)| a * b).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_degree_is_of_length_one_and_upright_on_the_others() {
        for (window, order) in [(1, 0), (5, 2), (51, 3), (101, 40)] {
            let basis = orthonormal_polynomials(window, order);
            for (i, a) in basis.iter().enumerate() {
                for (j, b) in basis.iter().enumerate() {
                    let expected = if i == j { 1.0 } else { 0.0 };
                    let product = dot(a.iter().zip(b));
                    assert!((product - expected).abs() < 1e-14, "({window},{order}) {i} {j}: {product:e}");
                }
            }
        }
    }
}
