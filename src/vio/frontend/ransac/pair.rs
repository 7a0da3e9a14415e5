//! A point seen twice.

use nalgebra::{Matrix3, Vector3};

/// Bearings of one point in two frames, unit vectors in the camera's frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pair {
    /// In the earlier frame.
    pub prev: Vector3<f64>,
    /// In the later one.
    pub cur: Vector3<f64>,
}

impl Pair {
    /// Sampson's distance from `cur^T E prev = 0`, squared \[rad^2\].
    pub fn distance_squared(&self, essential: &Matrix3<f64>) -> f64 {
        let line_cur = essential * self.prev;
        let line_prev = essential.tr_mul(&self.cur);
        let algebraic = self.cur.dot(&line_cur);
        let scale = line_cur.norm_squared() + line_prev.norm_squared();
        if scale > 0.0 { algebraic * algebraic / scale } else { f64::INFINITY }
    }
}
