//! What a published pose says of the key next to it. 6 rows: position, rotation.
//!
//! With the body's position `p`, rotation `R`, velocity, acceleration `a`, angular rate `w` and angular acceleration `w'` at the IMU's
//! instant `t_published - delay`, the mount `M`, the lever `l`, the published world's tilt `T` and the slow errors `e_p`, `e_R`:
//! ```text
//! r_p   = p_published - T (p + R l + c a) - e_p
//! r_rot = Log((T R Exp(c w') M Exp(e_R))^-1 R_published)
//! ```
//! `c` is half the second moment of a smoothing kernel: smoothing of x adds `c x''` to it, as being late by d adds `-d x'`. The derivatives by the
//! biases over the 10 ms between key and pose are left out: what is known of the biases comes along the chain.

use crate::layout::{
    BLUR, CONSTANTS, DELAY, Frames, KEY_DIM, Key, LEVER, MOUNT, POSITION_ERROR, ROTATION_ERROR, TILT,
};
use crate::near::Near;
use dpn_core::geometry::so3;
use dpn_vio::state::{POSITION, ROTATION, VELOCITY};
use nalgebra::{Isometry3, Matrix3, SMatrix, SVector, UnitQuaternion, Vector3};

/// Rows of a published pose.
pub(crate) const POSE_ROWS: usize = 6;

/// How the motion bends at a published pose; known well enough from the IMU beforehand.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Bend {
    /// Acceleration in the world \[m/s^2\].
    pub(crate) accel_in_world: Vector3<f64>,
    /// Angular rate in the body frame, its mean over the keys beside \[rad/s\]: one reading's vibration is no motion.
    pub(crate) rate_in_body: Vector3<f64>,
    /// Angular acceleration in the body frame \[rad/s^2\].
    pub(crate) angular_accel_in_body: Vector3<f64>,
}

/// The residual and its derivatives by the key and by the constants.
#[derive(Debug, Clone)]
pub(crate) struct PoseTerm {
    /// Position \[m\], rotation \[rad\].
    pub(crate) residual: SVector<f64, POSE_ROWS>,
    /// By the key's unknowns.
    pub(crate) by_key: SMatrix<f64, POSE_ROWS, KEY_DIM>,
    /// By the constants.
    pub(crate) by_constants: SMatrix<f64, POSE_ROWS, CONSTANTS>,
}

fn matrix(rotation: &UnitQuaternion<f64>) -> Matrix3<f64> {
    rotation.to_rotation_matrix().into_inner()
}

/// Of `published` beside `key`.
pub(crate) fn pose_term(
    published: &Isometry3<f64>,
    key: &Key,
    near: &Near,
    bend: &Bend,
    frames: &Frames,
) -> PoseTerm {
    let (position, rotation, velocity) = near.body(key);
    let tilt = &frames.published_world_from_world;
    let mount = &frames.body_from_published_body;
    let lever = &frames.lever_in_body;
    let bent = so3::exp(&(frames.blur_s2 * bend.angular_accel_in_body));
    let error = so3::exp(&key.rotation_error);

    let origin = position + rotation * lever + frames.blur_s2 * bend.accel_in_world;
    let expected = tilt * origin;
    let turned = tilt * rotation * bent * mount * error;
    let off = turned.inverse() * published.rotation;
    let mut residual = SVector::<f64, POSE_ROWS>::zeros();
    residual
        .fixed_rows_mut::<3>(0)
        .copy_from(&(published.translation.vector - expected - key.position_error));
    let angle = so3::log(&off);
    residual.fixed_rows_mut::<3>(3).copy_from(&angle);

    let mut by_key = SMatrix::<f64, POSE_ROWS, KEY_DIM>::zeros();
    let mut by_constants = SMatrix::<f64, POSE_ROWS, CONSTANTS>::zeros();
    let (tilt, near_rotation) = (matrix(tilt), matrix(&near.rotation));
    let (r_wb, r_key) = (matrix(&rotation), matrix(&key.state.world_from_body.rotation));

    let mut put =
        |row, column, block: Matrix3<f64>| by_key.fixed_view_mut::<3, 3>(row, column).copy_from(&block);
    put(0, POSITION, -tilt);
    put(0, VELOCITY, -tilt * near.tau);
    put(
        0,
        ROTATION,
        tilt * (r_key * so3::hat(&near.position) + r_wb * so3::hat(lever) * near_rotation.transpose()),
    );
    put(0, POSITION_ERROR, -Matrix3::identity());
    let moved = velocity + rotation * bend.rate_in_body.cross(lever);
    by_constants.fixed_view_mut::<3, 1>(0, DELAY).copy_from(&(tilt * moved));
    by_constants.fixed_view_mut::<3, 3>(0, LEVER).copy_from(&(-tilt * r_wb));
    let by_tilt = tilt * so3::hat(&origin);
    by_constants.fixed_view_mut::<3, 2>(0, TILT).copy_from(&by_tilt.fixed_view::<3, 2>(0, 0));
    by_constants.fixed_view_mut::<3, 1>(0, BLUR).copy_from(&(-tilt * bend.accel_in_world));

    // A turn rho on the right of `turned` moves the angle by -Jr^-1(angle) Exp(-angle) rho.
    let by_turn = -so3::right_jacobian_inverse(&angle) * matrix(&so3::exp(&-angle));
    let after_mount = by_turn * matrix(&error.inverse());
    let after_bend = after_mount * matrix(&mount.inverse());
    let after_body = after_bend * matrix(&bent.inverse());
    let mut put =
        |row, column, block: Matrix3<f64>| by_key.fixed_view_mut::<3, 3>(row, column).copy_from(&block);
    put(3, ROTATION, after_body * near_rotation.transpose());
    put(3, ROTATION_ERROR, by_turn * so3::right_jacobian(&key.rotation_error));
    by_constants.fixed_view_mut::<3, 1>(3, DELAY).copy_from(&(-after_body * bend.rate_in_body));
    by_constants.fixed_view_mut::<3, 3>(3, MOUNT).copy_from(&after_mount);
    let whole = after_body * matrix(&rotation.inverse());
    by_constants.fixed_view_mut::<3, 2>(3, TILT).copy_from(&whole.fixed_view::<3, 2>(0, 0));
    by_constants.fixed_view_mut::<3, 1>(3, BLUR).copy_from(&(after_bend * bend.angular_accel_in_body));
    PoseTerm { residual, by_key, by_constants }
}

#[cfg(test)]
mod tests {
    use super::*;
    use dpn_core::random::Stream;
    use dpn_core::{ImuSample, Stamp};
    use dpn_testing::check_jacobian;
    use dpn_vio::{ImuBias, NavState};
    use nalgebra::DVector;
    use rand::Rng;

    fn vector(rng: &mut impl Rng, scale: f64) -> Vector3<f64> {
        Vector3::from_fn(|_, _| rng.random_range(-scale..scale))
    }

    fn pose(rng: &mut impl Rng) -> Isometry3<f64> {
        Isometry3::from_parts(vector(rng, 4.0).into(), so3::exp(&vector(rng, 2.0)))
    }

    struct Case {
        samples: Vec<ImuSample>,
        key: Key,
        frames: Frames,
        bend: Bend,
        published: Isometry3<f64>,
        stamp: Stamp,
    }

    impl Case {
        fn random(seed: u64) -> Self {
            let mut rng = Stream::new(seed).named("published").rng();
            // Readings that stand still: the pose's derivative by time is then exact, and only the bend's own change is left out.
            let (gyro, accel) = (vector(&mut rng, 2.0).into(), vector(&mut rng, 12.0).into());
            let sample = |i: i64| ImuSample { t: Stamp::from_ns(5_000_000 * i), gyro, accel };
            let bias = ImuBias { accel: vector(&mut rng, 0.2), gyro: vector(&mut rng, 0.1) };
            let frames = Frames {
                delay_s: 0.004,
                body_from_published_body: so3::exp(&vector(&mut rng, 1.0)),
                lever_in_body: vector(&mut rng, 0.1),
                published_world_from_world: so3::exp(&vector(&mut rng, 0.2)),
                blur_s2: 1e-3,
            };
            Self {
                samples: (0..9).map(sample).collect(),
                key: Key {
                    sample: 4,
                    state: NavState {
                        world_from_body: pose(&mut rng),
                        vel_in_world: vector(&mut rng, 3.0),
                        bias,
                    },
                    position_error: vector(&mut rng, 0.01),
                    rotation_error: vector(&mut rng, 0.01),
                    error_rate: vector(&mut rng, 0.01),
                },
                frames,
                bend: Bend {
                    accel_in_world: vector(&mut rng, 10.0),
                    rate_in_body: Vector3::from(gyro) - bias.gyro,
                    angular_accel_in_body: vector(&mut rng, 20.0),
                },
                published: pose(&mut rng),
                stamp: Stamp::from_ns(rng.random_range(12_000_000..36_000_000)),
            }
        }

        fn term(&self, key: &Key, frames: &Frames) -> PoseTerm {
            let t = self.stamp.plus_seconds(-frames.delay_s);
            // Nanoseconds are too coarse a step for differences: the rest goes by hand.
            let mut near = Near::new(&self.samples, key, t);
            let rest = self.stamp.seconds_since(self.samples[4].t) - frames.delay_s - near.tau;
            let force = Vector3::from(self.samples[0].accel) - key.state.bias.accel;
            near.position += near.velocity * rest;
            near.velocity += near.rotation * force * rest;
            let rate = Vector3::from(self.samples[0].gyro) - key.state.bias.gyro;
            near.rotation *= so3::exp(&(rate * rest));
            near.tau += rest;
            pose_term(&self.published, key, &near, &self.bend, frames)
        }
    }

    #[test]
    fn derivatives_are_those_of_the_residual() {
        for seed in 0..20 {
            let case = Case::random(seed);
            let term = case.term(&case.key, &case.frames);
            let residual = |term: PoseTerm| DVector::from_column_slice(term.residual.as_slice());
            // The mid-point rule's velocity is the derivative of its position but for the square of a step: 1e-5 m/s.
            check_jacobian("d_res_d_constants", &term.by_constants, 1e-5, |d| {
                let moved = case.frames.plus(&SVector::from_column_slice(d.as_slice()));
                residual(case.term(&case.key, &moved))
            });
            // Columns of the biases are zero by design.
            let without_bias: Vec<usize> = (0..9).chain(15..KEY_DIM).collect();
            let by_key = term.by_key.select_columns(&without_bias);
            check_jacobian("d_res_d_key", &by_key, 1e-7, |d| {
                let mut step = SVector::<f64, KEY_DIM>::zeros();
                without_bias.iter().zip(d).for_each(|(at, value)| step[*at] = *value);
                residual(case.term(&case.key.plus(&step), &case.frames))
            });
        }
    }

    #[test]
    fn a_pose_published_from_the_key_has_no_residual() {
        let mut case = Case::random(3);
        case.frames = Frames::identity();
        case.key.position_error = Vector3::zeros();
        case.key.rotation_error = Vector3::zeros();
        for stamp in [20_000_000, 31_000_000, 11_000_000] {
            let near = Near::new(&case.samples, &case.key, Stamp::from_ns(stamp));
            let (position, rotation, _) = near.body(&case.key);
            let published = Isometry3::from_parts(position.into(), rotation);
            let term = pose_term(&published, &case.key, &near, &case.bend, &case.frames);
            assert!(term.residual.norm() < 1e-12, "{}", term.residual);
            assert_eq!(near.tau, (stamp - 20_000_000) as f64 * 1e-9);
        }
    }
}
