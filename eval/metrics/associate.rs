//! Which true pose belongs to which estimated one.
//!
//! Interpolation is ours for judging: a nearest sample of a vehicle at 2 m/s and 200 Hz may be off by 5 mm. The nearest sample is what evo takes
//! unless told otherwise, so it is here as well. On the eleven EuRoC sequences, whose ground truth has a sample within .4 us of
//! every frame, the two differ by .05 mm of absolute error at most (V1_02, whose last frame is 126 ns behind its last truth, so
//! that interpolation leaves it out); figures printed elsewhere come from the nearest one (`eval/tests/ate_of_peers.rs`).

use super::error::{MetricsError, Trajectory, check};
use super::truth::{Cover, TruthTrack};
use dpn_core::Stamp;
use dpn_core::trajectory::StampedPose;
use nalgebra::Isometry3;

/// A true and an estimated pose that belong together.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PosePair {
    /// The estimate's stamp.
    pub t: Stamp,
    /// Index of the pose in the estimate, by which covariances are found.
    pub estimate_index: usize,
    /// The truth: points in the body frame to the truth's world.
    pub true_world_from_body: Isometry3<f64>,
    /// The estimate: points in the body frame to the estimate's world.
    pub est_world_from_body: Isometry3<f64>,
}

/// The pairs of two trajectories, in increasing time, and what found no partner.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Association {
    /// The pairs.
    pub pairs: Vec<PosePair>,
    /// Estimated poses before the first or after the last true one (by the nearest stamp: with none near enough there).
    pub outside: usize,
    /// Estimated poses in a gap of the truth (by the nearest stamp: with none near enough, between first and last).
    pub in_gaps: usize,
}

/// Pairs every estimated pose with the truth interpolated at its stamp.
///
/// # Errors
/// An estimate without poses, with stamps that do not increase or with values that are not finite.
pub fn associate_interpolated(
    truth: &TruthTrack<'_>,
    estimate: &[StampedPose],
) -> Result<Association, MetricsError> {
    check(estimate, Trajectory::Estimate)?;
    let mut found = Association::default();
    for (estimate_index, pose) in estimate.iter().enumerate() {
        match truth.world_from_body(pose.t) {
            Some(true_world_from_body) => found.pairs.push(PosePair {
                t: pose.t,
                estimate_index,
                true_world_from_body,
                est_world_from_body: pose.world_from_body,
            }),
            None if truth.cover(pose.t) == Cover::Outside => found.outside += 1,
            None => found.in_gaps += 1,
        }
    }
    Ok(found)
}

/// Pairs every pose of the trajectory with fewer poses (the estimate of two as long) with that of the nearest stamp in the other, at most
/// `max_diff_s` away; the earlier of two equally near. As in evo, a pose of the longer one may serve two of the shorter, and what is without a
/// partner is counted in the shorter.
///
/// # Errors
/// A trajectory without poses, with stamps that do not increase or with values that are not finite; a `max_diff_s` that is negative
/// or not finite.
pub fn associate_nearest(
    truth: &[StampedPose],
    estimate: &[StampedPose],
    max_diff_s: f64,
) -> Result<Association, MetricsError> {
    check(truth, Trajectory::Truth)?;
    check(estimate, Trajectory::Estimate)?;
    if !(max_diff_s.is_finite() && max_diff_s >= 0.0) {
        return Err(MetricsError::BadOption {
            name: "max_diff_s",
            value: max_diff_s,
            bound: "0 or more, and finite",
        });
    }
    let from_truth = truth.len() < estimate.len();
    let (shorter, longer) = if from_truth { (truth, estimate) } else { (estimate, truth) };
    let mut found = Association::default();
    for (index, pose) in shorter.iter().enumerate() {
        let next = longer.partition_point(|p| p.t <= pose.t);
        let away = |i: usize| pose.t.seconds_since(longer[i].t).abs();
        let before = next.checked_sub(1);
        let after = (next < longer.len()).then_some(next);
        let nearest = match (before, after) {
            (Some(a), Some(b)) if away(b) < away(a) => b,
            (Some(a), _) => a,
            (None, _) => 0,
        };
        if away(nearest) <= max_diff_s {
            let (true_index, estimate_index) = if from_truth { (index, nearest) } else { (nearest, index) };
            found.pairs.push(PosePair {
                t: estimate[estimate_index].t,
                estimate_index,
                true_world_from_body: truth[true_index].world_from_body,
                est_world_from_body: estimate[estimate_index].world_from_body,
            });
        } else if before.is_some() && after.is_some() {
            found.in_gaps += 1;
        } else {
            found.outside += 1;
        }
    }
    Ok(found)
}

#[cfg(test)]
mod tests {
    use super::super::truth::TruthOptions;
    use super::*;
    use nalgebra::Translation3;

    fn poses(times_ms: &[i64]) -> Vec<StampedPose> {
        let at = |&ms: &i64| StampedPose {
            t: Stamp::from_ns(ms * 1_000_000),
            world_from_body: Translation3::new(ms as f64, 0.0, 0.0).into(),
        };
        times_ms.iter().map(at).collect()
    }

    fn matched(found: &Association) -> Vec<(usize, f64)> {
        let row = |p: &PosePair| (p.estimate_index, p.true_world_from_body.translation.x);
        found.pairs.iter().map(row).collect()
    }

    #[test]
    fn interpolated_pairs_keep_the_estimates_index_and_count_the_rest() {
        let (truth, estimate) = (poses(&[0, 100, 300, 400]), poses(&[-1, 0, 40, 200, 300, 401]));
        let track = TruthTrack::new(&truth, TruthOptions::default()).unwrap();
        let found = associate_interpolated(&track, &estimate).unwrap();
        assert_eq!(matched(&found), [(1, 0.0), (2, 40.0), (4, 300.0)]);
        assert_eq!((found.outside, found.in_gaps), (2, 1));
    }

    #[test]
    fn the_nearest_stamp_is_taken_up_to_the_limit_and_the_earlier_of_two() {
        let (truth, estimate) = (poses(&[0, 10, 20, 90]), poses(&[-3, 4, 5, 6, 23, 24, 50, 94]));
        let found = associate_nearest(&truth, &estimate, 0.003).unwrap();
        assert_eq!(matched(&found), [(0, 0.0), (4, 20.0)]);
        assert_eq!((found.outside, found.in_gaps), (0, 2), "of the truth, which has fewer");
        let found = associate_nearest(&truth, &estimate, 0.005).unwrap();
        assert_eq!(matched(&found), [(0, 0.0), (3, 10.0), (4, 20.0), (7, 90.0)]);
        assert_eq!((found.outside, found.in_gaps), (0, 0));
        let found = associate_nearest(&estimate, &truth, 0.005).unwrap();
        assert_eq!(matched(&found), [(0, -3.0), (1, 6.0), (2, 23.0), (3, 94.0)]);
    }

    #[test]
    fn an_estimate_out_of_order_is_refused() {
        let (truth, estimate) = (poses(&[0, 10]), poses(&[4, 3]));
        let track = TruthTrack::new(&truth, TruthOptions::default()).unwrap();
        let expected = "the estimate's stamps do not increase at pose 1 (3000000 ns)";
        for error in [
            associate_interpolated(&track, &estimate).unwrap_err(),
            associate_nearest(&truth, &estimate, 0.01).unwrap_err(),
        ] {
            assert!(error.to_string().starts_with(expected), "{error}");
        }
        assert!(associate_nearest(&truth, &truth, -1.0).is_err());
    }
}
