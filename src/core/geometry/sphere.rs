//! Directions: an orthonormal basis of the tangent plane at a unit vector.

use nalgebra::{Matrix3x2, Vector3};

/// Two orthonormal columns, both orthogonal to the unit vector `direction`; right-handed with it as the third.
///
/// Continuous everywhere but where z changes sign. Source: Duff et al. 2017, *Building an Orthonormal Basis, Revisited*.
#[inline]
pub fn tangent_basis(direction: &Vector3<f64>) -> Matrix3x2<f64> {
    let n = direction;
    let sign = 1f64.copysign(n.z);
    let a = -1.0 / (sign + n.z);
    let b = n.x * n.y * a;
    Matrix3x2::new(1.0 + sign * n.x * n.x * a, b, sign * b, sign + n.y * n.y * a, -sign * n.x, -n.y)
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{Matrix2, Vector2};
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn the_basis_is_orthonormal_and_orthogonal_to_the_direction(v in prop::array::uniform3(-1.0..1.0f64)) {
            let v = Vector3::from(v);
            prop_assume!(v.norm() > 1e-3);
            let n = v.normalize();
            let basis = tangent_basis(&n);
            prop_assert!((basis.transpose() * basis - Matrix2::identity()).norm() < 1e-12);
            prop_assert!((basis.transpose() * n - Vector2::zeros()).norm() < 1e-12);
            let third = basis.column(0).cross(&basis.column(1));
            prop_assert!((third - n).norm() < 1e-12);
        }
    }

    #[test]
    fn the_poles_have_a_basis() {
        for z in [1.0, -1.0] {
            let basis = tangent_basis(&Vector3::new(0.0, 0.0, z));
            assert!((basis.transpose() * basis - Matrix2::identity()).norm() < 1e-15);
        }
    }
}
