//! Lenses with a sphere, an ellipsoid or two spheres before the plane: unified (MEI, omnidirectional), enhanced unified, double sphere.
//!
//! ```text
//! unified:        n = (x, y) / (z + xi d),  d = |p|;  then radial-tangential distortion of n (k1, k2, p1, p2)
//! enhanced:       (x', y') = (x, y) / (alpha d + (1 - alpha) z),  d = sqrt(beta (x^2 + y^2) + z^2)
//! double sphere:  (x', y') = (x, y) / (alpha d2 + (1 - alpha) z1),  z1 = z + xi d,  d2 = sqrt(x^2 + y^2 + z1^2)
//! ```
//!
//! Source: Mei and Rives 2007 as OpenCV's `omnidir` and Kalibr's `omni` have it; Khomutenko, Garcia and Martinet 2016, eq. 8 to 14, for the enhanced one; Usenko, Demmel and Cremers 2018, eq. 40 to 49, for the
//! double sphere and for the domains (their eq. 13 to 19 with alpha = xi / (1 + xi)).

use super::lens_model::{LensModel, Placed};
use super::radtan::Radtan;
use nalgebra::{Matrix2, Matrix2x3, RowVector3, Vector2, Vector3};

/// The unified lens with radial-tangential distortion.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Omni {
    xi: f64,
    distortion: Radtan,
    /// Seen is what has `z > -back |p|`.
    back: f64,
}

impl Omni {
    /// With xi (not negative) and k1, k2, p1, p2.
    pub fn new(xi: f64, [k1, k2, p1, p2]: [f64; 4]) -> Option<Self> {
        let distortion = Radtan::new([k1, k2, p1, p2, 0.0], None);
        (xi >= 0.0).then(|| Self { xi, distortion, back: if xi <= 1.0 { xi } else { 1.0 / xi } })
    }

    pub(super) fn coefficients(&self) -> Vec<f64> {
        [&[self.xi], self.distortion.coefficients().as_slice()].concat()
    }

    /// How the image grows with the angle at its centre.
    pub(super) fn slope(&self) -> f64 {
        1.0 / (1.0 + self.xi)
    }

    /// n above and z + xi d.
    fn plane(&self, point: &Vector3<f64>) -> Option<(Vector2<f64>, f64)> {
        let length = point.norm();
        let under = point.z + self.xi * length;
        if !(point.z > -self.back * length && under > 0.0) {
            return None;
        }
        Some((point.xy() / under, under)).filter(|(n, _)| self.distortion.holds(n))
    }
}

impl LensModel for Omni {
    fn project(&self, point: &Vector3<f64>) -> Option<Vector2<f64>> {
        let (n, _) = self.plane(point)?;
        Some(self.distortion.distort(&n).0)
    }

    fn project_with_jacobian(&self, point: &Vector3<f64>) -> Option<Placed> {
        let (n, under) = self.plane(point)?;
        let d_under = (point * (self.xi / point.norm()) + Vector3::z()).transpose();
        let (place, d_place) = self.distortion.distort(&n);
        Some(Placed { place, d_place, d_inner: quotient(&n, under, &d_under) })
    }

    fn unproject(&self, place: &Vector2<f64>) -> Option<Vector3<f64>> {
        let n = self.distortion.undistort(place)?;
        let r2 = n.norm_squared();
        let root = 1.0 + (1.0 - self.xi * self.xi) * r2;
        if root < 0.0 {
            return None;
        }
        let scale = (self.xi + root.sqrt()) / (1.0 + r2);
        Some((n * scale).push(scale - self.xi))
    }
}

/// The enhanced unified lens.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EnhancedUnified {
    alpha: f64,
    beta: f64,
    /// Seen is what has `z > -back d`.
    back: f64,
}

impl EnhancedUnified {
    /// With alpha between 0 and 1 and beta above 0.
    pub fn new(alpha: f64, beta: f64) -> Option<Self> {
        if !((0.0..=1.0).contains(&alpha) && beta > 0.0 && beta.is_finite()) {
            return None;
        }
        Some(Self { alpha, beta, back: farthest_back(alpha) })
    }

    pub(super) fn coefficients(&self) -> Vec<f64> {
        vec![self.alpha, self.beta]
    }

    /// d and the denominator.
    fn lengths(&self, point: &Vector3<f64>) -> Option<[f64; 2]> {
        let length = (self.beta * point.xy().norm_squared() + point.z * point.z).sqrt();
        let under = self.alpha * length + (1.0 - self.alpha) * point.z;
        (point.z > -self.back * length && under > 0.0).then_some([length, under])
    }
}

impl LensModel for EnhancedUnified {
    fn project(&self, point: &Vector3<f64>) -> Option<Vector2<f64>> {
        let [_, under] = self.lengths(point)?;
        Some(point.xy() / under)
    }

    fn project_with_jacobian(&self, point: &Vector3<f64>) -> Option<Placed> {
        let [length, under] = self.lengths(point)?;
        let place = point.xy() / under;
        let d_length = Vector3::new(self.beta * point.x, self.beta * point.y, point.z) / length;
        let d_under = (d_length * self.alpha + Vector3::z() * (1.0 - self.alpha)).transpose();
        Some(Placed { place, d_place: Matrix2::identity(), d_inner: quotient(&place, under, &d_under) })
    }

    fn unproject(&self, place: &Vector2<f64>) -> Option<Vector3<f64>> {
        let (alpha, scaled) = (self.alpha, self.beta * place.norm_squared());
        let inner = 1.0 - (2.0 * alpha - 1.0) * scaled;
        if inner < 0.0 {
            return None;
        }
        let under = alpha * inner.sqrt() + 1.0 - alpha;
        (under > 0.0).then(|| place.push((1.0 - alpha * alpha * scaled) / under))
    }
}

/// The double-sphere lens.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DoubleSphere {
    xi: f64,
    alpha: f64,
    /// Seen is what has `z > -back |p|`.
    back: f64,
}

impl DoubleSphere {
    /// With xi above -1 and alpha between 0 and 1.
    pub fn new(xi: f64, alpha: f64) -> Option<Self> {
        if !(xi > -1.0 && xi.is_finite() && (0.0..=1.0).contains(&alpha)) {
            return None;
        }
        let w1 = farthest_back(alpha);
        let back = (w1 + xi) / (2.0 * w1 * xi + xi * xi + 1.0).sqrt();
        Some(Self { xi, alpha, back })
    }

    pub(super) fn coefficients(&self) -> Vec<f64> {
        vec![self.xi, self.alpha]
    }

    /// How the image grows with the angle at its centre.
    pub(super) fn slope(&self) -> f64 {
        1.0 / (1.0 + self.xi)
    }

    /// |p|, z1, d2 and the denominator.
    fn lengths(&self, point: &Vector3<f64>) -> Option<[f64; 4]> {
        let length = point.norm();
        let shifted = point.z + self.xi * length;
        let second = (point.xy().norm_squared() + shifted * shifted).sqrt();
        let under = self.alpha * second + (1.0 - self.alpha) * shifted;
        (point.z > -self.back * length && under > 0.0).then_some([length, shifted, second, under])
    }
}

impl LensModel for DoubleSphere {
    fn project(&self, point: &Vector3<f64>) -> Option<Vector2<f64>> {
        let [.., under] = self.lengths(point)?;
        Some(point.xy() / under)
    }

    fn project_with_jacobian(&self, point: &Vector3<f64>) -> Option<Placed> {
        let [length, shifted, second, under] = self.lengths(point)?;
        let place = point.xy() / under;
        let d_shifted = point * (self.xi / length) + Vector3::z();
        let d_second = (Vector3::new(point.x, point.y, 0.0) + d_shifted * shifted) / second;
        let d_under = (d_second * self.alpha + d_shifted * (1.0 - self.alpha)).transpose();
        Some(Placed { place, d_place: Matrix2::identity(), d_inner: quotient(&place, under, &d_under) })
    }

    fn unproject(&self, place: &Vector2<f64>) -> Option<Vector3<f64>> {
        let (alpha, xi, r2) = (self.alpha, self.xi, place.norm_squared());
        let inner = 1.0 - (2.0 * alpha - 1.0) * r2;
        if inner < 0.0 {
            return None;
        }
        let z = (1.0 - alpha * alpha * r2) / (alpha * inner.sqrt() + 1.0 - alpha);
        let root = z * z + (1.0 - xi * xi) * r2;
        if root < 0.0 {
            return None;
        }
        let scale = (z * xi + root.sqrt()) / (z * z + r2);
        Some((place * scale).push(scale * z - xi))
    }
}

/// How far behind the lens's middle a point may be, for its distance, with alpha between the sphere's centre and the lens.
fn farthest_back(alpha: f64) -> f64 {
    if alpha <= 0.5 { alpha / (1.0 - alpha) } else { (1.0 - alpha) / alpha }
}

/// Derivative of `n = (x, y) / under` by the point.
fn quotient(n: &Vector2<f64>, under: f64, d_under: &RowVector3<f64>) -> Matrix2x3<f64> {
    (Matrix2x3::new(1.0, 0.0, 0.0, 0.0, 1.0, 0.0) - n * d_under) / under
}
