//! Velocities, gravity, scale and the accelerometer's bias from cameras of unknown scale and the IMU between them: linear.
//!
//! With camera centres `c`, rotations `R` of the body, the camera at `t_bc` in it, `p = s c - R t_bc` and a bias `b` beyond the one
//! integrated with:
//!
//! ```text
//! R_i^T (s (c_j - c_i) - (R_j - R_i) t_bc - v_i T - g T^2/2) = alpha + J_alpha b
//! R_i^T (v_j - v_i - g T)                                    = beta  + J_beta b
//! ```
//! Weighted by the pre-integrated covariance with the cameras' uncertainty added to the positions' rows, and a prior on `b`. First `g`
//! is free; then it is held at its known length and turned in its tangent plane, `g = G (d + B w)`. Source: Qin and Shen 2017,
//! with weights, the bias and the scale's deviation added. What it finds starts [`super::refine`], whose numbers count.

use super::config::InitConfig;
use crate::preint::Preintegration;
use dpn_core::GRAVITY;
use dpn_core::geometry::sphere::tangent_basis;
use nalgebra::{DMatrix, DVector, Isometry3, Matrix3, SMatrix, SVector, Vector3};

/// Deviation of a scale that is expected, over it.
const EXPECTED_SCALE_STD: f64 = 0.3;
/// Rounds on the sphere of gravity.
const SPHERE_ROUNDS: usize = 4;

/// What the alignment found, in the frame of the given cameras.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Aligned {
    /// Metres per unit of the cameras.
    pub scale: f64,
    /// Its deviation over it.
    pub scale_std: f64,
    /// Gravity \[m/s^2\]; at rest the accelerometer reads its opposite.
    pub gravity: Vector3<f64>,
    /// A frame each \[m/s\].
    pub velocities: Vec<Vector3<f64>>,
    /// Change of the accelerometer's bias \[m/s^2\].
    pub accel_bias_change: Vector3<f64>,
}

/// Columns: a velocity a frame, then scale, bias, gravity (three numbers, or two in the tangent plane).
struct Columns {
    frames: usize,
}

impl Columns {
    fn scale(&self) -> usize {
        3 * self.frames
    }
    fn bias(&self) -> usize {
        self.scale() + 1
    }
    fn gravity(&self) -> usize {
        self.bias() + 3
    }
}

/// Aligns `cameras` (world from camera) with `preints`, the IMU between consecutive ones; `None` where that has no solution.
///
/// `position_std` is the cameras' uncertainty in their own unit; an `expected` scale, if there is one, counts as a measurement of it.
pub(super) fn align(
    cameras: &[Isometry3<f64>],
    position_std: f64,
    preints: &[Preintegration],
    body_from_cam: &Isometry3<f64>,
    config: &InitConfig,
    expected: Option<f64>,
) -> Option<Aligned> {
    // The cameras' uncertainty is in their unit; a first solution without it tells how many metres that is.
    let mut scale = 0.0;
    let mut gravity = None;
    let mut solution = None;
    for round in 0..=SPHERE_ROUNDS {
        let solved = solve(cameras, scale * position_std, preints, body_from_cam, config, gravity, expected)?;
        let direction = solved.gravity.try_normalize(1e-6)?;
        scale = solved.scale.abs();
        gravity = Some(direction);
        if round > 0 {
            solution = Some(Aligned { gravity: GRAVITY * direction, ..solved });
        }
    }
    solution
}

/// One weighted least squares; with a `direction`, gravity turns about it.
fn solve(
    cameras: &[Isometry3<f64>],
    position_std: f64,
    preints: &[Preintegration],
    body_from_cam: &Isometry3<f64>,
    config: &InitConfig,
    direction: Option<Vector3<f64>>,
    expected: Option<f64>,
) -> Option<Aligned> {
    let columns = Columns { frames: cameras.len() };
    let gravity_columns = if direction.is_some() { 2 } else { 3 };
    let n = columns.gravity() + gravity_columns;
    let known_gravity = direction.map_or_else(Vector3::zeros, |d| GRAVITY * d);
    let turn = direction.map(|d| GRAVITY * tangent_basis(&d));
    let world_from_body: Vec<_> =
        cameras.iter().map(|c| c.rotation * body_from_cam.rotation.inverse()).collect();
    let lever = body_from_cam.translation.vector;

    let mut information = DMatrix::<f64>::zeros(n, n);
    let mut right = DVector::<f64>::zeros(n);
    let mut total = 0.0;
    for (k, preint) in preints.iter().enumerate() {
        let t = preint.duration();
        let r_bw = world_from_body[k].inverse().to_rotation_matrix().into_inner();
        let moved = cameras[k + 1].translation.vector - cameras[k].translation.vector;
        let swung = world_from_body[k + 1] * lever - world_from_body[k] * lever;
        let mut target = SVector::<f64, 6>::zeros();
        let position = preint.delta().position + r_bw * (swung + 0.5 * t * t * known_gravity);
        target.fixed_rows_mut::<3>(0).copy_from(&position);
        target.fixed_rows_mut::<3>(3).copy_from(&(preint.delta().velocity + r_bw * (t * known_gravity)));

        let mut rows = DMatrix::<f64>::zeros(6, n);
        let mut put = |row: usize, column: usize, block: &Matrix3<f64>| {
            rows.fixed_view_mut::<3, 3>(row, column).copy_from(block);
        };
        put(0, 3 * k, &(-t * r_bw));
        put(3, 3 * k, &-r_bw);
        put(3, 3 * (k + 1), &r_bw);
        put(0, columns.bias(), &-preint.jacobian().fixed_view::<3, 3>(0, 0).into_owned());
        put(3, columns.bias(), &-preint.jacobian().fixed_view::<3, 3>(6, 0).into_owned());
        rows.fixed_view_mut::<3, 1>(0, columns.scale()).copy_from(&(r_bw * moved));
        for (row, factor) in [(0, -0.5 * t * t), (3, -t)] {
            match &turn {
                Some(turn) => {
                    rows.fixed_view_mut::<3, 2>(row, columns.gravity()).copy_from(&(factor * r_bw * turn));
                }
                None => rows.fixed_view_mut::<3, 3>(row, columns.gravity()).copy_from(&(factor * r_bw)),
            }
        }

        let full = preint.covariance();
        let pick = [0, 1, 2, 6, 7, 8];
        let mut covariance = SMatrix::<f64, 6, 6>::from_fn(|i, j| full[(pick[i], pick[j])]);
        for axis in 0..3 {
            covariance[(axis, axis)] += 2.0 * position_std * position_std;
        }
        let weight = covariance.cholesky()?.inverse();
        information += rows.transpose() * weight * &rows;
        right += rows.transpose() * (weight * target);
        total += (target.transpose() * weight * target)[(0, 0)];
    }
    for axis in 0..3 {
        let at = columns.bias() + axis;
        information[(at, at)] += config.accel_bias_std.powi(-2);
    }
    if let Some(expected) = expected {
        let weight = (EXPECTED_SCALE_STD * expected).powi(-2);
        information[(columns.scale(), columns.scale())] += weight;
        right[columns.scale()] += weight * expected;
        total += weight * expected * expected;
    }
    let factor = information.cholesky()?;
    let x = factor.solve(&right);
    if !x.iter().all(|v| v.is_finite()) {
        return None;
    }
    let scale = x[columns.scale()];
    let unit = DVector::from_fn(n, |row, _| f64::from(u8::from(row == columns.scale())));
    let variance = factor.solve(&unit)[columns.scale()];
    let free = (6 * preints.len() + 3).saturating_sub(n).max(1) as f64;
    let misfit = ((total - x.dot(&right)) / free).max(1.0);
    let gravity = match &turn {
        Some(turn) => known_gravity + turn * x.fixed_rows::<2>(columns.gravity()),
        None => x.fixed_rows::<3>(columns.gravity()).into_owned(),
    };
    Some(Aligned {
        scale,
        scale_std: (misfit * variance).max(0.0).sqrt() / scale.abs().max(1e-12),
        gravity,
        velocities: (0..cameras.len()).map(|k| x.fixed_rows::<3>(3 * k).into_owned()).collect(),
        accel_bias_change: x.fixed_rows::<3>(columns.bias()).into_owned(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::init::tests::{Scene, body_from_cam, gentle_flight};
    use dpn_core::geometry::so3::exp;

    #[test]
    fn exact_cameras_give_back_scale_gravity_velocities_and_bias() {
        for seed in 0..4 {
            let scene = Scene::new(&gentle_flight(seed), 11, 0.25, 0.0, seed);
            // Another world, another unit.
            let turn = exp(&Vector3::new(0.9, -1.2, 0.4));
            let unit = 2.7;
            let cameras: Vec<_> = scene
                .cameras
                .iter()
                .map(|c| {
                    Isometry3::from_parts((turn * c.translation.vector / unit).into(), turn * c.rotation)
                })
                .collect();
            let config = InitConfig { accel_bias_std: 10.0, ..InitConfig::default() };
            let found = align(&cameras, 1e-4, &scene.preints, &body_from_cam(), &config, None).unwrap();
            assert!((found.scale / unit - 1.0).abs() < 0.01, "seed {seed}: scale {} of {unit}", found.scale);
            let down = turn * Vector3::new(0.0, 0.0, -1.0);
            assert!(found.gravity.angle(&down).to_degrees() < 0.3, "seed {seed}");
            let bias = found.accel_bias_change - scene.bias.accel;
            assert!(bias.norm() < 0.05, "seed {seed}: bias off by {bias}");
            for (velocity, truth) in found.velocities.iter().zip(&scene.velocities) {
                assert!((velocity - turn * truth).norm() < 0.02, "seed {seed}");
            }
        }
    }

    #[test]
    fn without_acceleration_the_scale_is_not_certain() {
        let straight = |t: f64| Isometry3::new(Vector3::new(0.8 * t, 0.2 * t, 0.0), Vector3::zeros());
        let scene = Scene::new(&straight, 11, 0.25, 0.0, 1);
        let found =
            align(&scene.cameras, 0.01, &scene.preints, &body_from_cam(), &InitConfig::default(), None);
        assert!(found.is_none_or(|a| a.scale_std > 0.3));
    }
}
