//! Where the adjustment begins: keys along the samples, at the published poses taken to the IMU's clock and frames.

use crate::align::interpolated;
use crate::ceiling::ceiling;
use crate::components::Levels;
use crate::config::TruthConfig;
use crate::layout::{Frames, Key};
use crate::problem::{Estimate, Problem, Published, Role};
use dpn_core::trajectory::StampedPose;
use dpn_core::{ImuSample, SampleRate, Sensor};
use dpn_vio::{ImuBias, NavState};
use nalgebra::{Isometry3, Vector3};

/// The fewest samples from a key to the next: below two steps position and velocity hang on one acceleration.
const FEWEST_STEPS: usize = 3;
/// A step between samples longer than so many periods breaks the chain.
const LONGEST_STEP: f64 = 8.0;
/// Velocities are differences over this \[s\].
const VELOCITY_SPAN_S: f64 = 0.1;

/// Keys and first estimate; samples and poses overlap.
pub(crate) fn start<'a>(
    samples: &'a [ImuSample],
    poses: &[StampedPose],
    rate: SampleRate,
    frames: Frames,
    config: &TruthConfig,
) -> (Problem<'a>, Estimate) {
    let period_s = rate.period();
    let every = ((config.key_interval_s / period_s).round() as usize).max(FEWEST_STEPS);
    let count = (samples.len() - 1) / every + 1;
    let pose_at = |seconds: f64, sample: &ImuSample| {
        let t = sample.t.plus_seconds(frames.delay_s + seconds);
        interpolated(poses, t, config.longest_gap_s).map(|published| in_body(&published, &frames))
    };
    let linked: Vec<bool> = (0..count - 1)
        .map(|k| {
            let within = &samples[k * every..=(k + 1) * every];
            within.windows(2).all(|w| w[1].t.seconds_since(w[0].t) < LONGEST_STEP * period_s)
        })
        .collect();
    let mut problem = Problem {
        samples,
        published: poses.iter().map(|pose| Published { pose: *pose, role: Role::Used }).collect(),
        linked,
        interval_s: every as f64 * period_s,
        ceilings: [Sensor::Accel, Sensor::Gyro]
            .map(|sensor| ceiling(samples, rate, sensor).unwrap_or(f64::INFINITY)),
        by_axis: None,
        held: Vec::new(),
    };
    let mut estimate = Estimate { keys: Vec::with_capacity(count), frames };
    for k in 0..count {
        let sample = &samples[k * every];
        let published = pose_at(0.0, sample).and_then(|pose| {
            let (a, b) = (pose_at(-0.5 * VELOCITY_SPAN_S, sample), pose_at(0.5 * VELOCITY_SPAN_S, sample));
            let (from, from_s) = a.map_or((pose, 0.0), |a| (a, 0.5 * VELOCITY_SPAN_S));
            let (to, to_s) = b.map_or((pose, 0.0), |b| (b, 0.5 * VELOCITY_SPAN_S));
            let span = from_s + to_s;
            let rise = to.translation.vector - from.translation.vector;
            (span > 0.0).then(|| (pose, rise / span))
        });
        let key = |world_from_body, vel_in_world| Key {
            sample: k * every,
            state: NavState { world_from_body, vel_in_world, bias: ImuBias::zero() },
            position_error: Vector3::zeros(),
            rotation_error: Vector3::zeros(),
            error_rate: Vector3::zeros(),
        };
        let key = match (published, estimate.keys.last()) {
            (Some((pose, velocity)), _) => key(pose, velocity),
            (None, None) => key(Isometry3::identity(), Vector3::zeros()),
            // In a gap the samples lead.
            (None, Some(before)) => {
                let mut both =
                    Estimate { keys: vec![*before, key(Isometry3::identity(), Vector3::zeros())], frames };
                let preint = problem
                    .between(&both, 0, &Levels::start())
                    .expect("the first levels are positive and finite");
                let state = preint.predict(&before.state);
                both.keys[1].state = state;
                both.keys[1]
            }
        };
        estimate.keys.push(key);
    }
    // By the key beside: a block of poses is predicted, not one whose neighbours are at hand.
    let terms = problem.terms(&estimate);
    for (published, (k, _)) in problem.published.iter_mut().zip(terms) {
        if k.checked_div(config.hold_out).is_some_and(|block| block % 2 == 1) {
            published.role = Role::KeptOut;
        }
    }
    (problem, estimate)
}

/// The IMU's pose in the gravity-aligned world of a published one.
fn in_body(published: &Isometry3<f64>, frames: &Frames) -> Isometry3<f64> {
    let world_from_published_world = frames.published_world_from_world.inverse();
    let rotation =
        world_from_published_world * published.rotation * frames.body_from_published_body.inverse();
    let origin = world_from_published_world * published.translation.vector - rotation * frames.lever_in_body;
    Isometry3::from_parts(origin.into(), rotation)
}
