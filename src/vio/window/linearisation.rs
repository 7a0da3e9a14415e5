//! The equations of a window at one point.

use super::landmark_terms::{Depths, Pairs};
use super::normal::Normal;

/// The equations at one point, and memory for the next.
#[derive(Debug, Clone)]
pub(crate) struct Linearisation {
    pub(crate) normal: Normal,
    pub(crate) cost: f64,
    pub(super) depths: Depths,
    pub(super) pairs: Pairs,
}

impl Default for Linearisation {
    fn default() -> Self {
        Self { normal: Normal::zeros(0), cost: 0.0, depths: Depths::default(), pairs: Pairs::default() }
    }
}

impl Linearisation {
    /// By how much the states' step `d`, which solves the equations undamped, and the depths' steps after it lower the cost of the equations'
    /// model.
    pub(super) fn expected_gain(&self, d: &[f64]) -> f64 {
        let states: f64 = self.normal.gradient().iter().zip(d).map(|(g, d)| -g * d).sum();
        0.5 * (states + self.depths.gain())
    }

    /// Each landmark's step after the states' step `d`.
    pub(crate) fn depth_steps<'a>(&'a self, d: &'a [f64]) -> impl Iterator<Item = (usize, f64)> + 'a {
        self.depths.steps(d)
    }
}
