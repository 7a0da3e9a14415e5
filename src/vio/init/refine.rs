//! The last word: frames, velocities, bias, gravity, scale and structure in one least squares, whose own information says how well the
//! scale is known.
//!
//! The world is turned so that gravity points down, made metric by the alignment, and all unknowns are adjusted to tracks and IMU
//! together (visual-inertial bundle adjustment). Then the data are asked how noisy they were: the deviation of the tracks by the
//! median of their residuals, one factor each for the gyro's and the accelerometer's by what their rows should and do sum to
//! ([`super::certainty`]), a prior on these factors counting where the frames are too few or too close to tell. With these
//! it is adjusted again. So the answer, and what it says of its own certainty, hardly depend on the noise that was told for the IMU:
//! a vibrating one told to be quiet only makes it wait.

use super::adjustment::{self, rescale, solve, track_std_factor};
use super::align::Aligned;
use super::certainty::{gravity_std, inertial_excess, scale_std};
use super::config::{InitConfig, MIN_ACCEL_NOISE, MIN_GYRO_NOISE, NOISE_PRIOR_WEIGHT, REST_TRACK_PX};
use super::frame::InitFrame;
use super::outcome::{Fit, Implausible, WaitReason};
use super::structure::Structure;
use crate::factors::inertial::sqrt_information;
use crate::preint::Preintegration;
use crate::state::{ACCEL_BIAS, GYRO_BIAS, ImuBias, NavState, POSE_DIM, POSITION, VELOCITY};
use crate::window::{Landmark, MIN_INVERSE_DEPTH, Standstill, Window};
use dpn_core::imu::Sensor;
use nalgebra::{DMatrix, Isometry3, Rotation3, UnitQuaternion, Vector3};

/// Steps of the first adjustment, and of each after.
const STEPS: [usize; 3] = [12, 8, 6];
/// Deviation that holds the first frame's position and yaw.
const GAUGE_STD: f64 = 1e-5;
/// Deviation of the velocity at rest \[m/s\].
const REST_STD: f64 = 0.02;
/// Smallest angle between rays that lets a depth be told anew \[rad\].
const MIN_ANGLE: f64 = 0.01;
/// Points that must remain.
const MIN_POINTS: usize = 20;
/// Largest bias of an accelerometer \[m/s^2\] and of a gyro \[rad/s\] that is believed.
const MAX_BIAS: (f64, f64) = (1.5, 0.3);
/// Largest deviation of the gyro's and of the accelerometer's residuals over the expected that is believed: beyond it axes, extrinsics or clocks are wrong, or the
/// scale. A phone's rolling shutter makes 11 of the gyro's; of 200 starts in flight and by hand those with more than 5.4 of the accelerometer's had a wrong scale.
const MAX_EXCESS: [f64; 2] = [15.0, 7.0];
/// Largest deviation of the tracks \[px\] that is believed.
const MAX_TRACK_STD_PX: f64 = 3.0;

/// Frames, velocities, bias and points, adjusted.
#[derive(Debug, Clone)]
pub(super) struct Refined {
    /// A frame each.
    pub states: Vec<NavState>,
    /// Relative deviation of the scale.
    pub scale_std: f64,
    /// Deviation of the direction of gravity in the newest frame \[rad\].
    pub gravity_std: f64,
    /// How good the data are.
    pub fit: Fit,
}

/// What is known of the frames beside structure and alignment.
pub(super) struct Known<'a> {
    /// The frames.
    pub frames: &'a [&'a InitFrame],
    /// The IMU between consecutive frames, integrated with the bias that the structure was built with.
    pub preints: &'a [Preintegration],
    /// Whether each frame stands still.
    pub at_rest: &'a [bool],
    /// The camera in the body.
    pub body_from_cam: &'a Isometry3<f64>,
}

/// Adjusts everything together; `Err` where the result is not to be trusted.
pub(super) fn refine(
    structure: &Structure,
    aligned: &Aligned,
    known: &Known<'_>,
    config: &InitConfig,
) -> Result<Refined, WaitReason> {
    let unusable = |consistent| WaitReason::NoStructure { consistent, needed: MIN_POINTS };
    let uncertain = |relative_std| WaitReason::ScaleUncertain { relative_std, allowed: config.max_scale_std };
    let expected = expected_factors(known.preints);
    let mut window = window(structure, aligned, known, config);
    let mut track_std = structure.track_std;
    let mut fit = Fit {
        track_std_px: track_std * config.focal_px,
        gyro_factor: expected[0],
        accel_factor: expected[1],
    };
    integrate(&mut window, known.preints, &fit).ok_or(unusable(0))?;
    for steps in STEPS {
        solve(&mut window, steps);
        let covariance = window.covariance().ok_or(uncertain(f64::INFINITY))?;
        // Far above the bound no further round brings it below.
        let scale_std = scale_std(&window, &covariance);
        if scale_std > 10.0 * config.max_scale_std {
            return Err(uncertain(scale_std));
        }
        let poses = (POSE_DIM * window.frames().len()) as f64;
        let std = track_std * track_std_factor(&window, |landmarks| 3.0 * landmarks as f64 + poses);
        fit.track_std_px = std * config.focal_px;
        let std = std.max(config.angle(0.1));
        rescale(&mut window, std / track_std);
        track_std = std;
        let [gyro, accel] = inertial_excess(&window, &covariance);
        fit.gyro_factor = gyro.factor(fit.gyro_factor, expected[0], NOISE_PRIOR_WEIGHT);
        fit.accel_factor = accel.factor(fit.accel_factor, expected[1], NOISE_PRIOR_WEIGHT);
        integrate(&mut window, known.preints, &fit).ok_or(unusable(0))?;
        window.reject_outliers();
        window.retain_landmarks(|l| l.inverse_depth.is_some());
        if window.landmarks().len() < MIN_POINTS {
            return Err(unusable(window.landmarks().len()));
        }
    }
    solve(&mut window, STEPS[2]);
    let covariance = window.covariance().ok_or(uncertain(f64::INFINITY))?;
    judge(&window, &covariance, fit, expected, config)
}

/// Integrates the samples with the states' biases and the noise that the fit says; `None` where that gives nothing to weigh by.
fn integrate(window: &mut Window, preints: &[Preintegration], fit: &Fit) -> Option<()> {
    for (k, preint) in preints.iter().enumerate() {
        let bias = window.frames[k].state.bias;
        let preint = preint.with_noise_scaled(bias, fit.accel_factor, fit.gyro_factor).ok()?;
        sqrt_information(&preint)?;
        window.frames[k + 1].preint = Some(preint);
    }
    Some(())
}

/// Factors on the deviations told for gyro and accelerometer that bring their white noise up to the least that is believed.
fn expected_factors(preints: &[Preintegration]) -> [f64; 2] {
    let (mut gyro, mut accel, mut seconds) = (0.0, 0.0, 0.0);
    for preint in preints {
        for pair in preint.samples().windows(2) {
            let step = pair[1].sample.t.seconds_since(pair[0].sample.t);
            let mean_square = |sensor| pair[1].noise.of(sensor).iter().map(|s| s * s).sum::<f64>() / 3.0;
            // A deviation per sample is the density sigma sqrt(step).
            gyro += step * step * mean_square(Sensor::Gyro);
            accel += step * step * mean_square(Sensor::Accel);
            seconds += step;
        }
    }
    let factor = |least: f64, sum: f64| (least / (sum / seconds.max(1e-9)).sqrt().max(1e-12)).max(1.0);
    [factor(MIN_GYRO_NOISE, gyro), factor(MIN_ACCEL_NOISE, accel)]
}

/// The result, when it is certain and plausible.
fn judge(
    window: &Window,
    covariance: &DMatrix<f64>,
    fit: Fit,
    expected: [f64; 2],
    config: &InitConfig,
) -> Result<Refined, WaitReason> {
    let states: Vec<NavState> = window.frames().iter().map(|f| f.state).collect();
    let bias = states[0].bias;
    let scale_std = scale_std(window, covariance);
    let within = |what, value: f64, allowed: f64| {
        if value <= allowed { Ok(()) } else { Err(WaitReason::Implausible { what, value, allowed }) }
    };
    within(Implausible::TrackResidual, fit.track_std_px, MAX_TRACK_STD_PX)?;
    within(Implausible::AccelBias, bias.accel.norm(), MAX_BIAS.0)?;
    within(Implausible::GyroBias, bias.gyro.norm(), MAX_BIAS.1)?;
    within(Implausible::InertialResidual, fit.gyro_factor / expected[0], MAX_EXCESS[0])?;
    within(Implausible::InertialResidual, fit.accel_factor / expected[1], MAX_EXCESS[1])?;
    if scale_std.is_nan() || scale_std > config.max_scale_std {
        return Err(WaitReason::ScaleUncertain { relative_std: scale_std, allowed: config.max_scale_std });
    }
    let gravity_std = gravity_std(window, covariance, states.len() - 1);
    Ok(Refined { states, scale_std, gravity_std, fit })
}

/// The rotation to a world whose z axis points against `gravity` and in which `forward` has yaw 0.
fn level(gravity: &Vector3<f64>, forward: &Vector3<f64>) -> UnitQuaternion<f64> {
    let up = -gravity.normalize();
    let flat = forward - up * up.dot(forward);
    // Looking straight up or down: any horizontal direction will do.
    let x = flat
        .try_normalize(1e-3)
        .unwrap_or_else(|| dpn_core::geometry::sphere::tangent_basis(&up).column(0).into_owned());
    let axes = nalgebra::Matrix3::from_columns(&[x, up.cross(&x), up]);
    UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(axes.transpose()))
}

/// The visual-inertial window at the alignment's answer.
fn window(structure: &Structure, aligned: &Aligned, known: &Known<'_>, config: &InitConfig) -> Window {
    let scale = aligned.scale;
    let cam_from_body = known.body_from_cam.inverse();
    let optical_axis = structure.cameras[0].rotation * Vector3::z();
    let turn = level(&aligned.gravity, &optical_axis);
    let poses: Vec<Isometry3<f64>> = structure
        .cameras
        .iter()
        .map(|c| {
            Isometry3::from_parts((turn * (scale * c.translation.vector)).into(), turn * c.rotation)
                * cam_from_body
        })
        .collect();
    let start = known.preints[0].bias();
    let bias = ImuBias { accel: start.accel + aligned.accel_bias_change, gyro: start.gyro };
    let mut window = adjustment::window(*known.body_from_cam, MIN_ANGLE);
    let mut rest_from = None;
    for (k, frame) in known.frames.iter().enumerate() {
        let shifted = poses[k].translation.vector - poses[0].translation.vector;
        let state = NavState {
            world_from_body: Isometry3::from_parts(shifted.into(), poses[k].rotation),
            vel_in_world: turn * aligned.velocities[k],
            bias,
        };
        window.add_frame(frame.t, state, None, &[]);
        rest_from = known.at_rest[k].then(|| rest_from.unwrap_or(frame.t));
        if let Some(from) = rest_from {
            window.rest_since(Standstill { from, angle: config.angle(REST_TRACK_PX) });
        }
    }
    let metric = |l: &Landmark| {
        let inverse_depth = l.inverse_depth.map(|d| (d / scale).max(MIN_INVERSE_DEPTH));
        Landmark { inverse_depth, ..l.clone() }
    };
    window.landmarks = structure.landmarks.iter().map(metric).collect();
    let about = window
        .frames()
        .iter()
        .map(|f| NavState { world_from_body: f.state.world_from_body, ..NavState::identity() });
    let mut prior = window.prior_about(about.collect());
    prior.hold(0, POSITION, GAUGE_STD);
    prior.hold_heading(0, GAUGE_STD);
    prior.hold(0, ACCEL_BIAS, config.accel_bias_std);
    prior.hold(0, GYRO_BIAS, config.gyro_bias_std);
    for frame in (0..poses.len()).filter(|k| known.at_rest[*k]) {
        prior.hold(frame, VELOCITY, REST_STD);
    }
    window.prior = Some(prior);
    window
}

#[cfg(test)]
mod tests {
    use super::*;
    use dpn_core::geometry::so3;

    #[test]
    fn the_levelled_world_has_gravity_down_and_the_camera_ahead() {
        for seed in 0..20 {
            let s = f64::from(seed);
            let rotation = so3::exp(&Vector3::new(s.sin(), (2.0 * s).cos(), (3.0 * s).sin()));
            let gravity = 9.81 * Vector3::new((5.0 * s).sin(), s.cos(), 0.3).normalize();
            let turn = level(&gravity, &(rotation * Vector3::z()));
            assert!((turn * gravity - Vector3::new(0.0, 0.0, -9.81)).norm() < 1e-12);
            let forward = turn * rotation * Vector3::z();
            assert!(forward.y.abs() < 1e-9 && forward.x >= 0.0);
        }
        let down = level(&Vector3::new(0.0, 0.0, -9.81), &Vector3::new(0.0, 0.0, -1.0));
        assert!((down * Vector3::z() - Vector3::z()).norm() < 1e-12);
    }
}
