//! A forest of classification trees whose votes are averaged as numbers.
//!
//! linfa's trees tell classes apart, so deviations are binned into [`BINS`] classes of equal width; each tree, grown on
//! its own bootstrap sample, names a class, and the forest answers the mean of the classes' mean deviations.

use super::{RegressError, Regressor};
use crate::features::Features;
use dpn_core::random::Stream;
use linfa::prelude::*;
use linfa_trees::DecisionTree;
use ndarray::{Array1, Array2, ArrayView1, ArrayView2};
use rand::Rng;
use rayon::prelude::*;

/// Classes the range of labels is cut into.
const BINS: usize = 22;
/// Trees.
const TREES: u64 = 48;
/// Rows of a tree's bootstrap sample, at most.
const ROWS: usize = 6000;
/// Levels of a tree.
const DEPTH: usize = 14;
/// Rows a leaf needs.
const LEAF: f32 = 8.0;

/// Averaged classification trees.
#[derive(Debug)]
pub struct ForestRegressor {
    /// Each tree with the features it sees.
    trees: Vec<DecisionTree<f64, usize>>,
    /// Mean deviation of each class.
    values: Vec<f64>,
}

impl ForestRegressor {
    /// Fits to rows of features and their labels; bootstrap samples come from `stream`.
    ///
    /// # Errors
    /// A fit that linfa gives up.
    pub fn fit(table: &[f64], truth: &[f64], stream: &Stream) -> Result<Self, RegressError> {
        let low = truth.iter().copied().fold(f64::INFINITY, f64::min);
        let high = truth.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let class = |t: f64| if high > low { (((t - low) / (high - low) * BINS as f64) as usize).min(BINS - 1) } else { 0 };
        let mut sums = vec![(0.0, 0.0); BINS];
        for &t in truth {
            let sum = &mut sums[class(t)];
            *sum = (sum.0 + t, sum.1 + 1.0);
        }
        let values = sums.iter().map(|(sum, n)| if *n > 0.0 { sum / n } else { 0.0 }).collect();
        let trees: Result<Vec<_>, RegressError> = (0..TREES)
            .into_par_iter()
            .map(|index| {
                let mut rng = stream.named("forest").index(index).rng();
                let take = truth.len().min(ROWS);
                let mut rows = Array2::zeros((take, Features::COUNT));
                let mut classes = Array1::zeros(take);
                for (mut row, target) in rows.outer_iter_mut().zip(classes.iter_mut()) {
                    let at = rng.random_range(0..truth.len());
                    row.assign(&ArrayView1::from(&table[at * Features::COUNT..(at + 1) * Features::COUNT]));
                    *target = class(truth[at]);
                }
                DecisionTree::params()
                    .max_depth(Some(DEPTH))
                    .min_weight_leaf(LEAF)
                    .fit(&Dataset::new(rows, classes))
                    .map_err(|error| RegressError::Fit { method: "forest", reason: error.to_string() })
            })
            .collect();
        Ok(Self { trees: trees?, values })
    }
}

impl Regressor for ForestRegressor {
    fn name(&self) -> &'static str {
        "forest"
    }

    fn predict(&self, table: &[f64]) -> Vec<f64> {
        let rows = table.len() / Features::COUNT;
        let Ok(view) = ArrayView2::from_shape((rows, Features::COUNT), table) else { return Vec::new() };
        let votes: Vec<Vec<f64>> = self
            .trees
            .par_iter()
            .map(|tree| tree.predict(&view).iter().map(|&class: &usize| self.values[class]).collect())
            .collect();
        (0..rows).map(|row| votes.iter().map(|tree| tree[row]).sum::<f64>() / votes.len().max(1) as f64).collect()
    }
}
