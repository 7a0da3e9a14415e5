//! Inertial residual between two states. 15 rows in the order of [`crate::state`].
//!
//! ```text
//! r_p   = R_i^T (p_j - p_i - v_i T - g T^2/2) - alpha(b_i)        g = (0, 0, -9.81) in the world
//! r_rot = Log(gamma(b_i)^-1 R_i^-1 R_j)
//! r_v   = R_i^T (v_j - v_i - g T) - beta(b_i)
//! r_ba  = ba_j - ba_i          r_bg = bg_j - bg_i
//! ```
//! Rotations are perturbed on the right. With `E = gamma(b_i)^-1 R_i^-1 R_j = Exp(r_rot)` and `N = Jr(r_rot)^-1`:
//! ```text
//! d r_rot / d theta_j =  N
//! d r_rot / d theta_i = -N (R_i^-1 R_j)^T
//! d r_rot / d bg_i    = -N E^T Jr(J_g (bg_i - bg)) J_g
//! ```
//! where `J_g` is the rotation's bias Jacobian and `bg` the bias integrated with. Increments and covariance come from
//! [`crate::preint`]. Source: Qin et al. 2018, sec. VI-B; Forster et al. 2017, eq. 44 and 45.

use crate::preint::Preintegration;
use crate::state::{ACCEL_BIAS, GYRO_BIAS, NavState, POSITION, ROTATION, STATE_DIM, VELOCITY};
use dpn_core::GRAVITY;
use dpn_core::geometry::so3;
use nalgebra::{Matrix3, SMatrix, SVector, UnitQuaternion, Vector3};

/// A pivot of the correlation matrix below this is no information but rounding: the covariance is singular.
const MIN_PIVOT: f64 = 1e-10;

/// Parts that residual and Jacobians share.
struct Parts {
    position: Vector3<f64>,
    velocity: Vector3<f64>,
    body_i_from_body_j: UnitQuaternion<f64>,
    residual: SVector<f64, STATE_DIM>,
}

fn parts(preint: &Preintegration, i: &NavState, j: &NavState) -> Parts {
    let duration = preint.duration();
    let gravity_in_world = Vector3::new(0.0, 0.0, -GRAVITY);
    let delta = preint.corrected(&i.bias);
    let (pose_i, pose_j) = (&i.world_from_body, &j.world_from_body);
    let body_i_from_world = pose_i.rotation.inverse();
    let position = body_i_from_world
        * (pose_j.translation.vector
            - pose_i.translation.vector
            - i.vel_in_world * duration
            - gravity_in_world * (0.5 * duration * duration));
    let velocity = body_i_from_world * (j.vel_in_world - i.vel_in_world - gravity_in_world * duration);
    let body_i_from_body_j = body_i_from_world * pose_j.rotation;
    let mut residual = SVector::<f64, STATE_DIM>::zeros();
    let mut put = |row, value: Vector3<f64>| residual.fixed_rows_mut::<3>(row).copy_from(&value);
    put(POSITION, position - delta.position);
    put(ROTATION, so3::log(&(delta.rotation.inverse() * body_i_from_body_j)));
    put(VELOCITY, velocity - delta.velocity);
    put(ACCEL_BIAS, j.bias.accel - i.bias.accel);
    put(GYRO_BIAS, j.bias.gyro - i.bias.gyro);
    Parts { position, velocity, body_i_from_body_j, residual }
}

/// How far two states are from what the samples between them say, in the order of [`crate::state`].
///
/// Not whitened; its covariance is [`Preintegration::covariance`].
pub fn inertial_residual(preint: &Preintegration, i: &NavState, j: &NavState) -> SVector<f64, STATE_DIM> {
    parts(preint, i, j).residual
}

/// The residual, and its derivatives by both states as `NavState::plus` moves them: `(residual, d_res_d_state_i, d_res_d_state_j)`.
pub fn inertial_jacobians(
    preint: &Preintegration,
    i: &NavState,
    j: &NavState,
) -> (SVector<f64, STATE_DIM>, SMatrix<f64, STATE_DIM, STATE_DIM>, SMatrix<f64, STATE_DIM, STATE_DIM>) {
    let Parts { position, velocity, body_i_from_body_j, residual } = parts(preint, i, j);
    let body_i_from_world = i.world_from_body.rotation.inverse().to_rotation_matrix().into_inner();
    let rotation_residual = residual.fixed_rows::<3>(ROTATION).into_owned();
    let unrolled = so3::right_jacobian_inverse(&rotation_residual);

    let mut d_res_d_i = SMatrix::<f64, STATE_DIM, STATE_DIM>::zeros();
    let mut put =
        |row, column, block: Matrix3<f64>| d_res_d_i.fixed_view_mut::<3, 3>(row, column).copy_from(&block);
    put(POSITION, POSITION, -body_i_from_world);
    put(POSITION, ROTATION, so3::hat(&position));
    put(POSITION, VELOCITY, -preint.duration() * body_i_from_world);
    put(ROTATION, ROTATION, -unrolled * body_i_from_body_j.inverse().to_rotation_matrix().into_inner());
    put(VELOCITY, ROTATION, so3::hat(&velocity));
    put(VELOCITY, VELOCITY, -body_i_from_world);
    put(ACCEL_BIAS, ACCEL_BIAS, -Matrix3::identity());
    put(GYRO_BIAS, GYRO_BIAS, -Matrix3::identity());

    // The bias Jacobian's columns stand as the state's do, from the accelerometer's bias on.
    let jacobian = preint.jacobian();
    let by_bias = |row, column| jacobian.fixed_view::<3, 3>(row, column - ACCEL_BIAS).into_owned();
    put(POSITION, ACCEL_BIAS, -by_bias(POSITION, ACCEL_BIAS));
    put(POSITION, GYRO_BIAS, -by_bias(POSITION, GYRO_BIAS));
    put(VELOCITY, ACCEL_BIAS, -by_bias(VELOCITY, ACCEL_BIAS));
    put(VELOCITY, GYRO_BIAS, -by_bias(VELOCITY, GYRO_BIAS));
    let turn_by_bias = by_bias(ROTATION, GYRO_BIAS);
    let correction = turn_by_bias * (i.bias.gyro - preint.bias().gyro);
    let error_back = so3::exp(&-rotation_residual).to_rotation_matrix().into_inner();
    put(ROTATION, GYRO_BIAS, -unrolled * error_back * so3::right_jacobian(&correction) * turn_by_bias);

    let mut d_res_d_j = SMatrix::<f64, STATE_DIM, STATE_DIM>::zeros();
    let mut put =
        |row, column, block: Matrix3<f64>| d_res_d_j.fixed_view_mut::<3, 3>(row, column).copy_from(&block);
    put(POSITION, POSITION, body_i_from_world);
    put(ROTATION, ROTATION, unrolled);
    put(VELOCITY, VELOCITY, body_i_from_world);
    put(ACCEL_BIAS, ACCEL_BIAS, Matrix3::identity());
    put(GYRO_BIAS, GYRO_BIAS, Matrix3::identity());
    (residual, d_res_d_i, d_res_d_j)
}

/// The lower triangular `S` with `S^T S = covariance^-1`: `S * residual` is white with variance 1. Taken once an interval, then kept.
///
/// `None` where the covariance is singular or not finite: an interval of fewer than two steps (position and velocity then hang on one
/// acceleration), noise or walk of zero, numbers out of range. Such an interval cannot be weighed; merge it with its neighbour.
pub fn sqrt_information(preint: &Preintegration) -> Option<SMatrix<f64, STATE_DIM, STATE_DIM>> {
    preint.sqrt_information_with(inverse_factor)
}

/// Inverse of the Cholesky factor, taken on the correlation matrix: units differ by many decades.
fn inverse_factor(
    covariance: &SMatrix<f64, STATE_DIM, STATE_DIM>,
) -> Option<SMatrix<f64, STATE_DIM, STATE_DIM>> {
    let scale = covariance.diagonal().map(|variance| 1.0 / variance.sqrt());
    if !scale.iter().all(|s| s.is_finite()) {
        return None;
    }
    let correlation =
        SMatrix::<f64, STATE_DIM, STATE_DIM>::from_fn(|r, c| covariance[(r, c)] * scale[r] * scale[c]);
    let factor = correlation.cholesky()?.unpack();
    if factor.diagonal().iter().any(|pivot| pivot.is_nan() || pivot * pivot < MIN_PIVOT) {
        return None;
    }
    let mut inverse = SMatrix::<f64, STATE_DIM, STATE_DIM>::identity();
    if !factor.solve_lower_triangular_mut(&mut inverse) {
        return None;
    }
    // Columns take the scale back.
    for column in 0..STATE_DIM {
        inverse.column_mut(column).scale_mut(scale[column]);
    }
    inverse.iter().all(|x| x.is_finite()).then_some(inverse)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::preint::testing::{config, integrate, lively, random_bias, random_state, rng};
    use crate::preint::{ImuCov, PreintegrationConfig};
    use crate::state::ImuBias;
    use dpn_core::ImuNoise;
    use dpn_testing::check_jacobian;
    use nalgebra::DVector;
    use rand::Rng;

    /// An interval, integrated with a bias that is not the state's, and two states `off` from agreeing with it.
    fn case(seed: u64, off: f64) -> (Preintegration, NavState, NavState) {
        let mut rng = rng("inertial factor", seed);
        let samples = lively(&mut rng, 200.0, 20, true);
        let i = random_state(&mut rng);
        let integrated_with = ImuBias {
            accel: i.bias.accel + random_bias(&mut rng).accel,
            gyro: i.bias.gyro + random_bias(&mut rng).gyro,
        };
        let preint = integrate(PreintegrationConfig::default(), integrated_with, &samples);
        let j = preint.predict(&i).plus(&SVector::from_fn(|_, _| off * rng.random_range(-1.0..1.0)));
        (preint, i, j)
    }

    fn dynamic(v: &SVector<f64, STATE_DIM>) -> DVector<f64> {
        DVector::from_column_slice(v.as_slice())
    }

    fn fixed(d: &DVector<f64>) -> SVector<f64, STATE_DIM> {
        SVector::from_column_slice(d.as_slice())
    }

    #[test]
    fn the_predicted_state_has_no_residual() {
        for seed in 0..20 {
            let (preint, i, j) = case(seed, 0.0);
            assert!(inertial_residual(&preint, &i, &j).norm() < 1e-13);
        }
    }

    #[test]
    fn jacobians_are_the_derivatives() {
        // Residual rotations from 1e-9 rad (the series of so3) to beyond 1 rad.
        for (seed, off) in (0..40).zip([1e-9, 1e-4, 0.1, 1.0].into_iter().cycle()) {
            let (preint, i, j) = case(seed, off);
            let (residual, d_res_d_i, d_res_d_j) = inertial_jacobians(&preint, &i, &j);
            assert_eq!(residual, inertial_residual(&preint, &i, &j));
            check_jacobian("d_res_d_state_i", &d_res_d_i, 1e-8, |d| {
                dynamic(&inertial_residual(&preint, &i.plus(&fixed(d)), &j))
            });
            check_jacobian("d_res_d_state_j", &d_res_d_j, 1e-8, |d| {
                dynamic(&inertial_residual(&preint, &i, &j.plus(&fixed(d))))
            });
        }
    }

    #[test]
    fn the_square_root_whitens_and_is_forgotten_with_the_covariance() {
        let (mut preint, _, _) = case(3, 0.0);
        let more = lively(&mut rng("more", 1), 200.0, 60, false)[60];
        for _ in 0..2 {
            let root = sqrt_information(&preint).unwrap();
            let white = root * preint.covariance() * root.transpose();
            assert!((white - SMatrix::identity()).amax() < 1e-9, "{white:.2e}");
            assert!((0..STATE_DIM).all(|r| (r + 1..STATE_DIM).all(|c| root[(r, c)] == 0.0)));
            preint.push(more);
        }
    }

    #[test]
    fn what_cannot_be_weighed_is_said_so() {
        let samples = lively(&mut rng("singular", 1), 200.0, 20, false);
        let silent: Vec<_> = samples
            .iter()
            .map(|s| crate::preint::NoisySample {
                noise: ImuNoise::from_values([0.0; 3], [0.0; 3]).unwrap(),
                ..*s
            })
            .collect();
        for imu_cov in [ImuCov::Exact, ImuCov::Euler, ImuCov::Vins] {
            let default = PreintegrationConfig { imu_cov, ..PreintegrationConfig::default() };
            let root = |config, samples: &[_]| sqrt_information(&integrate(config, ImuBias::zero(), samples));
            assert!(root(default, &samples[..1]).is_none(), "{imu_cov:?}: no step");
            assert!(root(default, &samples[..2]).is_none(), "{imu_cov:?}: one step");
            assert!(root(default, &samples[..3]).is_some(), "{imu_cov:?}: two steps");
            assert!(root(config(imu_cov, 0.0, 0.0), &silent).is_none(), "{imu_cov:?}: no noise");
            assert!(root(config(imu_cov, 0.0, 1e-6), &samples).is_none(), "{imu_cov:?}: no walk");
            assert!(root(config(imu_cov, f64::MAX, 1e-6), &samples).is_none(), "{imu_cov:?}: overflow");
        }
    }
}
