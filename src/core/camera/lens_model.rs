//! What every lens model answers.

use nalgebra::{Matrix2, Matrix2x3, Vector2, Vector3};

/// A place in the plane and its derivative by the point, as the product of two.
#[derive(Debug, Clone, Copy)]
pub(super) struct Placed {
    pub(super) place: Vector2<f64>,
    /// By what the lens distorts.
    pub(super) d_place: Matrix2<f64>,
    /// Of that, by the point.
    pub(super) d_inner: Matrix2x3<f64>,
}

/// A lens model. `None` is a point that it does not see, or a place that sees nothing; the two agree.
pub(super) trait LensModel {
    /// The place of a point in the camera's frame.
    fn project(&self, point: &Vector3<f64>) -> Option<Vector2<f64>>;
    /// The same with its derivative.
    fn project_with_jacobian(&self, point: &Vector3<f64>) -> Option<Placed>;
    /// The direction, of any length, that a place sees.
    fn unproject(&self, place: &Vector2<f64>) -> Option<Vector3<f64>>;
}
