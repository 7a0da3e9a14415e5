//! The unknowns, their order, and the cost of a bundle.

use super::inertial::InertialFactor;
use super::landmark::{Camera, Landmark};
use super::prior::Prior;
use crate::init::robust;
use crate::state::{ImuBias, POSE_DIM, pose_plus};
use nalgebra::{DVector, Isometry3, Vector3};

/// Squared, whitened residual that a view counts whose point came to lie behind its camera.
const BEHIND_SQUARED: f64 = 1e4;

/// Where each unknown stands: frame after frame, then the bias. Points are apart.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Layout {
    frames: usize,
    inertial: bool,
}

impl Layout {
    /// Poses alone.
    pub(crate) fn visual(frames: usize) -> Self {
        Self { frames, inertial: false }
    }

    /// Poses, velocities and one bias.
    pub(crate) fn inertial(frames: usize) -> Self {
        Self { frames, inertial: true }
    }

    /// Unknowns without the points'.
    pub(crate) fn len(&self) -> usize {
        if self.inertial { 9 * self.frames + 6 } else { POSE_DIM * self.frames }
    }

    /// Number of frames.
    pub(crate) fn frames(&self) -> usize {
        self.frames
    }

    /// First column of a frame's position; with the rotation behind it, the pose's six.
    pub(crate) fn position(&self, frame: usize) -> usize {
        frame * if self.inertial { 9 } else { POSE_DIM }
    }

    /// First column of a frame's rotation.
    pub(crate) fn rotation(&self, frame: usize) -> usize {
        self.position(frame) + 3
    }

    /// First column of a frame's velocity.
    pub(crate) fn velocity(&self, frame: usize) -> Option<usize> {
        self.inertial.then(|| self.position(frame) + POSE_DIM)
    }

    /// First column of the bias: accelerometer, gyro.
    pub(crate) fn bias(&self) -> Option<usize> {
        self.inertial.then_some(9 * self.frames)
    }
}

/// Values of all unknowns.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct BundleState {
    /// World from body, a frame each.
    pub poses: Vec<Isometry3<f64>>,
    /// World frame \[m/s\], a frame each; unused without the IMU.
    pub velocities: Vec<Vector3<f64>>,
    /// Of all frames.
    pub bias: ImuBias,
    /// The points.
    pub landmarks: Vec<Landmark>,
}

impl BundleState {
    /// The state moved by `d` (see [`Layout`]) and its points by `points` (none moves where empty).
    pub(crate) fn plus(&self, layout: &Layout, d: &DVector<f64>, points: &[Vector3<f64>]) -> Self {
        let mut moved = self.clone();
        for frame in 0..layout.frames() {
            let step = d.fixed_rows::<POSE_DIM>(layout.position(frame)).into_owned();
            moved.poses[frame] = pose_plus(&self.poses[frame], &step);
            if let Some(at) = layout.velocity(frame) {
                moved.velocities[frame] += d.fixed_rows::<3>(at);
            }
        }
        if let Some(at) = layout.bias() {
            moved.bias.accel += d.fixed_rows::<3>(at);
            moved.bias.gyro += d.fixed_rows::<3>(at + 3);
        }
        for (landmark, step) in moved.landmarks.iter_mut().zip(points) {
            *landmark = landmark.plus(step);
        }
        moved
    }

    /// Whether every number is one.
    pub(crate) fn is_finite(&self) -> bool {
        let finite = |v: &Vector3<f64>| v.iter().all(|x| x.is_finite());
        self.poses
            .iter()
            .all(|p| finite(&p.translation.vector) && p.rotation.coords.iter().all(|x| x.is_finite()))
            && self.velocities.iter().all(finite)
            && finite(&self.bias.accel)
            && finite(&self.bias.gyro)
            && self.landmarks.iter().all(|l| finite(&l.direction) && l.inverse_distance.is_finite())
    }
}

/// A bundle adjustment: knowns and unknowns.
#[derive(Debug, Clone)]
pub(crate) struct Bundle {
    /// Order of the unknowns.
    pub layout: Layout,
    /// The camera in the body; the identity where the "bodies" are the cameras themselves.
    pub body_from_cam: Isometry3<f64>,
    /// From where points are parametrised, world frame.
    pub origin: Vector3<f64>,
    /// Current values.
    pub state: BundleState,
    /// For each point the frames that see it and where.
    pub views: Vec<Vec<(usize, Vector3<f64>)>>,
    /// Deviation of a view in one direction \[rad\].
    pub track_std: f64,
    /// What the IMU says between frames.
    pub inertial: Vec<InertialFactor>,
    /// What else is known.
    pub priors: Vec<Prior>,
}

impl Bundle {
    /// The cameras of all frames at `state`.
    pub(crate) fn cameras(&self, state: &BundleState) -> Vec<Camera> {
        state.poses.iter().map(|pose| Camera::new(pose, &self.body_from_cam)).collect()
    }

    /// The cost at `state`.
    pub(crate) fn cost(&self, state: &BundleState) -> f64 {
        let cameras = self.cameras(state);
        let mut total = 0.0;
        for (landmark, views) in state.landmarks.iter().zip(&self.views) {
            for (frame, measured) in views {
                let squared = cameras[*frame]
                    .residual(&self.origin, landmark, measured)
                    .map_or(BEHIND_SQUARED, |r| r.norm_squared() / self.track_std.powi(2));
                total += robust::cost(squared);
            }
        }
        for factor in &self.inertial {
            total += 0.5 * factor.whitened_residual(state).norm_squared();
        }
        let mut rows = Vec::new();
        for prior in &self.priors {
            prior.rows(&self.layout, state, &mut rows);
        }
        total + 0.5 * rows.iter().map(|row| row.residual * row.residual).sum::<f64>()
    }

    /// Sizes of all views' residuals in each direction \[rad\]; views behind their camera are left out.
    pub(crate) fn view_residuals(&self) -> Vec<f64> {
        let cameras = self.cameras(&self.state);
        let mut all = Vec::new();
        for (landmark, views) in self.state.landmarks.iter().zip(&self.views) {
            for (frame, measured) in views {
                if let Some(r) = cameras[*frame].residual(&self.origin, landmark, measured) {
                    all.extend([r.x.abs(), r.y.abs()]);
                }
            }
        }
        all
    }

    /// Removes views whose residual is above `limit` \[rad\] or behind the camera, then points with fewer than `min_views`;
    /// returns for each point that stays the index it had.
    pub(crate) fn drop_outliers(&mut self, limit: f64, min_views: usize) -> Vec<usize> {
        let cameras = self.cameras(&self.state);
        let mut kept = Vec::new();
        let (mut landmarks, mut views) = (Vec::new(), Vec::new());
        for (index, (landmark, seen)) in self.state.landmarks.iter().zip(&self.views).enumerate() {
            let good: Vec<_> = seen
                .iter()
                .filter(|(frame, measured)| {
                    cameras[*frame]
                        .residual(&self.origin, landmark, measured)
                        .is_some_and(|r| r.norm() <= limit)
                })
                .copied()
                .collect();
            if good.len() >= min_views {
                kept.push(index);
                landmarks.push(*landmark);
                views.push(good);
            }
        }
        self.state.landmarks = landmarks;
        self.views = views;
        kept
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use dpn_core::geometry::so3::exp;
    use dpn_core::random::Stream;
    use rand::Rng;

    /// A state with nothing special about it.
    pub(crate) fn random_state(frames: usize, points: usize, seed: u64) -> BundleState {
        let mut rng = Stream::new(seed).named("bundle-state").rng();
        let mut vector = |size: f64| Vector3::from_fn(|_, _| rng.random_range(-1.0..1.0) * size);
        BundleState {
            poses: (0..frames)
                .map(|_| Isometry3::from_parts(vector(1.0).into(), exp(&vector(1.5))))
                .collect(),
            velocities: (0..frames).map(|_| vector(2.0)).collect(),
            bias: ImuBias { accel: vector(0.3), gyro: vector(0.05) },
            landmarks: (0..points)
                .map(|_| Landmark { direction: vector(1.0).normalize(), inverse_distance: 0.2 })
                .collect(),
        }
    }

    #[test]
    fn the_layout_names_every_column_once() {
        let layout = Layout::inertial(3);
        let mut columns: Vec<usize> = (0..3)
            .flat_map(|f| [layout.position(f), layout.rotation(f), layout.velocity(f).unwrap()])
            .chain([layout.bias().unwrap(), layout.bias().unwrap() + 3])
            .flat_map(|at| at..at + 3)
            .collect();
        columns.sort_unstable();
        assert_eq!(columns, (0..layout.len()).collect::<Vec<_>>());
        assert_eq!((Layout::visual(3).len(), Layout::visual(3).bias()), (18, None));
    }
}
