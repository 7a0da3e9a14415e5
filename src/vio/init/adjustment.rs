//! What the initialisation's two adjustments share: each is a [`Window`] of its own, from which no frame leaves.
//!
//! The window's factors, loss, elimination of landmarks and solver serve both; they differ in what is known. The visual one has no
//! inertial measurements, and its prior holds what only those would tell; the visual-inertial one has all. Tracks begin with a
//! deviation that is assumed, and get the one that their own residuals have ([`track_std_factor`]).

use super::robust;
use crate::window::{Window, WindowConfig};
use nalgebra::{Isometry3, Matrix2, Vector2};

/// A sighting's residual against the host's holds both errors: so much larger than a track's own deviation it is.
const OF_TWO: f64 = std::f64::consts::SQRT_2;
/// Deviations of a track beyond which a sighting is dropped.
pub(super) const OUTLIER_DEVIATIONS: f64 = 4.0;

/// Gauss-Newton steps after each search.
const SETTLING: usize = 4;

/// An empty window with the initialisation's settings; rays parted by less than `min_angle` \[rad\] tell no depth.
pub(super) fn window(body_from_cam: Isometry3<f64>, min_angle: f64) -> Window {
    let config = WindowConfig {
        pixel_std: 1.0,
        outlier_px: OF_TWO * OUTLIER_DEVIATIONS,
        loss: robust::LOSS,
        loss_scale: OF_TWO * robust::LOSS_SCALE,
        cost_tolerance: 1e-6,
        min_triangulation_angle: min_angle,
        ..WindowConfig::default()
    };
    Window::new(config, body_from_cam)
}

/// Moves to the least cost in at most `steps` steps.
pub(super) fn solve(window: &mut Window, steps: usize) {
    window.config.max_iterations = steps;
    window.optimise();
    window.settle(SETTLING);
}

/// By what factor the sightings are farther off than they say, each direction of each, the host's too; 0 without any.
///
/// From the median, with `unknowns(landmarks)` of the rows taken as explained.
pub(super) fn track_std_factor(window: &Window, unknowns: impl Fn(usize) -> f64) -> f64 {
    let mut residuals = Vec::new();
    let mut landmarks = 0;
    for landmark in &window.landmarks {
        let Some(inverse_depth) = landmark.inverse_depth else { continue };
        let host = landmark.host_sighting();
        let rows: Vec<(Vector2<f64>, Matrix2<f64>)> = landmark.sightings[1..]
            .iter()
            .map(|(target, seen)| {
                let geometry = window.geometry(landmark.host(), *target);
                let at = geometry.linearise(host, seen, inverse_depth);
                let d = at.d_host_pixel(&host.spread);
                (at.residual, Matrix2::from_fn(|r, c| d[r][c]))
            })
            .collect();
        // The host's error, which its own measurement holds to 0 +- 1.
        let (mut information, mut gradient) = (Matrix2::identity(), Vector2::zeros());
        for (residual, d) in &rows {
            let squared = residual.norm_squared();
            let (_, weight) = window.loss(squared);
            information += weight * d.tr_mul(d);
            gradient += weight * d.tr_mul(residual);
        }
        let Some(inverse) = information.try_inverse() else { continue };
        let error = -inverse * gradient;
        landmarks += 1;
        residuals.extend(error.iter().map(|r| r.abs()));
        residuals.extend(rows.iter().flat_map(|(residual, d)| {
            let left = residual + d * error;
            [left.x.abs(), left.y.abs()]
        }));
    }
    let rows = residuals.len() as f64;
    let redundancy = (rows - unknowns(landmarks)).max(0.2 * rows);
    (rows / redundancy.max(1.0)).sqrt() * robust::std_of_median(robust::median(residuals))
}

/// Says that all sightings are `factor` times as far off as thought.
pub(super) fn rescale(window: &mut Window, factor: f64) {
    let sightings = window.landmarks.iter_mut().flat_map(|l| &mut l.sightings);
    sightings.for_each(|(_, sighting)| sighting.rescale(factor));
}

/// Moves to where the adjustment settles, however long that takes.
#[cfg(test)]
pub(super) fn settle(window: &mut Window) {
    solve(window, 30);
    window.settle(20);
}
