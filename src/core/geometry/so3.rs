//! The rotation group: exponential, logarithm and right Jacobians.
//!
//! `Exp: R^3 -> SO(3)` takes a rotation vector \[rad\]. With `t = |v|` and `V = hat(v)`:
//!
//! ```text
//! Exp(v + d)        = Exp(v) Exp(Jr(v) d)            + O(d^2)
//! Log(Exp(v) Exp(d)) = v + Jr(v)^-1 d                + O(d^2)
//! Jr(v)    = I - (1 - cos t)/t^2 V + (t - sin t)/t^3 V^2
//! Jr(v)^-1 = I + V/2 + (1/t^2 - (1 + cos t)/(2 t sin t)) V^2
//! ```
//!
//! Source: Chirikjian, *Stochastic Models, Information Theory, and Lie Groups*, vol. 2, p. 40; Forster et al. 2017, eq. 8 and 9.

use nalgebra::{Matrix3, Quaternion, UnitQuaternion, Vector3};

/// Below this squared angle \[rad^2\] the series replace the closed forms: their next terms are under 1e-16.
const SMALL_ANGLE_SQUARED: f64 = 1e-7;

/// The matrix of the cross product: `hat(a) b = a x b`.
#[inline]
pub fn hat(v: &Vector3<f64>) -> Matrix3<f64> {
    Matrix3::new(0.0, -v.z, v.y, v.z, 0.0, -v.x, -v.y, v.x, 0.0)
}

/// The rotation by a rotation vector \[rad\].
#[inline]
pub fn exp(v: &Vector3<f64>) -> UnitQuaternion<f64> {
    let angle_squared = v.norm_squared();
    let (w, factor) = if angle_squared < SMALL_ANGLE_SQUARED {
        let q = 0.25 * angle_squared;
        (1.0 - q / 2.0 + q * q / 24.0, 0.5 * (1.0 - q / 6.0 + q * q / 120.0))
    } else {
        let angle = angle_squared.sqrt();
        let (sin, cos) = (0.5 * angle).sin_cos();
        (cos, sin / angle)
    };
    UnitQuaternion::new_unchecked(Quaternion::from_parts(w, factor * v))
}

/// The rotation vector \[rad\], of length at most pi, of a rotation.
#[inline]
pub fn log(rotation: &UnitQuaternion<f64>) -> Vector3<f64> {
    // The quaternion and its negative are one rotation; the scalar part is made positive for the short way round.
    let q = rotation.quaternion();
    let (w, v) = if q.w < 0.0 { (-q.w, -q.imag()) } else { (q.w, q.imag()) };
    let sin_squared = v.norm_squared();
    if sin_squared < SMALL_ANGLE_SQUARED {
        // 2 atan(s/w)/s = 2/w (1 - (s/w)^2/3 + (s/w)^4/5)
        let ratio = sin_squared / (w * w);
        (2.0 / w) * (1.0 - ratio / 3.0 + ratio * ratio / 5.0) * v
    } else {
        let sin = sin_squared.sqrt();
        (2.0 * sin.atan2(w) / sin) * v
    }
}

/// `Jr(v)`: how a change of the rotation vector moves the rotation, seen from the right.
#[inline]
pub fn right_jacobian(v: &Vector3<f64>) -> Matrix3<f64> {
    let t2 = v.norm_squared();
    let (a, b) = if t2 < SMALL_ANGLE_SQUARED {
        (0.5 - t2 / 24.0, 1.0 / 6.0 - t2 / 120.0)
    } else {
        let t = t2.sqrt();
        let (sin, cos) = t.sin_cos();
        ((1.0 - cos) / t2, (t - sin) / (t2 * t))
    };
    let hat_v = hat(v);
    Matrix3::identity() - a * hat_v + b * (hat_v * hat_v)
}

/// `Jr(v)^-1`: how a small rotation on the right moves the rotation vector. Finite for angles below two pi.
#[inline]
pub fn right_jacobian_inverse(v: &Vector3<f64>) -> Matrix3<f64> {
    let t2 = v.norm_squared();
    let c = if t2 < SMALL_ANGLE_SQUARED {
        1.0 / 12.0 + t2 / 720.0
    } else {
        // (1 + cos t)/(2 t sin t) = cot(t/2)/(2t), which stays finite at pi.
        let t = t2.sqrt();
        1.0 / t2 - 0.5 / (t * (0.5 * t).tan())
    };
    let hat_v = hat(v);
    Matrix3::identity() + 0.5 * hat_v + c * (hat_v * hat_v)
}

#[cfg(test)]
mod tests {
    use super::*;
    use dpn_testing::check_jacobian;
    use nalgebra::DVector;
    use proptest::prelude::*;
    use std::f64::consts::PI;

    fn rotation_vector(max_angle: f64) -> impl Strategy<Value = Vector3<f64>> {
        // Angles spread over decades, so that both sides of the small-angle branch are met.
        (prop::array::uniform3(-1.0..1.0f64), -9.0..0.0f64).prop_filter_map(
            "no axis",
            move |(axis, decade)| {
                let axis = Vector3::from(axis);
                (axis.norm() > 1e-3).then(|| axis.normalize() * max_angle * 10f64.powf(decade))
            },
        )
    }

    proptest! {
        #[test]
        fn log_undoes_exp(v in rotation_vector(PI * 0.9999)) {
            prop_assert!((log(&exp(&v)) - v).norm() < 1e-12 * v.norm().max(1e-3));
        }

        #[test]
        fn exp_agrees_with_nalgebra(v in rotation_vector(3.0 * PI)) {
            prop_assert!(exp(&v).angle_to(&UnitQuaternion::from_scaled_axis(v)) < 1e-7);
            prop_assert!((exp(&v).norm() - 1.0).abs() < 1e-14);
        }

        #[test]
        fn the_right_jacobian_is_the_derivative_of_exp(v in rotation_vector(3.0)) {
            check_jacobian("Jr", &right_jacobian(&v), 1e-7, |d| {
                let moved = exp(&(v + Vector3::from_column_slice(d.as_slice())));
                DVector::from_column_slice(log(&(exp(&v).inverse() * moved)).as_slice())
            });
        }

        #[test]
        fn the_inverse_is_the_inverse(v in rotation_vector(5.0)) {
            let product = right_jacobian(&v) * right_jacobian_inverse(&v);
            prop_assert!((product - Matrix3::identity()).norm() < 1e-10);
        }
    }

    #[test]
    fn both_sides_of_the_small_angle_branch_agree() {
        let axis = Vector3::new(0.3, -0.5, 0.8).normalize();
        let angle = SMALL_ANGLE_SQUARED.sqrt();
        let (below, above) = (axis * angle * (1.0 - 1e-9), axis * angle * (1.0 + 1e-9));
        assert!((right_jacobian(&below) - right_jacobian(&above)).norm() < 1e-11);
        assert!((right_jacobian_inverse(&below) - right_jacobian_inverse(&above)).norm() < 1e-9);
        assert!((exp(&below).coords - exp(&above).coords).norm() < 1e-12);
    }

    #[test]
    fn hat_is_the_cross_product() {
        let (a, b) = (Vector3::new(1.0, -2.0, 0.5), Vector3::new(0.1, 0.7, -3.0));
        assert_eq!(hat(&a) * b, a.cross(&b));
    }
}
