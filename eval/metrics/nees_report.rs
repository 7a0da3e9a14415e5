//! NEES over several runs, against the bounds of chi-square.
//!
//! At one instant the mean of N independent runs' NEES, times N, is chi-square of 3 N degrees of freedom; so it lies between
//! two known bounds with a known probability, and over instants its share between them should be that probability. Above the upper
//! bound the covariance is too small (overconfident), below the lower one too large.
//!
//! Errors of one run are alike from pose to pose, so the mean over runs *and* instants scatters by much less than chi-square of
//! all of them would have it, and by no more than one instant's: if it leaves the bounds of one instant, that is no chance.

use super::error::MetricsError;
use super::nees::PoseNees;
use crate::stats::chi_square_interval;
use dpn_core::Stamp;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// Degrees of freedom of each part.
const DOF: f64 = 3.0;

/// One part, position or orientation, over runs.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct NeesPart {
    /// Mean over all poses of all runs; 3 where the covariance is right.
    pub mean: f64,
    /// Share of instants whose mean over runs is between its bounds.
    pub share_inside: f64,
    /// Share of instants above the upper bound: covariance too small.
    pub share_above: f64,
}

/// NEES over several runs.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct NeesReport {
    /// Runs with at least one pose.
    pub runs: usize,
    /// Instants with at least one pose.
    pub instants: usize,
    /// Poses in all.
    pub poses: usize,
    /// Probability between the bounds, two-sided.
    pub confidence: f64,
    /// Bounds of the mean over all `runs` at one instant.
    pub bounds: [f64; 2],
    /// Of the position.
    pub position: NeesPart,
    /// Of the orientation.
    pub orientation: NeesPart,
}

/// Puts runs together instant by instant (same stamps); `None` where no run has a pose.
///
/// Runs may begin at different instants: each instant is held to the bounds of as many runs as have a pose there.
///
/// # Errors
/// A `confidence` outside (0, 1).
pub fn nees_report(runs: &[Vec<PoseNees>], confidence: f64) -> Result<Option<NeesReport>, MetricsError> {
    let mut instants: BTreeMap<Stamp, (usize, [f64; 2])> = BTreeMap::new();
    for pose in runs.iter().flatten() {
        let (count, sums) = instants.entry(pose.t).or_default();
        *count += 1;
        sums[0] += pose.position;
        sums[1] += pose.orientation;
    }
    let with_poses = runs.iter().filter(|run| !run.is_empty()).count();
    let of_runs = |count: usize| -> Result<[f64; 2], MetricsError> {
        let count = count as f64;
        Ok(chi_square_interval(DOF * count, confidence)?.map(|bound| bound / count))
    };
    // A confidence that is none is an error with no pose as well.
    let bounds = of_runs(with_poses.max(1))?;
    if instants.is_empty() {
        return Ok(None);
    }
    let mut bounds_of: BTreeMap<usize, [f64; 2]> = BTreeMap::new();
    let (mut totals, mut inside, mut above) = ([0.0; 2], [0_usize; 2], [0_usize; 2]);
    for (count, sums) in instants.values() {
        let [low, high] = match bounds_of.get(count) {
            Some(bounds) => *bounds,
            None => *bounds_of.entry(*count).or_insert(of_runs(*count)?),
        };
        for part in 0..2 {
            let mean = sums[part] / *count as f64;
            totals[part] += sums[part];
            inside[part] += usize::from((low..=high).contains(&mean));
            above[part] += usize::from(mean > high);
        }
    }
    let poses = instants.values().map(|(count, _)| count).sum::<usize>();
    let n = instants.len() as f64;
    let part = |i: usize| NeesPart {
        mean: totals[i] / poses as f64,
        share_inside: inside[i] as f64 / n,
        share_above: above[i] as f64 / n,
    };
    Ok(Some(NeesReport {
        runs: with_poses,
        instants: instants.len(),
        poses,
        confidence,
        bounds,
        position: part(0),
        orientation: part(1),
    }))
}

#[cfg(test)]
mod tests {
    use super::*;
    use dpn_core::random::Stream;
    use rand_distr::{ChiSquared, Distribution};

    fn sampled(runs: u64, instants: i64, factor: f64) -> Vec<Vec<PoseNees>> {
        let chi = ChiSquared::new(3.0).unwrap();
        let stream = Stream::new(8).named("test").named("nees_report");
        (0..runs)
            .map(|run| {
                let mut rng = stream.index(run).rng();
                (0..instants)
                    .map(|t| PoseNees {
                        t: Stamp::from_ns(t),
                        position: chi.sample(&mut rng),
                        orientation: factor * chi.sample(&mut rng),
                    })
                    .collect()
            })
            .collect()
    }

    #[test]
    fn a_right_covariance_is_inside_as_often_as_it_should_and_one_too_small_by_half_is_not() {
        let report = nees_report(&sampled(50, 2000, 2.0), 0.95).unwrap().unwrap();
        // chi2.ppf([.025, .975], 150) / 50 by scipy.
        let expected = [2.359_690_31, 3.716_008_94];
        for (got, expected) in report.bounds.iter().zip(expected) {
            assert!((got - expected).abs() < 1e-7, "{:?}", report.bounds);
        }
        // Four deviations of a share of 2000.
        assert!((report.position.share_inside - 0.95).abs() < 4.0 * (0.95 * 0.05 / 2000.0_f64).sqrt());
        assert!((report.position.mean - 3.0).abs() < 4.0 * (6.0 / 100_000.0_f64).sqrt());
        assert!(report.orientation.share_above > 0.99, "{report:?}");
        assert!((report.orientation.mean - 6.0).abs() < 4.0 * (24.0 / 100_000.0_f64).sqrt());
        assert_eq!((report.runs, report.instants, report.poses), (50, 2000, 100_000));
    }

    #[test]
    fn runs_that_begin_later_count_where_they_have_poses() {
        let mut runs = sampled(20, 1500, 1.0);
        for (i, run) in runs.iter_mut().enumerate() {
            run.drain(..i * 50);
        }
        runs.push(Vec::new());
        let report = nees_report(&runs, 0.9).unwrap().unwrap();
        assert_eq!((report.runs, report.instants), (20, 1500));
        for part in [report.position, report.orientation] {
            assert!((part.share_inside - 0.9).abs() < 4.0 * (0.9 * 0.1 / 1500.0_f64).sqrt(), "{part:?}");
        }
    }

    #[test]
    fn no_pose_is_none_and_a_bad_confidence_an_error() {
        assert_eq!(nees_report(&[Vec::new()], 0.95).unwrap(), None);
        assert!(nees_report(&[], 1.0).is_err());
    }
}
