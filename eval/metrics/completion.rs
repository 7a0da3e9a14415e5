//! What share of the frames that could be judged has a pose.

use super::error::{MetricsError, Trajectory, check};
use super::truth::{Cover, TruthTrack};
use dpn_core::Stamp;
use dpn_core::trajectory::StampedPose;
use serde::{Deserialize, Serialize};

/// Frames with ground truth, and those of them with an estimated pose.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct Completion {
    /// Frames at which there is ground truth.
    pub covered: usize,
    /// Those of them at which there is a pose.
    pub with_pose: usize,
}

impl Completion {
    /// Their ratio, in \[0, 1\]; `None` where no frame has ground truth.
    pub fn share(&self) -> Option<f64> {
        (self.covered > 0).then(|| self.with_pose as f64 / self.covered as f64)
    }
}

/// Counts the `frames` (stamps of the camera, in any order) that ground truth covers, and those of them that have an estimated pose at
/// most `tolerance_s` away: half a frame's period or less; a microsecond does where stamps differ by rounding alone.
///
/// An estimator that gave no pose at all has an empty estimate, and completion 0. To count from initialisation on, pass the frames
/// from there on.
///
/// # Errors
/// An estimate whose stamps do not increase or whose values are not finite; a tolerance that is negative or not finite.
pub fn completion(
    frames: &[Stamp],
    truth: &TruthTrack<'_>,
    estimate: &[StampedPose],
    tolerance_s: f64,
) -> Result<Completion, MetricsError> {
    if !estimate.is_empty() {
        check(estimate, Trajectory::Estimate)?;
    }
    if !(tolerance_s.is_finite() && tolerance_s >= 0.0) {
        return Err(MetricsError::BadOption {
            name: "tolerance_s",
            value: tolerance_s,
            bound: "0 or more, and finite",
        });
    }
    let has_pose = |t: Stamp| {
        let next = estimate.partition_point(|pose| pose.t < t);
        let near = |pose: &StampedPose| pose.t.seconds_since(t).abs() <= tolerance_s;
        estimate.get(next).is_some_and(near) || next.checked_sub(1).is_some_and(|i| near(&estimate[i]))
    };
    let mut counts = Completion { covered: 0, with_pose: 0 };
    for &t in frames {
        if matches!(truth.cover(t), Cover::At(_) | Cover::After(_)) {
            counts.covered += 1;
            counts.with_pose += usize::from(has_pose(t));
        }
    }
    Ok(counts)
}

#[cfg(test)]
mod tests {
    use super::super::truth::TruthOptions;
    use super::*;
    use nalgebra::Isometry3;

    fn poses(times_ms: &[i64]) -> Vec<StampedPose> {
        let at = |&ms: &i64| StampedPose {
            t: Stamp::from_ns(ms * 1_000_000),
            world_from_body: Isometry3::identity(),
        };
        times_ms.iter().map(at).collect()
    }

    #[test]
    fn frames_without_truth_do_not_count_and_those_without_pose_count_against() {
        let truth = poses(&[0, 50, 100, 400, 450]);
        let track = TruthTrack::new(&truth, TruthOptions::default()).unwrap();
        // Outside, covered, covered, in the gap, covered, covered, outside.
        let frames = [-10, 10, 60, 200, 400, 430, 500].map(|ms| Stamp::from_ns(ms * 1_000_000));
        let counts = |estimate: &[i64], tolerance| {
            let got = completion(&frames, &track, &poses(estimate), tolerance).unwrap();
            (got.covered, got.with_pose)
        };
        assert_eq!(counts(&[60, 200, 401, 430], 0.001), (4, 3));
        assert_eq!(counts(&[60, 200, 401, 430], 0.0), (4, 2));
        assert_eq!(counts(&[9, 61, 399, 431], 0.001), (4, 4));
        assert_eq!(counts(&[], 0.001), (4, 0));
        let share = completion(&frames, &track, &poses(&[60]), 0.0).unwrap().share();
        assert_eq!(share, Some(0.25));
        assert_eq!(completion(&[], &track, &[], 0.0).unwrap().share(), None);
        assert!(completion(&frames, &track, &[], -1.0).is_err());
    }
}
