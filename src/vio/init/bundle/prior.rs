//! What is known beside tracks and IMU: gauges, rest, and how large a bias can be. Rows are whitened and sparse.

use super::problem::{BundleState, Layout};
use crate::state::ImuBias;
use dpn_core::geometry::so3;
use nalgebra::{Matrix3, UnitQuaternion, Vector3};

/// One whitened row: a residual and its derivatives by the unknowns in these columns.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Row {
    /// Over its deviation.
    pub residual: f64,
    /// Column and derivative.
    pub entries: Vec<(usize, f64)>,
}

/// A piece of knowledge.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Prior {
    /// The frame's position \[m\].
    Position { frame: usize, value: Vector3<f64>, std: f64 },
    /// The frame's rotation about the world's z axis \[rad\].
    Yaw { frame: usize, value: UnitQuaternion<f64>, std: f64 },
    /// The frame's rotation \[rad\].
    Rotation { frame: usize, value: UnitQuaternion<f64>, std: f64 },
    /// The distance of two frames \[m\].
    Distance { from: usize, to: usize, value: f64, std: f64 },
    /// The frame stands still \[m/s\].
    NoVelocity { frame: usize, std: f64 },
    /// Two frames have one pose \[m, rad\].
    SamePose { first: usize, second: usize, position_std: f64, rotation_std: f64 },
    /// The bias that all frames share \[m/s^2, rad/s\].
    Bias { value: ImuBias, accel_std: f64, gyro_std: f64 },
}

/// Appends `residual / std` with `blocks` (first column, derivative) as three rows.
fn push(rows: &mut Vec<Row>, residual: &Vector3<f64>, std: f64, blocks: &[(usize, Matrix3<f64>)]) {
    for axis in 0..3 {
        let entries = blocks
            .iter()
            .flat_map(|(at, d)| (0..3).map(move |column| (at + column, d[(axis, column)] / std)))
            .collect();
        rows.push(Row { residual: residual[axis] / std, entries });
    }
}

impl Prior {
    /// Appends this prior's rows at `state`.
    pub(crate) fn rows(&self, layout: &Layout, state: &BundleState, rows: &mut Vec<Row>) {
        let eye = Matrix3::identity();
        let position = |frame: usize| state.poses[frame].translation.vector;
        let rotation = |frame: usize| state.poses[frame].rotation;
        match self {
            Self::Position { frame, value, std } => {
                push(rows, &(position(*frame) - value), *std, &[(layout.position(*frame), eye)]);
            }
            Self::Yaw { frame, value, std } => {
                let angle = so3::log(&(rotation(*frame) * value.inverse()));
                let d = so3::right_jacobian_inverse(&angle) * value.to_rotation_matrix().matrix();
                let at = layout.rotation(*frame);
                let entries = (0..3).map(|column| (at + column, d[(2, column)] / std)).collect();
                rows.push(Row { residual: angle.z / std, entries });
            }
            Self::Rotation { frame, value, std } => {
                let angle = so3::log(&(value.inverse() * rotation(*frame)));
                let d = so3::right_jacobian_inverse(&angle);
                push(rows, &angle, *std, &[(layout.rotation(*frame), d)]);
            }
            Self::Distance { from, to, value, std } => {
                let between = position(*to) - position(*from);
                let distance = between.norm();
                let unit = between / distance.max(1e-12);
                let entries = (0..3)
                    .flat_map(|k| {
                        [
                            (layout.position(*to) + k, unit[k] / std),
                            (layout.position(*from) + k, -unit[k] / std),
                        ]
                    })
                    .collect();
                rows.push(Row { residual: (distance - value) / std, entries });
            }
            Self::NoVelocity { frame, std } => {
                if let Some(at) = layout.velocity(*frame) {
                    push(rows, &state.velocities[*frame], *std, &[(at, eye)]);
                }
            }
            Self::SamePose { first, second, position_std, rotation_std } => {
                let (a, b) = (layout.position(*first), layout.position(*second));
                push(rows, &(position(*second) - position(*first)), *position_std, &[(b, eye), (a, -eye)]);
                let turn = rotation(*first).inverse() * rotation(*second);
                let angle = so3::log(&turn);
                let inverse = so3::right_jacobian_inverse(&angle);
                let d_first = -inverse * turn.inverse().to_rotation_matrix().matrix();
                let (a, b) = (layout.rotation(*first), layout.rotation(*second));
                push(rows, &angle, *rotation_std, &[(b, inverse), (a, d_first)]);
            }
            Self::Bias { value, accel_std, gyro_std } => {
                if let Some(at) = layout.bias() {
                    push(rows, &(state.bias.accel - value.accel), *accel_std, &[(at, eye)]);
                    push(rows, &(state.bias.gyro - value.gyro), *gyro_std, &[(at + 3, eye)]);
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::problem::tests::random_state;
    use super::*;
    use dpn_core::geometry::so3::exp;
    use dpn_testing::check_jacobian;
    use nalgebra::{DMatrix, DVector};

    #[test]
    fn every_priors_rows_are_its_residuals_derivatives() {
        let layout = Layout::inertial(3);
        let rotation = exp(&Vector3::new(0.2, -0.4, 0.9));
        let bias = ImuBias { accel: Vector3::new(0.1, 0.2, -0.1), gyro: Vector3::new(0.01, 0.0, 0.02) };
        let all = [
            Prior::Position { frame: 1, value: Vector3::new(1.0, 2.0, 3.0), std: 0.5 },
            Prior::Yaw { frame: 0, value: rotation, std: 0.1 },
            Prior::Rotation { frame: 2, value: rotation, std: 0.1 },
            Prior::Distance { from: 0, to: 2, value: 1.0, std: 0.2 },
            Prior::NoVelocity { frame: 1, std: 0.02 },
            Prior::SamePose { first: 0, second: 1, position_std: 0.1, rotation_std: 0.2 },
            Prior::Bias { value: bias, accel_std: 0.3, gyro_std: 0.1 },
        ];
        for (case, prior) in all.iter().enumerate() {
            let state = random_state(3, 0, case as u64);
            let residual = |state: &BundleState| {
                let mut rows = Vec::new();
                prior.rows(&layout, state, &mut rows);
                rows
            };
            let rows = residual(&state);
            assert!(!rows.is_empty());
            let mut jacobian = DMatrix::zeros(rows.len(), layout.len());
            for (r, row) in rows.iter().enumerate() {
                row.entries.iter().for_each(|(c, d)| jacobian[(r, *c)] += d);
            }
            check_jacobian(&format!("{prior:?}"), &jacobian, 1e-6, |d| {
                let moved = state.plus(&layout, d, &[]);
                DVector::from_iterator(rows.len(), residual(&moved).iter().map(|r| r.residual))
            });
        }
    }
}
