//! Rest: the image stood still since the rest's first frame, so did the body, but for rocking on its feet as rotors shake it.
//!
//! ```text
//! r_p = (p_j - p_i) / s_p    r_rot = Log(R_i^-1 R_j) / s_rot    r_vi = v_i / s_v    r_vj = v_j / s_v
//! ```
//! 12 rows. Without it a body on the ground drifts as the window forgets what it saw from elsewhere: tracks that do not move say
//! nothing of depth, and points move off to infinity while the integrated accelerometer moves the body.

use crate::state::{NavState, ROTATION, VELOCITY};
use dpn_core::geometry::so3;
use nalgebra::{Matrix3, SMatrix, SVector};

/// From the camera to where the body stands: rocking by an angle moves it by that times this \[m\].
pub(crate) const LEVER: f64 = 0.5;
/// What a tracker's own error leaves open, half a pixel: no rest is known better \[rad\].
const LEAST_ANGLE: f64 = 1e-3;
/// The time in which rocking may go through the whole of its way \[s\].
const SECONDS: f64 = 0.1;

/// Where the rows of the first frame's velocity begin.
pub(crate) const FIRST_VELOCITY: usize = 6;
/// Rows of the residual.
pub(crate) const ROWS: usize = 12;

/// The residual in standard deviations, and its derivatives by the first nine unknowns of both states (position, rotation, velocity).
///
/// `angle` \[rad\] is by how much the image may have moved: s_rot is that, s_p half a metre's arc of it, s_v that arc in a tenth of a second.
pub(crate) fn rest_jacobians(
    i: &NavState,
    j: &NavState,
    angle: f64,
) -> (SVector<f64, ROWS>, SMatrix<f64, ROWS, 9>, SMatrix<f64, ROWS, 9>) {
    let rotation_std = angle.max(LEAST_ANGLE);
    let position_std = LEVER * rotation_std;
    let velocity_std = position_std / SECONDS;
    let turn = so3::log(&(i.world_from_body.rotation.inverse() * j.world_from_body.rotation));
    let mut residual = SVector::<f64, ROWS>::zeros();
    let moved = j.world_from_body.translation.vector - i.world_from_body.translation.vector;
    residual.fixed_rows_mut::<3>(0).copy_from(&(moved / position_std));
    residual.fixed_rows_mut::<3>(3).copy_from(&(turn / rotation_std));
    residual.fixed_rows_mut::<3>(6).copy_from(&(i.vel_in_world / velocity_std));
    residual.fixed_rows_mut::<3>(9).copy_from(&(j.vel_in_world / velocity_std));
    let unrolled = so3::right_jacobian_inverse(&turn);
    let back = so3::exp(&-turn).to_rotation_matrix().into_inner();
    let mut d_i = SMatrix::<f64, ROWS, 9>::zeros();
    let mut d_j = SMatrix::<f64, ROWS, 9>::zeros();
    let eye = Matrix3::<f64>::identity();
    d_i.fixed_view_mut::<3, 3>(0, 0).copy_from(&(-eye / position_std));
    d_j.fixed_view_mut::<3, 3>(0, 0).copy_from(&(eye / position_std));
    d_i.fixed_view_mut::<3, 3>(3, ROTATION).copy_from(&(-unrolled * back / rotation_std));
    d_j.fixed_view_mut::<3, 3>(3, ROTATION).copy_from(&(unrolled / rotation_std));
    d_i.fixed_view_mut::<3, 3>(6, VELOCITY).copy_from(&(eye / velocity_std));
    d_j.fixed_view_mut::<3, 3>(9, VELOCITY).copy_from(&(eye / velocity_std));
    (residual, d_i, d_j)
}

#[cfg(test)]
mod tests {
    use super::*;
    use dpn_core::random::Stream;
    use dpn_testing::check_jacobian;
    use nalgebra::{DVector, SVector};
    use rand::Rng;

    #[test]
    fn jacobians_are_the_derivatives() {
        for seed in 0..10 {
            let mut rng = Stream::new(seed).named("rest").rng();
            let mut random =
                || NavState::identity().plus(&SVector::from_fn(|_, _| rng.random_range(-1.0..1.0)));
            let (i, j) = (random(), random());
            let (_, d_i, d_j) = rest_jacobians(&i, &j, 1e-3);
            let moved = |s: &NavState, d: &DVector<f64>| {
                s.plus(&SVector::from_fn(|k, _| if k < 9 { d[k] } else { 0.0 }))
            };
            let vector = |r: SVector<f64, ROWS>| DVector::from_column_slice(r.as_slice());
            check_jacobian("d_res_d_i", &d_i, 1e-7, |d| vector(rest_jacobians(&moved(&i, d), &j, 1e-3).0));
            check_jacobian("d_res_d_j", &d_j, 1e-7, |d| vector(rest_jacobians(&i, &moved(&j, d), 1e-3).0));
        }
    }
}
