//! The last word: frames, velocities, bias, gravity, scale and structure in one least squares, whose own information says how well the
//! scale is known.
//!
//! The world is turned so that gravity points down, made metric by the alignment, and all unknowns are adjusted to tracks and IMU
//! together (visual-inertial bundle adjustment). Then the data are asked how noisy they were: the deviation of the tracks by the
//! median of their residuals, one factor each for the gyro's and the accelerometer's by what their rows should and do sum to
//! ([`super::bundle`]'s covariance), a prior on these factors counting where the frames are too few or too close to tell. With these
//! it is adjusted again. So the answer, and what it says of its own certainty, hardly depend on the noise that was told for the IMU:
//! a vibrating one told to be quiet only makes it wait.

use super::align::Aligned;
use super::bundle::{Bundle, BundleState, Covariance, InertialFactor, Landmark, Layout, Prior};
use super::config::InitConfig;
use super::frame::Feature;
use super::outcome::{Fit, Implausible, InitialisedPoint, WaitReason};
use super::robust;
use super::structure::Structure;
use crate::preint::Preintegration;
use crate::state::{ImuBias, NavState};
use dpn_core::imu::Sensor;
use nalgebra::{Isometry3, Rotation3, UnitQuaternion, Vector3};

/// Steps of the first adjustment, and of each after.
const STEPS: [usize; 3] = [12, 8, 6];
/// Deviations beyond which a view is dropped.
const OUTLIER_DEVIATIONS: f64 = 4.0;
/// Deviation that holds the first frame's position and yaw.
const GAUGE_STD: f64 = 1e-5;
/// Deviations at rest: velocity \[m/s\], position \[m\], rotation \[rad\].
const REST_STD: (f64, f64, f64) = (0.02, 0.005, 0.002);
/// Points that must remain.
const MIN_POINTS: usize = 20;
/// Largest bias of an accelerometer \[m/s^2\] and of a gyro \[rad/s\] that is believed.
const MAX_BIAS: (f64, f64) = (1.5, 0.3);
/// Largest deviation of the inertial residuals over the expected that is believed: beyond it axes, extrinsics or clocks are wrong.
const MAX_EXCESS: f64 = 15.0;
/// Largest deviation of the tracks \[px\] that is believed.
const MAX_TRACK_STD_PX: f64 = 3.0;

/// Frames, velocities, bias and points, adjusted.
#[derive(Debug, Clone)]
pub(super) struct Refined {
    /// A frame each.
    pub states: Vec<NavState>,
    /// By increasing id.
    pub points: Vec<InitialisedPoint>,
    /// Deviation of the bias's axes.
    pub bias_std: ImuBias,
    /// Relative deviation of the scale.
    pub scale_std: f64,
    /// Deviation of the direction of gravity in the newest frame \[rad\].
    pub gravity_std: f64,
    /// How good the data are.
    pub fit: Fit,
}

/// What is known of the frames beside structure and alignment.
pub(super) struct Known<'a> {
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
    let mut bundle = bundle(structure, aligned, known, config).ok_or(unusable(0))?;
    let mut ids: Vec<u64> = structure.features.iter().map(|f: &Feature| f.id).collect();
    let expected = expected_factors(known.preints, config);
    let mut fit = Fit {
        track_std_px: structure.track_std * config.focal_px,
        gyro_factor: expected[0],
        accel_factor: expected[1],
    };
    for factor in &mut bundle.inertial {
        factor.rescale(fit.gyro_factor, fit.accel_factor);
    }
    let mut covariance = None;
    for steps in STEPS {
        bundle.solve(steps);
        if !bundle.state.is_finite() {
            return Err(unusable(0));
        }
        let found = Covariance::of(&bundle).ok_or(WaitReason::ScaleUncertain {
            relative_std: f64::INFINITY,
            allowed: config.max_scale_std,
        })?;
        // Far above the bound no further round brings it below.
        let scale_std = found.scale_std(&bundle);
        if scale_std > 10.0 * config.max_scale_std {
            return Err(WaitReason::ScaleUncertain {
                relative_std: scale_std,
                allowed: config.max_scale_std,
            });
        }
        let mut residuals = bundle.view_residuals();
        let rows = residuals.len() as f64;
        let freedom = (rows / found.view_redundancy(&bundle).max(0.2 * rows)).sqrt();
        let std = freedom * robust::std_of_median(robust::median(&mut residuals));
        bundle.track_std = std.max(config.angle(0.1));
        fit.track_std_px = std * config.focal_px;
        let [gyro, accel] = found.inertial_excess(&bundle);
        fit.gyro_factor = gyro.factor(fit.gyro_factor, expected[0], config.noise_prior_weight);
        fit.accel_factor = accel.factor(fit.accel_factor, expected[1], config.noise_prior_weight);
        for factor in &mut bundle.inertial {
            factor.rescale(fit.gyro_factor, fit.accel_factor);
        }
        let kept = bundle.drop_outliers(OUTLIER_DEVIATIONS * bundle.track_std, 2);
        ids = kept.into_iter().map(|k| ids[k]).collect();
        if ids.len() < MIN_POINTS {
            return Err(unusable(ids.len()));
        }
        covariance = Some(found);
    }
    bundle.solve(STEPS[2]);
    let covariance = Covariance::of(&bundle).or(covariance).ok_or(unusable(0))?;
    judge(&bundle, &covariance, &ids, fit, expected, config)
}

/// Factors on the deviations told for gyro and accelerometer that bring their white noise up to the least that is believed.
fn expected_factors(preints: &[Preintegration], config: &InitConfig) -> [f64; 2] {
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
    [factor(config.min_gyro_noise.get(), gyro), factor(config.min_accel_noise.get(), accel)]
}

/// The result, when it is certain and plausible.
fn judge(
    bundle: &Bundle,
    covariance: &Covariance,
    ids: &[u64],
    fit: Fit,
    expected: [f64; 2],
    config: &InitConfig,
) -> Result<Refined, WaitReason> {
    let state = &bundle.state;
    let scale_std = covariance.scale_std(bundle);
    let excess = (fit.gyro_factor / expected[0]).max(fit.accel_factor / expected[1]);
    let within = |what, value: f64, allowed: f64| {
        if value <= allowed { Ok(()) } else { Err(WaitReason::Implausible { what, value, allowed }) }
    };
    within(Implausible::TrackResidual, fit.track_std_px, MAX_TRACK_STD_PX)?;
    within(Implausible::AccelBias, state.bias.accel.norm(), MAX_BIAS.0)?;
    within(Implausible::GyroBias, state.bias.gyro.norm(), MAX_BIAS.1)?;
    within(Implausible::InertialResidual, excess, MAX_EXCESS)?;
    if scale_std.is_nan() || scale_std > config.max_scale_std {
        return Err(WaitReason::ScaleUncertain { relative_std: scale_std, allowed: config.max_scale_std });
    }
    let points: Vec<InitialisedPoint> = (0..ids.len())
        .filter_map(|k| {
            let landmark = &state.landmarks[k];
            Some(InitialisedPoint {
                id: ids[k],
                point_in_world: landmark.point(&bundle.origin)?,
                relative_distance_std: covariance.inverse_distance_std(bundle, k) / landmark.inverse_distance,
            })
        })
        .collect();
    if points.len() < MIN_POINTS {
        return Err(WaitReason::NoStructure { consistent: points.len(), needed: MIN_POINTS });
    }
    let [accel, gyro] = covariance.bias_std(bundle).unwrap_or_default();
    Ok(Refined {
        states: state
            .poses
            .iter()
            .zip(&state.velocities)
            .map(|(pose, velocity)| NavState {
                world_from_body: *pose,
                vel_in_world: *velocity,
                bias: state.bias,
            })
            .collect(),
        points,
        bias_std: ImuBias { accel, gyro },
        scale_std,
        gravity_std: covariance.gravity_std(bundle, state.poses.len() - 1),
        fit,
    })
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

/// The visual-inertial bundle at the alignment's answer.
fn bundle(
    structure: &Structure,
    aligned: &Aligned,
    known: &Known<'_>,
    config: &InitConfig,
) -> Option<Bundle> {
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
    let shift = poses[0].translation.vector;
    let poses: Vec<_> = poses
        .into_iter()
        .map(|p| Isometry3::from_parts((p.translation.vector - shift).into(), p.rotation))
        .collect();
    let landmarks = structure
        .landmarks
        .iter()
        .map(|l| Landmark { direction: turn * l.direction, inverse_distance: l.inverse_distance / scale })
        .collect();
    let start = known.preints[0].bias();
    let bias = ImuBias { accel: start.accel + aligned.accel_bias_change, gyro: start.gyro };
    let inertial = known
        .preints
        .iter()
        .enumerate()
        .map(|(k, preint)| InertialFactor::new(k, k + 1, preint))
        .collect::<Option<Vec<_>>>()?;
    let mut priors = vec![
        Prior::Position { frame: 0, value: Vector3::zeros(), std: GAUGE_STD },
        Prior::Yaw { frame: 0, value: poses[0].rotation, std: GAUGE_STD },
        Prior::Bias {
            value: ImuBias::zero(),
            accel_std: config.accel_bias_std,
            gyro_std: config.gyro_bias_std,
        },
    ];
    let (velocity_std, position_std, rotation_std) = REST_STD;
    for (frame, still) in known.at_rest.iter().enumerate() {
        if *still {
            priors.push(Prior::NoVelocity { frame, std: velocity_std });
            if frame > 0 && known.at_rest[frame - 1] {
                priors.push(Prior::SamePose { first: frame - 1, second: frame, position_std, rotation_std });
            }
        }
    }
    Some(Bundle {
        layout: Layout::inertial(poses.len()),
        body_from_cam: *known.body_from_cam,
        origin: turn * (scale * structure.origin) - shift,
        state: BundleState {
            velocities: aligned.velocities.iter().map(|v| turn * v).collect(),
            bias,
            landmarks,
            poses,
        },
        views: structure.features.iter().map(|f| f.views.clone()).collect(),
        track_std: structure.track_std,
        inertial,
        priors,
    })
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
