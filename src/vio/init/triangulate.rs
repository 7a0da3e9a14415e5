//! A point from the directions in which cameras of known pose see it.
//!
//! Gauss-Newton on the point's direction and inverse distance ([`Landmark`]), from infinity: the problem is nearly linear there,
//! so that near and far points take the same way and a far one ends with an inverse distance near 0 instead of nowhere.

use super::bundle::{Camera, Landmark};
use super::robust;
use nalgebra::{Matrix3, Vector3};

/// Gauss-Newton steps; the first are with unit weights.
const STEPS: usize = 8;

/// A triangulated point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Triangulated {
    /// Where.
    pub landmark: Landmark,
    /// Standard deviation of the inverse distance.
    pub inverse_distance_std: f64,
    /// Root mean square of the residuals over the tracks' deviation, two a view.
    pub misfit: f64,
}

/// The point that `views` (camera, measured direction) show best; `None` when they do not agree on one before the cameras.
///
/// `noise` is a track's deviation \[rad\].
pub(super) fn triangulate<'a>(
    origin: &Vector3<f64>,
    views: impl Iterator<Item = (&'a Camera, Vector3<f64>)> + Clone,
    noise: f64,
) -> Option<Triangulated> {
    let direction = views.clone().map(|(camera, f)| camera.to_world(&f)).sum::<Vector3<f64>>();
    let mut landmark = Landmark { direction: direction.try_normalize(1e-6)?, inverse_distance: 0.0 };
    let mut information = Matrix3::zeros();
    for step in 0..STEPS {
        information = Matrix3::zeros();
        let mut gradient = Vector3::zeros();
        for (camera, measured) in views.clone() {
            let Some(rows) = camera.rows(origin, &landmark, &measured) else { continue };
            let squared = rows.residual.norm_squared() / (noise * noise);
            let weight = if step < 3 { 1.0 } else { robust::weight(squared) } / (noise * noise);
            information += weight * rows.d_point.tr_mul(&rows.d_point);
            gradient += weight * rows.d_point.tr_mul(&rows.residual);
        }
        let change = information.try_inverse()? * gradient;
        let moved = landmark.plus(&-change);
        if !moved.inverse_distance.is_finite() || !moved.direction.x.is_finite() {
            return None;
        }
        landmark = moved;
    }
    let (mut squared, mut count) = (0.0, 0);
    for (camera, measured) in views {
        squared += camera.residual(origin, &landmark, &measured)?.norm_squared() / (noise * noise);
        count += 2;
    }
    let covariance = information.try_inverse()?;
    Some(Triangulated {
        landmark,
        inverse_distance_std: covariance[(2, 2)].max(0.0).sqrt(),
        misfit: (squared / f64::from((count - 3).max(1))).sqrt(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{Isometry3, Point3};

    fn cameras() -> Vec<Camera> {
        (0..4)
            .map(|k| {
                let pose = Isometry3::new(
                    Vector3::new(0.2 * f64::from(k), 0.03 * f64::from(k * k), 0.05),
                    Vector3::new(0.02 * f64::from(k), -0.03, 0.1),
                );
                Camera::new(&pose, &Isometry3::identity())
            })
            .collect()
    }

    #[test]
    fn exact_views_give_the_point_near_and_far() {
        let cameras = cameras();
        let origin = Vector3::new(0.3, 0.1, 0.0);
        for point in
            [Vector3::new(0.3, -0.2, 1.0), Vector3::new(1.0, 2.0, 6.0), Vector3::new(-30.0, 20.0, 90.0)]
        {
            let views = cameras.iter().map(|c| {
                let seen = Point3::from(point - c.centre).coords.normalize();
                // `to_world` is a rotation: its transpose brings the direction into the camera.
                let basis = Matrix3::from_columns(
                    &[Vector3::x(), Vector3::y(), Vector3::z()].map(|e| c.to_world(&e)),
                );
                (c, basis.tr_mul(&seen))
            });
            let found = triangulate(&origin, views, 1e-3).unwrap();
            let at = found.landmark.point(&origin).unwrap();
            assert!((at - point).norm() < 1e-6 * point.norm_squared(), "{at} for {point}");
            assert!(found.misfit < 1e-6);
        }
    }

    #[test]
    fn parallel_views_are_a_point_at_infinity_within_its_deviation() {
        let cameras = cameras();
        let views = cameras.iter().map(|c| {
            let basis =
                Matrix3::from_columns(&[Vector3::x(), Vector3::y(), Vector3::z()].map(|e| c.to_world(&e)));
            (c, basis.tr_mul(&Vector3::new(0.1, 0.2, 1.0).normalize()))
        });
        let found = triangulate(&Vector3::zeros(), views, 1e-3).unwrap();
        assert!(found.landmark.inverse_distance.abs() < 1e-9);
        assert!(found.inverse_distance_std > 1e-4);
    }
}
