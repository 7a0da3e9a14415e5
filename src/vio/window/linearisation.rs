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
    /// Each landmark's step after the states' step `d`.
    pub(crate) fn depth_steps<'a>(&'a self, d: &'a [f64]) -> impl Iterator<Item = (usize, f64)> + 'a {
        self.depths.steps(d)
    }
}
