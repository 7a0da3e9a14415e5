//! Radial-tangential distortion of a plane, plain or rational.
//!
//! ```text
//! x' = x s + 2 p1 x y + p2 (r2 + 2 x^2)      r2 = x^2 + y^2
//! y' = y s + p1 (r2 + 2 y^2) + 2 p2 x y      s = (1 + k1 r2 + k2 r2^2 + k3 r2^3) / (1 + k4 r2 + k5 r2^2 + k6 r2^3)
//! ```
//!
//! Source: Brown 1966; Heikkila and Silven 1997, eq. 5 to 7; the same as OpenCV with 4, 5 or 8 coefficients.

use super::fold::first_fold;
use super::lens_model::{LensModel, Placed};
use nalgebra::{Matrix2, Matrix2x3, Vector2, Vector3};

/// Newton steps of the undistortion; inside an image of a usable lens three suffice.
const NEWTON_STEPS: usize = 12;

/// Residual in normalised coordinates below which undistortion has arrived: 1e-12 is under a billionth of a pixel.
const NEWTON_TOLERANCE: f64 = 1e-12;

/// A folding point is looked for up to so far off the axis \[rad\].
const WIDEST_RAD: f64 = 1.55;

/// Radial-tangential distortion of the plane `z = 1`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Radtan {
    /// k1, k2, p1, p2, k3.
    upper: [f64; 5],
    /// k4, k5, k6 of a rational lens.
    lower: Option<[f64; 3]>,
    /// Radius squared at which the polynomial folds back.
    fold2: f64,
}

impl Radtan {
    /// With k1, k2, p1, p2, k3 and, of a rational lens, k4, k5, k6.
    pub fn new(upper: [f64; 5], lower: Option<[f64; 3]>) -> Self {
        let unlimited = Self { upper, lower, fold2: f64::INFINITY };
        // In steps of the angle; the derivative of r s by r, negative too where the denominator has passed its root.
        let slope = |angle: f64| {
            let r2 = angle.tan().powi(2);
            let (radial, d_radial) = unlimited.radial(r2);
            let under = lower.map_or(1.0, |[k4, k5, k6]| 1.0 + r2 * (k4 + r2 * (k5 + r2 * k6)));
            if under > 0.0 { radial + 2.0 * r2 * d_radial } else { -1.0 }
        };
        let fold2 = first_fold(slope, WIDEST_RAD).map_or(f64::INFINITY, |angle| angle.tan().powi(2));
        Self { fold2, ..unlimited }
    }

    /// In OpenCV's order, without a k3 of 0 that nothing follows.
    pub(super) fn coefficients(&self) -> Vec<f64> {
        let [.., k3] = self.upper;
        match self.lower {
            Some(lower) => [&self.upper[..], &lower].concat(),
            None if k3 == 0.0 => self.upper[..4].to_vec(),
            None => self.upper.to_vec(),
        }
    }

    /// s above and its derivative by r2.
    fn radial(&self, r2: f64) -> (f64, f64) {
        let [k1, k2, _, _, k3] = self.upper;
        let radial = 1.0 + r2 * (k1 + r2 * (k2 + r2 * k3));
        let d_radial = k1 + r2 * (2.0 * k2 + 3.0 * k3 * r2);
        let Some([k4, k5, k6]) = self.lower else { return (radial, d_radial) };
        let under = 1.0 + r2 * (k4 + r2 * (k5 + r2 * k6));
        let d_under = k4 + r2 * (2.0 * k5 + 3.0 * k6 * r2);
        let ratio = radial / under;
        (ratio, (d_radial - ratio * d_under) / under)
    }

    /// The distorted place of `n`, and the derivative.
    pub(super) fn distort(&self, n: &Vector2<f64>) -> (Vector2<f64>, Matrix2<f64>) {
        let [_, _, p1, p2, _] = self.upper;
        let (x, y) = (n.x, n.y);
        let r2 = x * x + y * y;
        let (radial, d_radial) = self.radial(r2);
        let distorted = Vector2::new(
            x * radial + 2.0 * p1 * x * y + p2 * (r2 + 2.0 * x * x),
            y * radial + p1 * (r2 + 2.0 * y * y) + 2.0 * p2 * x * y,
        );
        let cross = 2.0 * x * y * d_radial + 2.0 * p1 * x + 2.0 * p2 * y;
        let d = Matrix2::new(
            radial + 2.0 * x * x * d_radial + 2.0 * p1 * y + 6.0 * p2 * x,
            cross,
            cross,
            radial + 2.0 * y * y * d_radial + 6.0 * p1 * y + 2.0 * p2 * x,
        );
        (distorted, d)
    }

    /// Whether `n` is nearer than where the polynomial folds back.
    pub(super) fn holds(&self, n: &Vector2<f64>) -> bool {
        n.norm_squared() < self.fold2
    }

    /// The place whose distorted one is `target`; `None` where there is none.
    pub(super) fn undistort(&self, target: &Vector2<f64>) -> Option<Vector2<f64>> {
        let mut n = *target;
        for _ in 0..NEWTON_STEPS {
            let (distorted, d) = self.distort(&n);
            let error = target - distorted;
            if error.norm_squared() < NEWTON_TOLERANCE * NEWTON_TOLERANCE {
                return Some(n).filter(|n| self.holds(n));
            }
            n += d.try_inverse()? * error;
        }
        let (distorted, d) = self.distort(&n);
        // Past the fold the polynomial has other roots; there the determinant is negative.
        ((target - distorted).norm() < 1e-9 && d.determinant() > 0.0 && self.holds(&n)).then_some(n)
    }
}

impl LensModel for Radtan {
    fn project(&self, point: &Vector3<f64>) -> Option<Vector2<f64>> {
        if point.z <= 0.0 {
            return None;
        }
        let normalised = point.xy() / point.z;
        self.holds(&normalised).then(|| self.distort(&normalised).0)
    }

    fn project_with_jacobian(&self, point: &Vector3<f64>) -> Option<Placed> {
        if point.z <= 0.0 {
            return None;
        }
        let inverse_z = 1.0 / point.z;
        let n = point.xy() * inverse_z;
        if !self.holds(&n) {
            return None;
        }
        let d_inner = Matrix2x3::new(inverse_z, 0.0, -n.x * inverse_z, 0.0, inverse_z, -n.y * inverse_z);
        let (place, d_place) = self.distort(&n);
        Some(Placed { place, d_place, d_inner })
    }

    fn unproject(&self, place: &Vector2<f64>) -> Option<Vector3<f64>> {
        self.undistort(place).map(|n| n.push(1.0))
    }
}
