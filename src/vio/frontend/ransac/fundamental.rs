//! The matrix of two frames when nothing is known of the motion.

use super::pair::Pair;
use super::seven;
use nalgebra::{Matrix3, SMatrix, SymmetricEigen, Vector3};

/// Pairs whose bearings, in each frame, have the unit matrix as second moment.
pub(super) struct Whitened {
    pairs: Vec<Pair>,
    /// Undo the whitening: `bearing = root * whitened`, and back.
    inverse_prev: Matrix3<f64>,
    inverse_cur: Matrix3<f64>,
}

/// The inverse of the root of the vectors' second moment; the unit matrix where they lie in a plane.
fn whitening(vectors: impl ExactSizeIterator<Item = Vector3<f64>>) -> Matrix3<f64> {
    let n = vectors.len().max(1) as f64;
    let moment: Matrix3<f64> = vectors.map(|v| v * v.transpose()).sum::<Matrix3<f64>>() / n;
    moment
        .cholesky()
        .and_then(|root| root.l().try_inverse())
        .filter(|inverse| inverse.iter().all(|v| v.is_finite() && v.abs() < 1e6))
        .unwrap_or_else(Matrix3::identity)
}

fn products(pair: &Pair) -> [f64; 9] {
    std::array::from_fn(|i| pair.cur[i / 3] * pair.prev[i % 3])
}

impl Whitened {
    pub(super) fn new(pairs: &[Pair]) -> Self {
        let inverse_prev = whitening(pairs.iter().map(|pair| pair.prev));
        let inverse_cur = whitening(pairs.iter().map(|pair| pair.cur));
        let pairs = pairs
            .iter()
            .map(|pair| Pair { prev: inverse_prev * pair.prev, cur: inverse_cur * pair.cur })
            .collect();
        Self { pairs, inverse_prev, inverse_cur }
    }

    /// From whitened coordinates to bearings.
    fn unwhiten(&self, matrix: &Matrix3<f64>) -> Matrix3<f64> {
        let matrix = self.inverse_cur.transpose() * matrix * self.inverse_prev;
        matrix / matrix.norm()
    }

    /// The matrices through seven pairs, one to three.
    pub(super) fn solve(&self, sample: [usize; 7]) -> Vec<Matrix3<f64>> {
        let rows = sample.map(|i| products(&self.pairs[i]));
        seven::solve(rows).iter().map(|f| self.unwhiten(f)).collect()
    }

    /// The matrix of rank two that fits all `inliers` best, by the eight-point method; none for fewer than eight.
    pub(super) fn refit(&self, inliers: &[bool]) -> Option<Matrix3<f64>> {
        let mut normal = SMatrix::<f64, 9, 9>::zeros();
        let mut count = 0;
        for (pair, _) in self.pairs.iter().zip(inliers).filter(|(_, inlier)| **inlier) {
            let row = nalgebra::SVector::<f64, 9>::from(products(pair));
            normal += row * row.transpose();
            count += 1;
        }
        if count < 8 {
            return None;
        }
        let eigen = SymmetricEigen::new(normal);
        let smallest = eigen.eigenvectors.column(eigen.eigenvalues.imin()).into_owned();
        let mut svd = Matrix3::from_row_slice(smallest.as_slice()).svd(true, true);
        let least = svd.singular_values.imin();
        svd.singular_values[least] = 0.0;
        let matrix = svd.recompose().ok()?;
        matrix.iter().all(|v| v.is_finite()).then(|| self.unwhiten(&matrix))
    }
}
