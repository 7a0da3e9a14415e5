//! What the IMU says between two frames under one shared bias, whitened.
//!
//! ```text
//! r_rot = Log(gamma(b)^T R_i^T R_j)
//! r_pos = R_i^T (p_j - p_i - v_i T - g T^2/2) - alpha(b)
//! r_vel = R_i^T (v_j - v_i - g T) - beta(b)                      g = (0, 0, -9.81) in the world frame
//! ```
//! The rows are whitened in this order by the inverse Cholesky factor of their covariance: so the first three hold what the gyro's
//! noise explains, the other six what is left for the accelerometer's, and each group can be given a factor of its own
//! ([`InertialFactor::rescale`]). Rotations are perturbed on the right.

use super::problem::{BundleState, Layout};
use crate::preint::{Delta, Preintegration};
use crate::state::ImuBias;
use dpn_core::GRAVITY;
use dpn_core::geometry::so3;
use nalgebra::{Matrix3, SMatrix, SVector, Vector3};

/// Rows of rotation.
pub(crate) const GYRO_ROWS: usize = 3;
/// Rows.
const ROWS: usize = 9;
/// Columns: pose and velocity of both frames, then the bias.
const COLUMNS: usize = 24;
/// Where the second frame's columns begin.
const SECOND: usize = 9;
/// Where the bias's columns begin.
const BIAS: usize = 18;

/// The motion measured between two frames.
#[derive(Debug, Clone)]
pub(crate) struct InertialFactor {
    first: usize,
    second: usize,
    duration: f64,
    bias: ImuBias,
    delta: Delta,
    /// Rows rotation, position, velocity; columns accelerometer, gyro.
    d_delta_d_bias: SMatrix<f64, ROWS, 6>,
    /// Inverse Cholesky factor of the covariance.
    whiten: SMatrix<f64, ROWS, ROWS>,
    /// Expected deviation of whitened rows: gyro's, accelerometer's.
    factors: [f64; 2],
}

/// Rows (position, rotation, velocity) in this file's order.
fn reorder<const C: usize>(m: &SMatrix<f64, ROWS, C>) -> SMatrix<f64, ROWS, C> {
    let mut out = *m;
    out.fixed_rows_mut::<3>(0).copy_from(&m.fixed_rows::<3>(3));
    out.fixed_rows_mut::<3>(3).copy_from(&m.fixed_rows::<3>(0));
    out
}

impl InertialFactor {
    /// The measurement `preint` between frames `first` and `second`; `None` where its covariance is singular or not finite.
    pub(crate) fn new(first: usize, second: usize, preint: &Preintegration) -> Option<Self> {
        let covariance: SMatrix<f64, ROWS, ROWS> =
            preint.covariance().fixed_view::<ROWS, ROWS>(0, 0).into_owned();
        let covariance = reorder(&reorder(&covariance).transpose());
        let whiten = covariance.cholesky()?.l().try_inverse()?;
        whiten.iter().all(|x| x.is_finite()).then(|| Self {
            first,
            second,
            duration: preint.duration(),
            bias: *preint.bias(),
            delta: *preint.delta(),
            d_delta_d_bias: reorder(preint.jacobian()),
            whiten,
            factors: [1.0; 2],
        })
    }

    /// Expects residuals `gyro` and `accel` times as large as the samples' noise says.
    pub(crate) fn rescale(&mut self, gyro: f64, accel: f64) {
        self.factors = [gyro, accel];
    }

    /// The whitened residual, gyro's rows first.
    pub(crate) fn whitened_residual(&self, state: &BundleState) -> SVector<f64, ROWS> {
        self.scale(self.whiten * self.residual(state).0)
    }

    fn scale<const C: usize>(&self, mut rows: SMatrix<f64, ROWS, C>) -> SMatrix<f64, ROWS, C> {
        let [gyro, accel] = self.factors;
        rows.fixed_rows_mut::<GYRO_ROWS>(0).scale_mut(1.0 / gyro);
        rows.fixed_rows_mut::<6>(GYRO_ROWS).scale_mut(1.0 / accel);
        rows
    }

    /// The residual; the position's and the velocity's differences in the first body frame; the bias's turn.
    fn residual(
        &self,
        state: &BundleState,
    ) -> (SVector<f64, ROWS>, Vector3<f64>, Vector3<f64>, Vector3<f64>) {
        let (pose_i, pose_j) = (&state.poses[self.first], &state.poses[self.second]);
        let (vel_i, vel_j) = (state.velocities[self.first], state.velocities[self.second]);
        let (t, gravity) = (self.duration, Vector3::new(0.0, 0.0, -GRAVITY));
        let mut shift = SVector::<f64, 6>::zeros();
        shift.fixed_rows_mut::<3>(0).copy_from(&(state.bias.accel - self.bias.accel));
        shift.fixed_rows_mut::<3>(3).copy_from(&(state.bias.gyro - self.bias.gyro));
        let moved = self.d_delta_d_bias * shift;
        let turn = moved.fixed_rows::<3>(0).into_owned();

        let r_bw = pose_i.rotation.inverse();
        let gained = r_bw
            * (pose_j.translation.vector - pose_i.translation.vector - vel_i * t - 0.5 * t * t * gravity);
        let sped = r_bw * (vel_j - vel_i - gravity * t);
        let rotation = (self.delta.rotation * so3::exp(&turn)).inverse() * r_bw * pose_j.rotation;
        let mut residual = SVector::<f64, ROWS>::zeros();
        residual.fixed_rows_mut::<3>(0).copy_from(&so3::log(&rotation));
        residual.fixed_rows_mut::<3>(3).copy_from(&(gained - self.delta.position - moved.fixed_rows::<3>(3)));
        residual.fixed_rows_mut::<3>(6).copy_from(&(sped - self.delta.velocity - moved.fixed_rows::<3>(6)));
        (residual, gained, sped, turn)
    }

    /// The whitened residual and its derivative by the columns that [`Self::columns`] names.
    pub(crate) fn rows(&self, state: &BundleState) -> (SVector<f64, ROWS>, SMatrix<f64, ROWS, COLUMNS>) {
        let (residual, gained, sped, turn) = self.residual(state);
        let (pose_i, pose_j) = (&state.poses[self.first], &state.poses[self.second]);
        let r_bw = pose_i.rotation.inverse().to_rotation_matrix().into_inner();
        let r_ij = (pose_i.rotation.inverse() * pose_j.rotation).to_rotation_matrix().into_inner();
        let angle = residual.fixed_rows::<3>(0).into_owned();
        let inverse = so3::right_jacobian_inverse(&angle);
        let mut d = SMatrix::<f64, ROWS, COLUMNS>::zeros();
        let mut put = |row: usize, column: usize, block: &Matrix3<f64>| {
            d.fixed_view_mut::<3, 3>(row, column).copy_from(block);
        };
        // Columns of a frame: position 0, rotation 3, velocity 6.
        put(0, 3, &(-inverse * r_ij.transpose()));
        put(0, SECOND + 3, &inverse);
        let back = so3::exp(&angle).inverse().to_rotation_matrix().into_inner();
        let d_turn_d_gyro = self.d_delta_d_bias.fixed_view::<3, 3>(0, 3).into_owned();
        put(0, BIAS + 3, &(-inverse * back * so3::right_jacobian(&turn) * d_turn_d_gyro));
        put(3, 0, &-r_bw);
        put(3, 3, &so3::hat(&gained));
        put(3, 6, &(-self.duration * r_bw));
        put(3, SECOND, &r_bw);
        put(6, 3, &so3::hat(&sped));
        put(6, 6, &-r_bw);
        put(6, SECOND + 6, &r_bw);
        d.fixed_view_mut::<6, 6>(3, BIAS).copy_from(&-self.d_delta_d_bias.fixed_rows::<6>(3));
        (self.scale(self.whiten * residual), self.scale(self.whiten * d))
    }

    /// The unknown behind each column of [`Self::rows`].
    pub(crate) fn columns(&self, layout: &Layout) -> Option<[usize; COLUMNS]> {
        let bias = layout.bias()?;
        Some(std::array::from_fn(|c| match c {
            0..SECOND => layout.position(self.first) + c,
            SECOND..BIAS => layout.position(self.second) + c - SECOND,
            _ => bias + c - BIAS,
        }))
    }
}

#[cfg(test)]
mod tests {
    use super::super::problem::tests::random_state;
    use super::*;
    use crate::init::tests::random_preintegration;
    use dpn_testing::check_jacobian;
    use nalgebra::{DMatrix, DVector};

    #[test]
    fn the_rows_are_the_residuals_derivatives() {
        let layout = Layout::inertial(2);
        for seed in 0..20 {
            let mut factor = InertialFactor::new(0, 1, &random_preintegration(40, seed)).unwrap();
            factor.rescale(3.0, 0.5);
            let state = random_state(2, 0, seed);
            let (residual, rows) = factor.rows(&state);
            assert_eq!(residual, factor.whitened_residual(&state));
            let columns = factor.columns(&layout).unwrap();
            let mut jacobian = DMatrix::zeros(ROWS, layout.len());
            for (c, at) in columns.iter().enumerate() {
                jacobian.set_column(*at, &rows.column(c));
            }
            check_jacobian("inertial", &jacobian, 1e-6, |d| {
                let moved = state.plus(&layout, d, &[]);
                DVector::from_column_slice(factor.whitened_residual(&moved).as_slice())
            });
        }
    }

    #[test]
    fn a_predicted_state_has_no_residual() {
        let preint = random_preintegration(60, 3);
        let factor = InertialFactor::new(0, 1, &preint).unwrap();
        let mut state = random_state(2, 0, 3);
        let first = crate::NavState {
            world_from_body: state.poses[0],
            vel_in_world: state.velocities[0],
            bias: state.bias,
        };
        let second = preint.predict(&first);
        state.poses[1] = second.world_from_body;
        state.velocities[1] = second.vel_in_world;
        assert!(factor.whitened_residual(&state).norm() < 1e-6);
    }

    #[test]
    fn whitening_makes_the_covariance_one_with_the_gyro_alone_in_its_rows() {
        let preint = random_preintegration(40, 5);
        let factor = InertialFactor::new(0, 1, &preint).unwrap();
        let motion: SMatrix<f64, 9, 9> = preint.covariance().fixed_view::<9, 9>(0, 0).into_owned();
        let whitened = factor.whiten * reorder(&reorder(&motion).transpose()) * factor.whiten.transpose();
        assert!((whitened - SMatrix::identity()).norm() < 1e-6);
        assert_eq!(factor.whiten.fixed_view::<3, 6>(0, 3).norm(), 0.0);
    }
}
