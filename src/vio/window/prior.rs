//! What marginalised measurements say of the states that stay: a quadratic about a fixed point.
//!
//! ```text
//! cost(x) = g.d + d.H d / 2,   d = x - at
//! ```
//! Kept as information (H, g), never inverted: directions it knows nothing of (position and heading before any anchor) are zeros.

use super::frame::Estimates;
use super::layout::Layout;
use super::normal::Normal;
use crate::state::{ACCEL_BIAS, GYRO_BIAS, NavState, POSE_DIM, POSITION, ROTATION, STATE_DIM, pose_minus};
use nalgebra::{Isometry3, Vector3};

// Deviations of what is known of the first frame without any measurement.
/// Of each axis of the position \[m\] and of the heading \[rad\]: small, as they are where the world begins.
const ANCHOR_STD: f64 = 1e-3;
/// Of roll and pitch \[rad\].
const TILT_STD: f64 = 0.2;

/// A prior on the window's first `layout.frames` frames and, where estimated, camera and clock.
#[derive(Debug, Clone)]
pub(crate) struct Prior {
    pub(crate) layout: Layout,
    pub(crate) system: Normal,
    /// Where `d` is zero.
    pub(crate) at: Vec<NavState>,
    pub(crate) at_camera: Isometry3<f64>,
    pub(crate) at_offset: f64,
}

impl Prior {
    /// Fixes what no measurement sees, position and heading of the window's first frame, and says what is known of its biases and
    /// its tilt beforehand: `bias_std` of each axis of the accelerometer's \[m/s^2\] and of the gyro's \[rad/s\].
    pub(crate) fn anchored(mut self, bias_std: [f64; 2]) -> Self {
        self.hold(0, POSITION, ANCHOR_STD);
        self.hold(0, ROTATION, TILT_STD);
        self.hold(0, ACCEL_BIAS, bias_std[0]);
        self.hold(0, GYRO_BIAS, bias_std[1]);
        self.hold_heading(0, ANCHOR_STD);
        // The camera is known to a centimetre and half a degree, its clock to some milliseconds, before anything was seen.
        let Self { layout, system, .. } = &mut self;
        for k in layout.camera().into_iter().flat_map(|c| c..c + POSE_DIM) {
            system.add(k, k, 1.0 / (0.01f64 * 0.01));
        }
        if let Some(k) = layout.offset() {
            system.add(k, k, 1.0 / (0.005f64 * 0.005));
        }
        self
    }

    /// Holds three unknowns of a frame by a deviation each; `index` is the first's in the order of [`crate::state`].
    pub(crate) fn hold(&mut self, frame: usize, index: usize, std: f64) {
        for k in index..index + 3 {
            let place = self.layout.state(frame, k);
            self.system.add(place, place, 1.0 / (std * std));
        }
    }

    /// Holds a turn of the frame about the world's z.
    pub(crate) fn hold_heading(&mut self, frame: usize, std: f64) {
        // Seen from the right it is one about z in the body's frame.
        let up_in_body = self.at[frame].world_from_body.rotation.inverse() * Vector3::z();
        self.hold_along(&[(frame, ROTATION, up_in_body)], std);
    }

    /// Holds the sum of `direction . d` over blocks of three unknowns, each named by frame and first index.
    pub(crate) fn hold_along(&mut self, blocks: &[(usize, usize, Vector3<f64>)], std: f64) {
        let layout = self.layout;
        let entry = |(frame, index, direction): &(usize, usize, Vector3<f64>), k: usize| {
            (layout.state(*frame, index + k), direction[k])
        };
        let entries: Vec<(usize, f64)> =
            blocks.iter().flat_map(|block| [0, 1, 2].map(|k| entry(block, k))).collect();
        for (r, by_r) in &entries {
            for (c, by_c) in entries.iter().filter(|(c, _)| c <= r) {
                self.system.add(*r, *c, by_r * by_c / (std * std));
            }
        }
    }

    /// `d`: how far the window is from the point the prior is about, in the prior's own places.
    pub(crate) fn displacement(&self, now: Estimates<'_>) -> Vec<f64> {
        let mut d = vec![0.0; self.layout.dim()];
        for (frame, at) in self.at.iter().enumerate() {
            let minus = now.frames[frame].state.minus(at);
            for k in 0..STATE_DIM {
                d[self.layout.state(frame, k)] = minus[k];
            }
        }
        if let Some(camera) = self.layout.camera() {
            let minus = pose_minus(now.body_from_cam, &self.at_camera);
            d[camera..camera + POSE_DIM].copy_from_slice(minus.as_slice());
        }
        if let Some(offset) = self.layout.offset() {
            d[offset] = now.time_offset - self.at_offset;
        }
        d
    }

    /// Adds itself to a window's equations and returns its cost, which may be negative: a constant is left out.
    pub(crate) fn add_to(&self, now: Estimates<'_>, layout: &Layout, normal: &mut Normal) -> f64 {
        let d = self.displacement(now);
        let hd = self.system.times(&d);
        // The order of places makes every one of ours the same way off in a window of more frames.
        let shift = layout.motion(0) - self.layout.motion(0);
        let mut cost = 0.0;
        let first = self.system.first_told();
        for r in first..self.layout.dim() {
            let g = self.system.gradient()[r];
            cost += d[r] * (g + 0.5 * hd[r]);
            normal.gradient_mut()[shift + r] += g + hd[r];
            for (to, from) in
                normal.row_mut(shift + r)[shift + first..].iter_mut().zip(&self.system.row(r)[first..])
            {
                *to += from;
            }
        }
        cost
    }

    /// Takes `frame` out: what the prior says through it about the others stays.
    pub(crate) fn without(&self, frame: usize) -> Self {
        let places: Vec<usize> = self.layout.frame_places(frame).collect();
        let system = self.system.without(&places);
        let mut at = self.at.clone();
        at.remove(frame);
        Self {
            layout: Layout { frames: self.layout.frames - 1, ..self.layout },
            system,
            at,
            at_camera: self.at_camera,
            at_offset: self.at_offset,
        }
    }
}
