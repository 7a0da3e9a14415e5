//! Normalised estimation error squared: whether a pose's error is as large as its covariance says.
//!
//! With the true pose moved into the estimate's world by the inverse of an [`Alignment`],
//!
//! e_p = p_true - p_est              (estimate's world),      nees_p = e_p^T P_pp^-1 e_p,
//! e_r = Log(R_est^T R_true)         (R <- R Exp(d), body),   nees_r = e_r^T P_rr^-1 e_r,
//!
//! each chi-square of 3 degrees of freedom, mean 3, where errors are normal with covariance P. Source: Y. Bar-Shalom, X. R. Li, T.
//! Kirubarajan, "Estimation with applications to tracking and navigation", 2001, sec. 5.4.
//!
//! # The gauge
//! Yaw and position of a visual-inertial estimator's world are not observable: it chooses them at its start, and its covariance is that
//! of the error *relative to the start*, as long as a tight prior on the first pose's yaw and position is carried along. So the estimate is
//! aligned in these four directions, and there alone: [`start_alignment`] takes the start's position exactly, and the yaw that leaves
//! the smallest rotation. Never align over the whole trajectory (ATE's way): that fits the errors that are to be judged, and
//! NEES comes out too small. Nor scale: it is observable. Tilt is observable too and stays an error from the start on.
//! The start itself has no error in four directions by construction and its covariance there is that of the prior: judge the poses after it
//! (`&pairs[1..]`). An estimator whose first pose is loose (deviations that the aligned error cannot have) reports that prior in every later
//! covariance, and NEES comes out too small; one that fixes the gauge elsewhere (say at the window's oldest pose) must
//! hand in covariances relative to the start. A simulation that begins at the true pose needs none of this: [`Alignment::identity`].

use super::align::Alignment;
use super::associate::PosePair;
use super::error::MetricsError;
use dpn_core::Stamp;
use nalgebra::{Isometry3, Matrix3, Matrix6, Translation3, UnitQuaternion, Vector3};

/// Where position and rotation stand in a pose's covariance.
const POSITION: usize = 0;
const ROTATION: usize = 3;

/// NEES of one pose.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PoseNees {
    /// When.
    pub t: Stamp,
    /// Of the position, 3 degrees of freedom.
    pub position: f64,
    /// Of the orientation, 3 degrees of freedom.
    pub orientation: f64,
}

/// The map from the estimate's world to the truth's that makes the positions of `start` agree, by a turn about z that leaves
/// the smallest angle between the orientations.
pub fn start_alignment(start: &PosePair) -> Alignment {
    // The twist about z of the whole turn; its swing, the tilt error, remains.
    let turn = start.true_world_from_body.rotation * start.est_world_from_body.rotation.inverse();
    let yaw = 2.0 * turn.coords.z.atan2(turn.coords.w);
    let rotation = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), yaw);
    let offset = start.true_world_from_body.translation.vector
        - rotation * start.est_world_from_body.translation.vector;
    Alignment {
        true_world_from_est_world: Isometry3::from_parts(Translation3::from(offset), rotation),
        scale: 1.0,
    }
}

/// NEES of every pair under `alignment`; its scale must be 1.
///
/// # Shapes
/// `covariances`: one a pose *of the estimate*, found by [`PosePair::estimate_index`]; rows and columns are position (estimate's
/// world \[m\]) and rotation (R <- R Exp(d), body \[rad\]). A covariance that is not quite symmetric counts by its symmetric part.
///
/// # Errors
/// A pair without covariance; one whose position or rotation block is not positive definite; a scale other than 1.
pub fn nees(
    pairs: &[PosePair],
    covariances: &[Matrix6<f64>],
    alignment: &Alignment,
) -> Result<Vec<PoseNees>, MetricsError> {
    if alignment.scale != 1.0 {
        return Err(MetricsError::BadOption {
            name: "alignment.scale",
            value: alignment.scale,
            bound: "1: a covariance is in the estimate's own metres",
        });
    }
    let est_world_from_true_world = alignment.true_world_from_est_world.inverse();
    let of_pair = |pair: &PosePair| {
        let index = pair.estimate_index;
        let covariance = covariances
            .get(index)
            .ok_or(MetricsError::CovarianceMissing { index, covariances: covariances.len() })?;
        let truth = est_world_from_true_world * pair.true_world_from_body;
        let estimate = &pair.est_world_from_body;
        let position = truth.translation.vector - estimate.translation.vector;
        let rotation = (estimate.rotation.inverse() * truth.rotation).scaled_axis();
        let square = |error, at| {
            mahalanobis_square(error, &covariance.fixed_view::<3, 3>(at, at).into_owned())
                .ok_or(MetricsError::NotPositiveDefinite { index, t_ns: pair.t.ns() })
        };
        Ok(PoseNees {
            t: pair.t,
            position: square(position, POSITION)?,
            orientation: square(rotation, ROTATION)?,
        })
    };
    pairs.iter().map(of_pair).collect()
}

/// e^T P^-1 e; `None` where P is not positive definite.
fn mahalanobis_square(error: Vector3<f64>, covariance: &Matrix3<f64>) -> Option<f64> {
    let symmetric = (covariance + covariance.transpose()) * 0.5;
    let factor = symmetric.cholesky()?;
    Some(factor.l().solve_lower_triangular(&error)?.norm_squared())
}

#[cfg(test)]
mod tests {
    use super::*;
    use dpn_core::random::Stream;
    use rand::Rng;
    use rand_distr::StandardNormal;

    fn normal3(rng: &mut impl Rng) -> Vector3<f64> {
        Vector3::from_fn(|_, _| rng.sample(StandardNormal))
    }

    /// A pose covariance whose axes are as uneven as a wrong frame needs to show.
    fn covariance() -> Matrix6<f64> {
        let l = Matrix6::from_fn(|r, c| match r.cmp(&c) {
            std::cmp::Ordering::Equal => [0.2, 0.02, 0.05, 0.004, 0.03, 0.01][r],
            std::cmp::Ordering::Greater => {
                0.003 * (r + 2 * c) as f64 * if (r + c) % 2 == 0 { 1.0 } else { -1.0 }
            }
            std::cmp::Ordering::Less => 0.0,
        });
        l * l.transpose()
    }

    /// Pairs whose estimates err by `covariance()`, in a world turned by 1.1 rad and moved; the first pair without error.
    fn sampled(count: usize, stream: &Stream) -> Vec<PosePair> {
        let mut rng = stream.rng();
        let true_world_from_est_world = Isometry3::new(Vector3::new(3.0, -8.0, 0.4), Vector3::z() * 1.1);
        let l = covariance().cholesky().unwrap().l();
        (0..count)
            .map(|i| {
                let truth = Isometry3::new(normal3(&mut rng) * 3.0, normal3(&mut rng));
                let truth_in_est = true_world_from_est_world.inverse() * truth;
                let z = nalgebra::Vector6::from_fn(|_, _| rng.sample::<f64, _>(StandardNormal));
                let d = if i == 0 { l * z * 0.0 } else { l * z };
                let (dp, dr) = (d.fixed_rows::<3>(0).into_owned(), d.fixed_rows::<3>(3).into_owned());
                // true = est (+) d
                let estimate = Isometry3::from_parts(
                    Translation3::from(truth_in_est.translation.vector - dp),
                    truth_in_est.rotation * UnitQuaternion::from_scaled_axis(dr).inverse(),
                );
                PosePair {
                    t: Stamp::from_ns(i as i64),
                    estimate_index: i,
                    true_world_from_body: truth,
                    est_world_from_body: estimate,
                }
            })
            .collect()
    }

    #[test]
    fn sampled_errors_have_mean_three_and_the_spread_of_chi_square() {
        let count = 20_000;
        let pairs = sampled(count + 1, &Stream::new(5).named("test").named("nees"));
        let alignment = start_alignment(&pairs[0]);
        let got = nees(&pairs[1..], &vec![covariance(); count + 1], &alignment).unwrap();
        for part in [|n: &PoseNees| n.position, |n: &PoseNees| n.orientation] {
            let values: Vec<f64> = got.iter().map(part).collect();
            let mean = values.iter().sum::<f64>() / count as f64;
            let variance = values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / count as f64;
            // Chi-square of 3: variance 6, fourth central moment 252; four deviations of mean and variance.
            assert!((mean - 3.0).abs() < 4.0 * (6.0 / count as f64).sqrt(), "{mean}");
            assert!((variance - 6.0).abs() < 4.0 * (216.0 / count as f64).sqrt(), "{variance}");
        }
    }

    #[test]
    fn the_start_takes_yaw_and_position_and_leaves_tilt() {
        let tilt = UnitQuaternion::from_scaled_axis(Vector3::new(0.02, -0.05, 0.0));
        let truth = Isometry3::new(Vector3::new(1.0, 2.0, 3.0), Vector3::new(0.5, -0.2, 2.9));
        for yaw in [-3.1, -1.0, 0.0, 0.7, 3.1] {
            // The estimate's world: turned by `yaw`, with a tilt error between.
            let turn = UnitQuaternion::from_scaled_axis(Vector3::z() * yaw);
            let est = Isometry3::from_parts(Translation3::new(9.0, 8.0, 7.0), turn * tilt * truth.rotation);
            let pair = PosePair {
                t: Stamp::from_ns(0),
                estimate_index: 0,
                true_world_from_body: truth,
                est_world_from_body: est,
            };
            let aligned = start_alignment(&pair).apply(&est);
            assert!((aligned.translation.vector - truth.translation.vector).norm() < 1e-12);
            assert!((aligned.rotation.angle_to(&truth.rotation) - tilt.angle()).abs() < 1e-12, "{yaw}");
        }
    }

    #[test]
    fn what_cannot_be_judged_is_named() {
        let pairs = sampled(3, &Stream::new(6).named("test"));
        let alignment = start_alignment(&pairs[0]);
        let error = nees(&pairs, &[covariance(); 2], &alignment).unwrap_err();
        assert!(error.to_string().starts_with("2 covariances; a pair belongs to pose 2"));
        let mut flat = covariance();
        flat.fixed_view_mut::<3, 3>(3, 3).fill(0.0);
        let error = nees(&pairs, &[covariance(), flat, covariance()], &alignment).unwrap_err();
        assert!(error.to_string().starts_with("the covariance of pose 1 (1 ns) is not positive"));
        let scaled = Alignment { scale: 1.1, ..alignment };
        assert!(nees(&pairs, &[covariance(); 3], &scaled).is_err());
        let nan = covariance() * f64::NAN;
        assert!(nees(&pairs, &[nan; 3], &alignment).is_err());
    }
}
