//! Lenses whose image is a function of the angle off the axis alone: equidistant and field of view.
//!
//! ```text
//! (x', y') = rho(theta) (x, y) / r      r = sqrt(x^2 + y^2),  theta = atan2(r, z)
//! equidistant:    rho = theta (1 + k1 theta^2 + k2 theta^4 + k3 theta^6 + k4 theta^8)
//! field of view:  rho = atan(2 tan(theta) tan(w / 2)) / w
//! ```
//!
//! Source: Kannala and Brandt 2006, eq. 6, with OpenCV's coefficients; Devernay and Faugeras 2001, with the whole sphere as in Usenko et
//! al. 2018, eq. 29 to 32. Seen is what is nearer the axis than where `rho` stops rising.

use super::fold::first_fold;
use super::lens_model::{LensModel, Placed};
use nalgebra::{Matrix2, Matrix2x3, Vector2, Vector3};
use std::f64::consts::PI;

/// Steps of the inverse: Newton's where they stay between what is known, halvings else.
const STEPS: usize = 60;

/// Nearer the axis than this (as a tangent) the image is that of a plane.
const ON_AXIS: f64 = 1e-9;

/// Kannala and Brandt's equidistant lens.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Equidistant {
    k: [f64; 4],
    /// Largest angle off the axis \[rad\] and its radius.
    widest: f64,
    farthest: f64,
}

impl Equidistant {
    /// With k1 to k4.
    pub fn new(k: [f64; 4]) -> Self {
        let unlimited = Self { k, widest: PI, farthest: 0.0 };
        let widest = first_fold(|theta| unlimited.radius(theta).1, PI).unwrap_or(PI);
        Self { widest, farthest: unlimited.radius(widest).0, ..unlimited }
    }

    pub(super) fn coefficients(&self) -> Vec<f64> {
        self.k.to_vec()
    }

    /// rho above and its derivative.
    fn radius(&self, theta: f64) -> (f64, f64) {
        let [k1, k2, k3, k4] = self.k;
        let t2 = theta * theta;
        let rho = theta * (1.0 + t2 * (k1 + t2 * (k2 + t2 * (k3 + t2 * k4))));
        (rho, 1.0 + t2 * (3.0 * k1 + t2 * (5.0 * k2 + t2 * (7.0 * k3 + t2 * 9.0 * k4))))
    }

    fn angle(&self, rho: f64) -> Option<f64> {
        if rho >= self.farthest || rho.is_nan() {
            return None;
        }
        let (mut low, mut high) = (0.0, self.widest);
        let mut theta = rho.min(0.5 * high);
        for _ in 0..STEPS {
            let (at, slope) = self.radius(theta);
            let error = at - rho;
            if error.abs() < 1e-14 {
                break;
            }
            if error > 0.0 {
                high = theta;
            } else {
                low = theta;
            }
            let next = theta - error / slope;
            theta = if next > low && next < high { next } else { 0.5 * (low + high) };
        }
        Some(theta)
    }
}

impl LensModel for Equidistant {
    fn project(&self, point: &Vector3<f64>) -> Option<Vector2<f64>> {
        let r = point.xy().norm();
        let theta = r.atan2(point.z);
        if theta >= self.widest || theta.is_nan() {
            return None;
        }
        if r <= ON_AXIS * point.z.abs() {
            return (point.z > 0.0).then(|| point.xy() / point.z);
        }
        Some(point.xy() * (self.radius(theta).0 / r))
    }

    fn project_with_jacobian(&self, point: &Vector3<f64>) -> Option<Placed> {
        self.project(point)?;
        let (r, z) = (point.xy().norm(), point.z);
        let (rho, slope) = self.radius(r.atan2(z));
        let squared = r * r + z * z;
        Some(radial(point, r, rho, [slope * z / squared, -slope * r / squared]))
    }

    fn unproject(&self, place: &Vector2<f64>) -> Option<Vector3<f64>> {
        let rho = place.norm();
        let theta = self.angle(rho)?;
        Some(along(place, rho, theta))
    }
}

/// Devernay and Faugeras' field-of-view lens (PTAM's and DSO's "ATAN").
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Fov {
    w: f64,
    /// 2 tan(w / 2).
    stretch: f64,
}

impl Fov {
    /// With the lens' angle `w` \[rad\] between 0 and pi.
    pub fn new(w: f64) -> Option<Self> {
        (w > 0.0 && w < PI).then(|| Self { w, stretch: 2.0 * (0.5 * w).tan() })
    }

    pub(super) fn coefficients(&self) -> Vec<f64> {
        vec![self.w]
    }

    /// How the image grows with the angle at its centre.
    pub(super) fn slope(&self) -> f64 {
        self.stretch / self.w
    }
}

impl LensModel for Fov {
    fn project(&self, point: &Vector3<f64>) -> Option<Vector2<f64>> {
        let r = point.xy().norm();
        if r <= ON_AXIS * point.z.abs() {
            return (point.z > 0.0).then(|| point.xy() * (self.slope() / point.z));
        }
        (r > 0.0).then(|| point.xy() * ((self.stretch * r).atan2(point.z) / (self.w * r)))
    }

    fn project_with_jacobian(&self, point: &Vector3<f64>) -> Option<Placed> {
        self.project(point)?;
        let (r, z) = (point.xy().norm(), point.z);
        let rho = (self.stretch * r).atan2(z) / self.w;
        let common = self.stretch / (self.w * (z * z + (self.stretch * r).powi(2)));
        Some(radial(point, r, rho, [common * z, -common * r]))
    }

    fn unproject(&self, place: &Vector2<f64>) -> Option<Vector3<f64>> {
        let rho = place.norm();
        let seen = rho * self.w;
        // tan(theta) = tan(rho w) / stretch, on its own branch.
        (seen < PI).then(|| along(place, rho, seen.sin().atan2(self.stretch * seen.cos())))
    }
}

/// The image of `point` at `rho (x, y) / r`, with rho's derivatives by r and z.
fn radial(point: &Vector3<f64>, r: f64, rho: f64, [d_r, d_z]: [f64; 2]) -> Placed {
    let (x, y, z) = (point.x, point.y, point.z);
    if r <= ON_AXIS * z.abs() {
        let scale = d_r;
        let d_inner = Matrix2x3::new(scale, 0.0, -scale * x / z, 0.0, scale, -scale * y / z);
        return Placed { place: point.xy() * scale, d_place: Matrix2::identity(), d_inner };
    }
    let g = rho / r;
    // By r, over r: what x and y multiply.
    let by_r = (d_r - g) / (r * r);
    let by_z = d_z / r;
    let d_inner =
        Matrix2x3::new(g + x * x * by_r, x * y * by_r, x * by_z, x * y * by_r, g + y * y * by_r, y * by_z);
    Placed { place: point.xy() * g, d_place: Matrix2::identity(), d_inner }
}

/// The unit vector `theta` off the axis, towards `place` at radius `rho`.
fn along(place: &Vector2<f64>, rho: f64, theta: f64) -> Vector3<f64> {
    // On the axis itself there is no way aside.
    if rho <= f64::MIN_POSITIVE {
        return Vector3::z();
    }
    (place * (theta.sin() / rho)).push(theta.cos())
}
