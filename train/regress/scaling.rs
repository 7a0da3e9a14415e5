//! Features brought to uncorrelated columns of mean 0 and deviation 1, and labels to a range of about 1.
//!
//! The features are logarithms of deviations that rise and fall together; what tells white noise from vibration is in
//! their differences. Whitening by principal components gives these as much weight as their common part.

use crate::features::Features;
use nalgebra::{DMatrix, DVector};

/// Components with less than this share of the largest one's variance are not blown up any further.
const SMALLEST_SHARE: f64 = 1e-4;

/// Mean and whitening map of the training table, and the labels' scale.
#[derive(Debug, Clone)]
pub(super) struct Scaling {
    mean: DVector<f64>,
    /// Rows: scaled principal directions.
    map: DMatrix<f64>,
    /// Largest label.
    pub(super) label: f64,
}

impl Scaling {
    /// Learns the scaling of `table` (rows of [`Features::COUNT`]) and `truth`.
    pub(super) fn of(table: &[f64], truth: &[f64]) -> Self {
        let count = Features::COUNT;
        let rows = (table.len() / count).max(1) as f64;
        let mut mean = DVector::zeros(count);
        for row in table.chunks_exact(count) {
            mean += DVector::from_row_slice(row) / rows;
        }
        let mut covariance = DMatrix::zeros(count, count);
        for row in table.chunks_exact(count) {
            let centred = DVector::from_row_slice(row) - &mean;
            covariance.ger(1.0 / rows, &centred, &centred, 1.0);
        }
        let eigen = covariance.symmetric_eigen();
        let floor = eigen.eigenvalues.max().max(f64::MIN_POSITIVE) * SMALLEST_SHARE;
        let mut map = eigen.eigenvectors.transpose();
        for (mut row, value) in map.row_iter_mut().zip(eigen.eigenvalues.iter()) {
            row /= value.max(floor).sqrt();
        }
        let label = truth.iter().copied().fold(f64::MIN_POSITIVE, f64::max);
        Self { mean, map, label }
    }

    /// The table whitened, in the same order.
    pub(super) fn apply(&self, table: &[f64]) -> Vec<f64> {
        table
            .chunks_exact(Features::COUNT)
            .flat_map(|row| {
                let whitened = &self.map * (DVector::from_row_slice(row) - &self.mean);
                whitened.iter().copied().collect::<Vec<_>>()
            })
            .collect()
    }
}

/// At most `most` of `rows` indices, evenly spread.
pub(super) fn spread(rows: usize, most: usize) -> Vec<usize> {
    let take = rows.min(most);
    (0..take).map(|i| (i as u128 * rows as u128 / take as u128) as usize).collect()
}
