//! The one check of a derivative against differences, for the tests of every crate.

use nalgebra::{DMatrix, DVector, Dim, Matrix, RawStorage};

/// Step of the central differences: their error is about step^2 + 1e-16/step, both far below the tolerances in use.
const STEP: f64 = 1e-5;

/// Compares an analytic Jacobian with central differences of `residual_after`, which is handed the perturbation (as the solver's
/// `plus` takes it) and returns the residual.
///
/// `tolerance` is relative to the larger of 1 and the largest entry.
///
/// # Panics
/// Where they differ, with both matrices; this is for tests.
pub fn check_jacobian<R: Dim, C: Dim, S: RawStorage<f64, R, C>>(
    name: &str,
    analytic: &Matrix<f64, R, C, S>,
    tolerance: f64,
    residual_after: impl Fn(&DVector<f64>) -> DVector<f64>,
) {
    let (rows, columns) = analytic.shape();
    let mut numeric = DMatrix::zeros(rows, columns);
    for column in 0..columns {
        let mut step = DVector::zeros(columns);
        step[column] = STEP;
        let ahead = residual_after(&step);
        step[column] = -STEP;
        let behind = residual_after(&step);
        assert_eq!(ahead.len(), rows, "{name}: the residual has {} rows, the Jacobian {rows}", ahead.len());
        numeric.set_column(column, &((ahead - behind) / (2.0 * STEP)));
    }
    let analytic = DMatrix::from_fn(rows, columns, |r, c| analytic[(r, c)]);
    let scale = numeric.amax().max(1.0);
    let difference = (&analytic - &numeric).amax();
    assert!(
        difference <= tolerance * scale,
        "{name}: analytic{analytic:.6}numeric{numeric:.6}largest difference {difference:.3e}, scale {scale:.3e}"
    );
}
