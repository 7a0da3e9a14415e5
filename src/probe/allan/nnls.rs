//! Least squares with coefficients that are not negative, by Clarabel.

use clarabel::algebra::CscMatrix;
use clarabel::solver::{DefaultSettingsBuilder, DefaultSolver, IPSolver, NonnegativeConeT};
use nalgebra::{DMatrix, DVector};

/// Why there is no solution.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("the fit of the Allan plot did not come to an end: {reason}")]
pub struct NnlsError {
    reason: String,
}

/// The x >= 0 with the least |a x - b|.
///
/// # Shapes
/// `a`: rows times columns, `b`: rows.
///
/// # Errors
/// A matrix or a vector with values that are not finite; a solver that gives up.
pub(crate) fn nnls(a: &DMatrix<f64>, b: &DVector<f64>) -> Result<DVector<f64>, NnlsError> {
    let fault = |reason: &str| NnlsError { reason: reason.to_owned() };
    let n = a.ncols();
    // Columns of length 1: their entries span many powers of ten.
    let lengths: Vec<f64> = (0..n).map(|k| a.column(k).norm()).collect();
    if lengths.iter().any(|l| !(l.is_finite() && *l > 0.0)) || b.iter().any(|v| !v.is_finite()) {
        return Err(fault("values that are not finite"));
    }
    let scaled = DMatrix::from_fn(a.nrows(), n, |i, k| a[(i, k)] / lengths[k]);
    let size = b.norm().max(f64::MIN_POSITIVE);
    let gram = scaled.tr_mul(&scaled);
    let right = scaled.tr_mul(b) / size;
    let (mut pointers, mut rows, mut values) = (vec![0], Vec::new(), Vec::new());
    for column in 0..n {
        for row in 0..=column {
            rows.push(row);
            values.push(gram[(row, column)]);
        }
        pointers.push(rows.len());
    }
    let p = CscMatrix::new(n, n, pointers, rows, values);
    let q: Vec<f64> = right.iter().map(|v| -v).collect();
    let constraints = CscMatrix::new(n, n, (0..=n).collect(), (0..n).collect(), vec![-1.0; n]);
    let settings = DefaultSettingsBuilder::default()
        .verbose(false)
        .tol_gap_abs(1e-13)
        .tol_gap_rel(1e-13)
        .tol_feas(1e-13)
        .build()
        .map_err(|error| fault(&error.to_string()))?;
    let mut solver =
        DefaultSolver::new(&p, &q, &constraints, &vec![0.0; n], &[NonnegativeConeT(n)], settings)
            .map_err(|error| fault(&error.to_string()))?;
    solver.solve();
    let solution = &solver.solution;
    if solution.x.iter().any(|v| !v.is_finite()) {
        return Err(fault(&format!("{:?}", solution.status)));
    }
    // An interior point is never at the wall: what is held there by its multiplier is put there, and the others solved exactly.
    let free: Vec<usize> = (0..n).filter(|&k| solution.x[k] > solution.z[k]).collect();
    let mut x = DVector::zeros(n);
    if free.is_empty() {
        return Ok(x);
    }
    let exact = DMatrix::from_fn(a.nrows(), free.len(), |i, k| scaled[(i, free[k])])
        .svd(true, true)
        .solve(b, 1e-13)
        .map_err(fault)?;
    let all_positive = exact.iter().all(|v| *v >= 0.0);
    for (at, &k) in free.iter().enumerate() {
        let value = if all_positive { exact[at] } else { solution.x[k] * size };
        x[k] = value / lengths[k];
    }
    Ok(x)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_conditions_of_an_optimum_hold_on_many_problems() {
        use rand::Rng;
        let mut rng = dpn_core::random::Stream::new(3).named("nnls").rng();
        for _ in 0..200 {
            let a =
                DMatrix::from_fn(12, 5, |_, k| rng.random_range(-1.0..1.0) * 10f64.powi(3 * k as i32 - 6));
            let b = DVector::from_fn(12, |_, _| rng.random_range(-1.0..1.0));
            let x = nnls(&a, &b).unwrap();
            let gradient = a.tr_mul(&(&a * &x - &b));
            for k in 0..5 {
                let length = a.column(k).norm();
                assert!(x[k] >= 0.0);
                // Zero slope where free, upwards where held.
                assert!(gradient[k] / length > -1e-7, "{k}: {}", gradient[k] / length);
                assert!(
                    x[k] == 0.0 || gradient[k].abs() / length < 1e-7,
                    "{k}: {} {}",
                    x[k],
                    gradient[k] / length
                );
            }
        }
    }

    #[test]
    fn what_is_not_finite_is_refused() {
        let a = DMatrix::from_element(2, 1, f64::NAN);
        assert!(nnls(&a, &DVector::zeros(2)).is_err());
    }
}
