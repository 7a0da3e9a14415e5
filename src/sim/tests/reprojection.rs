//! How well tracks agree with a path: every track's point is triangulated from the path's poses and projected back.
//!
//! A point starts where it is nearest to all rays, `sum (I - b b^T) (X - c) = 0`, and is refined by Gauss-Newton on pixels. A fit through
//! `n` positions takes 3 of their 2 n degrees of freedom, so residuals are scaled by sqrt(2 n / (2 n - 3)); the deviation over all is taken from their
//! median, which outliers hardly move.

use dpn_core::TrackFrame;
use dpn_core::signal::stats;
use dpn_sim::tracks::{BadCameraSettings, CameraPath, CameraSettings};
use nalgebra::{Isometry3, Matrix3, Vector2, Vector3};
use std::collections::BTreeMap;

/// Rounds of Gauss-Newton; from a triangulated start three settle to under .001 px.
const ROUNDS: usize = 4;

/// Residuals of tracks against a path.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Reprojection {
    /// Tracks that could be triangulated.
    pub(crate) tracks: usize,
    /// Robust standard deviation of a position, each axis \[px\].
    pub(crate) sigma_px: f64,
    /// Share of the tracks with a residual beyond 6 such deviations.
    pub(crate) outlier_share: f64,
}

/// A camera at one frame and what it saw of one point.
struct View {
    cam_from_world: Isometry3<f64>,
    px: Vector2<f64>,
}

impl Reprojection {
    /// Holds tracks of at least `least` frames against `path`; `None` when no track could be triangulated.
    ///
    /// # Errors
    /// Settings that describe no camera.
    pub(crate) fn of(
        frames: &[TrackFrame],
        path: &dyn CameraPath,
        camera: &CameraSettings,
        least: usize,
    ) -> Result<Option<Self>, BadCameraSettings> {
        let (model, body_from_cam) = (camera.model()?, camera.body_from_cam()?);
        let mut views: BTreeMap<u64, Vec<View>> = BTreeMap::new();
        for frame in frames {
            let Some(pose) = path.world_from_body(frame.t) else { continue };
            let cam_from_world = (pose * body_from_cam).inverse();
            for track in &frame.tracks {
                views.entry(track.id).or_default().push(View { cam_from_world, px: track.px });
            }
        }
        let mut all: Vec<f64> = Vec::new();
        let mut worst: Vec<f64> = Vec::new();
        for views in views.values().filter(|views| views.len() >= least.max(2)) {
            let Some(point) = triangulate(&model, views) else { continue };
            let n = 2.0 * views.len() as f64;
            let scale = (n / (n - 3.0)).sqrt();
            let residuals = views.iter().filter_map(|view| {
                let px = model.project(
                    &(view.cam_from_world.rotation * point + view.cam_from_world.translation.vector),
                )?;
                Some((view.px - px) * scale)
            });
            let first = all.len();
            all.extend(residuals.flat_map(|r| [r.x.abs(), r.y.abs()]));
            worst.push(all[first..].iter().copied().fold(0.0, f64::max));
        }
        if worst.is_empty() {
            return Ok(None);
        }
        // The median of |x| over sigma, for Gaussian x.
        const MEDIAN_ABS: f64 = 0.674_489_750_196_081_7;
        let sigma_px = stats::median_in_place(&mut all) / MEDIAN_ABS;
        let outliers = worst.iter().filter(|worst| **worst > 6.0 * sigma_px).count();
        Ok(Some(Self { tracks: worst.len(), sigma_px, outlier_share: outliers as f64 / worst.len() as f64 }))
    }
}

/// The point that fits all views best; `None` when rays are parallel or it falls behind a camera.
fn triangulate(model: &dpn_core::camera::CameraModel, views: &[View]) -> Option<Vector3<f64>> {
    let (mut normal, mut rhs) = (Matrix3::zeros(), Vector3::zeros());
    for view in views {
        let world_from_cam = view.cam_from_world.inverse();
        let ray = world_from_cam.rotation * model.bearing(&view.px)?;
        let across = Matrix3::identity() - ray * ray.transpose();
        normal += across;
        rhs += across * world_from_cam.translation.vector;
    }
    let mut point = normal.cholesky()?.solve(&rhs);
    for _ in 0..ROUNDS {
        let (mut normal, mut rhs) = (Matrix3::zeros(), Vector3::zeros());
        for view in views {
            let pose = &view.cam_from_world;
            let (px, d_px_d_point_in_cam) =
                model.project_with_jacobian(&(pose.rotation * point + pose.translation.vector))?;
            let jacobian = d_px_d_point_in_cam * pose.rotation.to_rotation_matrix().matrix();
            normal += jacobian.transpose() * jacobian;
            rhs += jacobian.transpose() * (view.px - px);
        }
        point += normal.cholesky()?.solve(&rhs);
    }
    point.iter().all(|v| v.is_finite()).then_some(point)
}
