//! States at every sample from those at the keys.
//!
//! From a key the samples lead to the next one, where they miss it by what the adjustment left as their residual. That is given back along the way:
//! position by the cubic that ends with the missing position and velocity, rotation in proportion to the time.

use crate::near::Near;
use crate::problem::{Estimate, Problem};
use dpn_core::geometry::so3;
use dpn_core::truth::{Biases, TrueState};
use nalgebra::Isometry3;

/// The state at every sample from the first key to the last, with the key before it.
pub(crate) fn dense(problem: &Problem<'_>, estimate: &Estimate) -> Vec<(usize, TrueState)> {
    let keys = &estimate.keys;
    let mut out = Vec::with_capacity(problem.samples.len());
    for k in 0..keys.len() {
        let key = &keys[k];
        let biases = Some(Biases { gyro: key.state.bias.gyro, accel: key.state.bias.accel });
        let own = TrueState {
            t: problem.samples[key.sample].t,
            world_from_body: key.state.world_from_body,
            vel_in_world: Some(key.state.vel_in_world),
            biases,
        };
        out.push((k, own));
        let Some(next) = keys.get(k + 1).filter(|_| problem.linked[k]) else { continue };
        let whole = Near::new(problem.samples, key, problem.samples[next.sample].t);
        let (position, rotation, velocity) = whole.body(key);
        let missed = next.state.world_from_body.translation.vector - position;
        let missed_velocity = next.state.vel_in_world - velocity;
        let missed_turn = so3::log(&(rotation.inverse() * next.state.world_from_body.rotation));
        for sample in &problem.samples[key.sample + 1..next.sample] {
            let near = Near::new(problem.samples, key, sample.t);
            let (position, rotation, velocity) = near.body(key);
            let (s, span) = (near.tau / whole.tau, whole.tau);
            let position =
                position + missed * (s * s * (3.0 - 2.0 * s)) + missed_velocity * (span * s * s * (s - 1.0));
            let velocity =
                velocity + missed * (6.0 * s * (1.0 - s) / span) + missed_velocity * (s * (3.0 * s - 2.0));
            let rotation = rotation * so3::exp(&(missed_turn * s));
            let world_from_body = Isometry3::from_parts(position.into(), rotation);
            out.push((k, TrueState { t: sample.t, world_from_body, vel_in_world: Some(velocity), biases }));
        }
    }
    out
}

/// Root of the mean variance over the axes at every key: position \[m\], rotation \[rad\].
pub(crate) fn deviations<const N: usize, const C: usize>(
    covariance: &crate::chain::ChainCovariance<N, C>,
) -> Vec<(f64, f64)> {
    let rms = |block: &crate::chain::Block<N>, at: usize| {
        ((at..at + 3).map(|i| block[(i, i)]).sum::<f64>() / 3.0).sqrt()
    };
    let of = |block| (rms(block, dpn_vio::state::POSITION), rms(block, dpn_vio::state::ROTATION));
    covariance.keys.iter().map(of).collect()
}
