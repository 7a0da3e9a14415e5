//! Absolute trajectory error: how far the aligned estimate is from the truth, pose by pose.
//!
//! Translation: |p_true - p_aligned| \[m\]. Rotation: the angle of R_aligned^T R_true \[rad\]. The alignment comes from the positions alone
//! ([`align`]), so that the rotation error holds tilt and what yaw the positions do not show.
//! Source: J. Sturm et al., "A benchmark for the evaluation of RGB-D SLAM systems", IROS 2012, sec. VII; Z. Zhang and D. Scaramuzza, "A
//! tutorial on quantitative trajectory evaluation for visual(-inertial) odometry", IROS 2018, sec. IV.

use super::align::{Alignment, AlignmentKind, align};
use super::associate::PosePair;
use super::error::MetricsError;
use super::summary::ErrorSummary;

/// Absolute errors after one alignment.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ate {
    /// What was moved.
    pub alignment: Alignment,
    /// Distances \[m\]; `rmse` is what tables call ATE.
    pub translation: ErrorSummary,
    /// Angles \[rad\].
    pub rotation: ErrorSummary,
}

/// Absolute errors after the alignment of `kind` over all pairs.
///
/// # Errors
/// As [`align`].
pub fn ate(pairs: &[PosePair], kind: AlignmentKind) -> Result<Ate, MetricsError> {
    ate_aligned(pairs, align(pairs, kind)?)
}

/// Absolute errors after a given alignment, for example [`Alignment::identity`].
///
/// # Errors
/// No pair.
pub(super) fn ate_aligned(pairs: &[PosePair], alignment: Alignment) -> Result<Ate, MetricsError> {
    let (distances, angles): (Vec<f64>, Vec<f64>) = pairs
        .iter()
        .map(|pair| {
            let aligned = alignment.apply(&pair.est_world_from_body);
            let off = pair.true_world_from_body.translation.vector - aligned.translation.vector;
            let angle = aligned.rotation.angle_to(&pair.true_world_from_body.rotation);
            (off.norm(), angle)
        })
        .unzip();
    match (ErrorSummary::of(&distances), ErrorSummary::of(&angles)) {
        (Some(translation), Some(rotation)) => Ok(Ate { alignment, translation, rotation }),
        _ => Err(MetricsError::TooFewPairs { what: "an absolute error", needed: 1, found: 0 }),
    }
}

/// The scale that Sim(3) alignment finds, minus 1: metres of the truth to one of the estimate. Above 0 the estimate is too small.
///
/// # Errors
/// As [`align`].
pub fn scale_error(pairs: &[PosePair]) -> Result<f64, MetricsError> {
    Ok(align(pairs, AlignmentKind::Sim3)?.scale - 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use dpn_core::Stamp;
    use nalgebra::{Isometry3, Vector3};

    fn pair(estimate_index: usize, truth: Isometry3<f64>, est: Isometry3<f64>) -> PosePair {
        PosePair {
            t: Stamp::from_ns(estimate_index as i64),
            estimate_index,
            true_world_from_body: truth,
            est_world_from_body: est,
        }
    }

    #[test]
    fn a_square_of_two_metres_seen_half_as_large() {
        let corners = [(1.0, 1.0), (-1.0, 1.0), (-1.0, -1.0), (1.0, -1.0)];
        let tilt = Vector3::new(0.0, 0.0, 0.25);
        let pairs: Vec<_> = corners
            .iter()
            .enumerate()
            .map(|(i, &(x, y))| {
                let truth = Isometry3::new(Vector3::new(x, y, 5.0), Vector3::zeros());
                pair(i, truth, Isometry3::new(Vector3::new(x / 2.0, y / 2.0, 0.0), tilt))
            })
            .collect();
        let se3 = ate(&pairs, AlignmentKind::Se3).unwrap();
        assert!((se3.translation.rmse - 0.5 * 2.0_f64.sqrt()).abs() < 1e-12);
        assert!((se3.rotation.max - 0.25).abs() < 1e-12);
        assert!((scale_error(&pairs).unwrap() - 1.0).abs() < 1e-12);
        assert!(ate(&pairs, AlignmentKind::Sim3).unwrap().translation.max < 1e-12);
        let none = ate_aligned(&pairs, Alignment::identity()).unwrap();
        assert!((none.translation.mean - 25.5_f64.sqrt()).abs() < 1e-12);
        assert!(ate_aligned(&[], Alignment::identity()).is_err());
    }
}
