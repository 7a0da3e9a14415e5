//! The orthogonal matrices nearest to a matrix.

use nalgebra::{Matrix3, Rotation3};

/// The rotation and the reflection nearest to `matrix` by the sum of squares of entries: of a sum of `b a^T`, what turns the vectors a into b best (Wahba's
/// problem, by singular values). The identity and its negative where there are no singular values, as of what is not finite.
pub fn nearest_orthogonal(matrix: &Matrix3<f64>) -> (Rotation3<f64>, Matrix3<f64>) {
    let svd = matrix.svd(true, true);
    let (Some(u), Some(v_t)) = (svd.u, svd.v_t) else {
        return (Rotation3::identity(), -Matrix3::identity());
    };
    let mut smallest = Matrix3::identity();
    smallest[(2, 2)] = (u * v_t).determinant().signum();
    let mut other = smallest;
    other[(2, 2)] *= -1.0;
    (Rotation3::from_matrix_unchecked(u * smallest * v_t), u * other * v_t)
}
