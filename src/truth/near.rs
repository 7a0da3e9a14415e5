//! The body close to a key: the samples integrated from the key's to an instant before or after it.
//!
//! The mid-point rule of `dpn_vio::preint`, in either direction of time; between two samples the readings are taken as linear.

use crate::layout::Key;
use dpn_core::geometry::so3;
use dpn_core::{GRAVITY, ImuSample, Stamp};
use nalgebra::{UnitQuaternion, Vector3};

/// The motion from a key's sample to an instant `tau` later (or earlier).
#[derive(Debug, Clone, Copy)]
pub(crate) struct Near {
    /// From the key's sample to the instant \[s\].
    pub(crate) tau: f64,
    /// `key_body_from_body`.
    pub(crate) rotation: UnitQuaternion<f64>,
    /// Integral of the specific force, in the key's body frame \[m/s\].
    pub(crate) velocity: Vector3<f64>,
    /// Double integral of the specific force, in the key's body frame \[m\].
    pub(crate) position: Vector3<f64>,
}

impl Near {
    /// From `key` to `t`.
    pub(crate) fn new(samples: &[ImuSample], key: &Key, t: Stamp) -> Self {
        let bias = &key.state.bias;
        let reading =
            |s: &ImuSample| (Vector3::from(s.gyro) - bias.gyro, Vector3::from(s.accel) - bias.accel);
        let start = samples[key.sample].t;
        let tau = t.seconds_since(start);
        let (mut rate, mut force) = reading(&samples[key.sample]);
        let mut out = Self {
            tau,
            rotation: UnitQuaternion::identity(),
            velocity: Vector3::zeros(),
            position: Vector3::zeros(),
        };
        let (mut at, mut index) = (0.0, key.sample);
        let forward = tau >= 0.0;
        while at != tau {
            let neighbour = if forward { index + 1 } else { index.wrapping_sub(1) };
            // Beyond the recording the last reading stands.
            let (to, next) = match samples.get(neighbour) {
                Some(sample) => (sample.t.seconds_since(start), reading(sample)),
                None => (tau, (rate, force)),
            };
            let whole = to - at;
            let past = if forward { to >= tau } else { to <= tau };
            let (dt, share) =
                if past && whole != 0.0 { (tau - at, (tau - at) / whole) } else { (whole, 1.0) };
            let (next_rate, next_force) = (rate + (next.0 - rate) * share, force + (next.1 - force) * share);
            let turned = out.rotation * so3::exp(&(0.5 * (rate + next_rate) * dt));
            let accel = 0.5 * (out.rotation * force + turned * next_force);
            out.position += out.velocity * dt + 0.5 * dt * dt * accel;
            out.velocity += accel * dt;
            out.rotation = turned;
            (rate, force, index) = (next_rate, next_force, neighbour);
            at = if past { tau } else { to };
        }
        out
    }

    /// Position, rotation and velocity of the body, in the world.
    pub(crate) fn body(&self, key: &Key) -> (Vector3<f64>, UnitQuaternion<f64>, Vector3<f64>) {
        let gravity_in_world = Vector3::new(0.0, 0.0, -GRAVITY);
        let pose = &key.state.world_from_body;
        let position = pose.translation.vector
            + key.state.vel_in_world * self.tau
            + gravity_in_world * (0.5 * self.tau * self.tau)
            + pose.rotation * self.position;
        let velocity = key.state.vel_in_world + gravity_in_world * self.tau + pose.rotation * self.velocity;
        (position, pose.rotation * self.rotation, velocity)
    }
}
