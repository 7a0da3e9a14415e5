//! What marginalised measurements say of the states that stay: a quadratic about a fixed point.
//!
//! ```text
//! cost(x) = g.d + d.H d / 2,   d = x - at
//! ```
//! Kept as information (H, g), never inverted: directions it knows nothing of (position and heading before any anchor) are zeros.

use super::layout::Layout;
use super::normal::Normal;
use super::window::Window;
use crate::state::{ACCEL_BIAS, GYRO_BIAS, NavState, POSE_DIM, STATE_DIM, VELOCITY, pose_minus};
use nalgebra::{Isometry3, SVector};

/// A prior on the window's first `layout.frames` frames and, where estimated, camera and clock.
#[derive(Debug, Clone)]
pub struct Prior {
    pub(crate) layout: Layout,
    pub(crate) system: Normal,
    /// Where `d` is zero.
    pub(crate) at: Vec<NavState>,
    pub(crate) at_camera: Isometry3<f64>,
    pub(crate) at_offset: f64,
}

impl Prior {
    /// Places position, heading and biases of a window's first frame, and loosely all else of it, by standard deviations in the
    /// order of [`crate::state`]; a deviation that is infinite says nothing.
    pub(crate) fn anchor(window: &Window, std: &SVector<f64, STATE_DIM>) -> Self {
        let layout = Layout { frames: 1, ..window.layout() };
        let mut system = Normal::zeros(layout.dim());
        for (k, s) in std.iter().enumerate() {
            system.add(layout.state(0, k), layout.state(0, k), 1.0 / (s * s));
        }
        // The camera is known to a centimetre and half a degree, its clock to some milliseconds, before anything was seen.
        for (at, std) in [(0, 0.01), (3, 0.01)] {
            for k in layout.camera().into_iter().flat_map(|c| c + at..c + at + 3) {
                system.add(k, k, 1.0 / (std * std));
            }
        }
        if let Some(k) = layout.offset() {
            system.add(k, k, 1.0 / (0.005f64 * 0.005));
        }
        Self {
            layout,
            system,
            at: vec![window.frames[0].state],
            at_camera: window.body_from_cam,
            at_offset: window.time_offset,
        }
    }

    /// `d`: how far the window is from the point the prior is about, in the prior's own places.
    pub(crate) fn displacement(&self, window: &Window) -> Vec<f64> {
        let mut d = vec![0.0; self.layout.dim()];
        for (frame, at) in self.at.iter().enumerate() {
            let minus = window.frames[frame].state.minus(at);
            for k in 0..STATE_DIM {
                d[self.layout.state(frame, k)] = minus[k];
            }
        }
        if let Some(camera) = self.layout.camera() {
            let minus = pose_minus(&window.body_from_cam, &self.at_camera);
            d[camera..camera + POSE_DIM].copy_from_slice(minus.as_slice());
        }
        if let Some(offset) = self.layout.offset() {
            d[offset] = window.time_offset - self.at_offset;
        }
        d
    }

    /// Adds itself to a window's equations and returns its cost, which may be negative: a constant is left out.
    pub(crate) fn add_to(&self, window: &Window, layout: &Layout, normal: &mut Normal) -> f64 {
        let d = self.displacement(window);
        let hd = self.system.times(&d);
        // The order of places makes every one of ours the same way off in a window of more frames.
        let shift = layout.motion(0) - self.layout.motion(0);
        let mut cost = 0.0;
        for r in 0..self.layout.dim() {
            let g = self.system.gradient()[r];
            cost += d[r] * (g + 0.5 * hd[r]);
            normal.gradient_mut()[shift + r] += g + hd[r];
            for (to, from) in normal.row_mut(shift + r)[shift..].iter_mut().zip(self.system.row(r)) {
                *to += from;
            }
        }
        cost
    }

    /// Takes `frame` out: what the prior says through it about the others stays.
    pub(crate) fn without(&self, frame: usize) -> Self {
        let places: Vec<usize> = self.layout.frame_places(frame).collect();
        let mut system = self.system.clone();
        for &k in &places {
            // Far below any information a measurement gives (1e-3 and more), far above rounding.
            system.eliminate(k, 1e-9);
        }
        let kept: Vec<usize> = (0..self.layout.dim()).filter(|k| !places.contains(k)).collect();
        let mut at = self.at.clone();
        at.remove(frame);
        Self {
            layout: Layout { frames: self.layout.frames - 1, ..self.layout },
            system: system.select(&kept),
            at,
            at_camera: self.at_camera,
            at_offset: self.at_offset,
        }
    }
}

/// Deviations that fix what cannot be seen (position and heading) and leave the rest to the measurements.
///
/// Heading is about the world's z; the rotation is perturbed on the right, so the first frame's attitude as a whole gets `rotation`.
pub(crate) fn anchor_std(
    position: f64,
    rotation: f64,
    velocity: f64,
    accel_bias: f64,
    gyro_bias: f64,
) -> SVector<f64, STATE_DIM> {
    let mut std = SVector::<f64, STATE_DIM>::zeros();
    std.fixed_rows_mut::<3>(0).fill(position);
    std.fixed_rows_mut::<3>(3).fill(rotation);
    std.fixed_rows_mut::<3>(VELOCITY).fill(velocity);
    std.fixed_rows_mut::<3>(ACCEL_BIAS).fill(accel_bias);
    std.fixed_rows_mut::<3>(GYRO_BIAS).fill(gyro_bias);
    std
}
