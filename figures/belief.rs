//! What an estimator believes of its poses, as deviations of the numbers that are drawn.

use dpn_core::Stamp;
use dpn_eval::metrics::Alignment;
use nalgebra::{Isometry3, Matrix3, Matrix6};

/// How well a pose is known: covariances along the axes of the estimate's world \[m^2, rad^2\].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PoseBelief {
    /// When.
    pub t: Stamp,
    /// Of the position.
    pub position: Matrix3<f64>,
    /// Of a small turn.
    pub rotation: Matrix3<f64>,
}

impl PoseBelief {
    /// Of a covariance of position, in the world, and rotation, on the right, of the pose that it is about.
    pub fn of_right(t: Stamp, pose: &Isometry3<f64>, covariance: &Matrix6<f64>) -> Self {
        let turn = pose.rotation.to_rotation_matrix();
        let rotation = turn * covariance.fixed_view::<3, 3>(3, 3) * turn.transpose();
        Self { t, position: covariance.fixed_view::<3, 3>(0, 0).into(), rotation }
    }

    /// Three deviations of x, y, z \[m\], roll, pitch and yaw \[deg\] of a pose that was brought to the truth's world by `alignment`.
    pub(super) fn three_sigma(&self, aligned: &Isometry3<f64>, alignment: &Alignment) -> [f64; 6] {
        let turn = alignment.true_world_from_est_world.rotation.to_rotation_matrix();
        let position = turn * self.position * turn.transpose() * alignment.scale.powi(2);
        let (_, pitch, yaw) = aligned.rotation.euler_angles();
        let ((s, c), up) = (yaw.sin_cos(), pitch.cos().max(1e-3));
        let tangent = pitch.sin() / up;
        // How roll, pitch and yaw change with a small turn about the world's axes.
        let angles = Matrix3::new(c / up, s / up, 0.0, -s, c, 0.0, c * tangent, s * tangent, 1.0) * turn;
        let rotation = angles * self.rotation * angles.transpose();
        let sigma = |variance: f64| 3.0 * variance.max(0.0).sqrt();
        let of = |k: usize| {
            if k < 3 { sigma(position[(k, k)]) } else { sigma(rotation[(k - 3, k - 3)]).to_degrees() }
        };
        std::array::from_fn(of)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{UnitQuaternion, Vector3};

    #[test]
    fn deviations_are_those_of_numbers_drawn_anew() {
        let pose = Isometry3::from_parts(
            Vector3::new(1.0, 2.0, 3.0).into(),
            UnitQuaternion::from_euler_angles(0.3, -0.6, 2.1),
        );
        let alignment = Alignment {
            true_world_from_est_world: Isometry3::new(Vector3::new(4.0, -1.0, 0.5), Vector3::z() * 0.8),
            scale: 1.5,
        };
        let covariance = Matrix6::from_diagonal(&[4e-4, 1e-4, 9e-4, 1e-6, 4e-6, 9e-6].into());
        let belief = PoseBelief::of_right(Stamp::from_ns(0), &pose, &covariance);
        let aligned = alignment.apply(&pose);
        let found = belief.three_sigma(&aligned, &alignment);
        // The variance of each number by its derivatives along the six directions.
        let numbers = |pose: &Isometry3<f64>| {
            let ([x, y, z], (roll, pitch, yaw)): ([f64; 3], _) =
                (pose.translation.vector.into(), pose.rotation.euler_angles());
            [x, y, z, roll.to_degrees(), pitch.to_degrees(), yaw.to_degrees()]
        };
        let mut variances = [0.0; 6];
        for k in 0..6 {
            let step = covariance[(k, k)].sqrt();
            let moved = |by: f64| {
                let mut moved = pose;
                if k < 3 {
                    moved.translation.vector[k] += by;
                } else {
                    moved.rotation *= UnitQuaternion::from_scaled_axis(Vector3::ith(k - 3, by));
                }
                numbers(&alignment.apply(&moved))
            };
            let (up, down) = (moved(step), moved(-step));
            for (axis, variance) in variances.iter_mut().enumerate() {
                *variance += ((up[axis] - down[axis]) / 2.0).powi(2);
            }
        }
        for (found, variance) in found.into_iter().zip(variances) {
            assert!((found / (3.0 * variance.sqrt()) - 1.0).abs() < 1e-3, "{found} {variance}");
        }
    }
}
