//! Relative pose error: how far the estimate drifts over a stretch of given length or time.
//!
//! For a stretch from pose i to pose j, with true poses Q and estimated ones P (both `world_from_body`),
//!
//! E = (Q_i^-1 Q_j)^-1 (P_i^-1 P_j),
//!
//! whose translation \[m\] and angle \[rad\] are the errors. No alignment enters: E does not change when either world is moved.
//!
//! [`rpe`] takes the stretches of `--all_pairs --pairs_from_reference`, [`rpe_by`] those of any [`RpeSpec`]. Path length is along the positions of
//! the pairs; across a gap it is the chord.
//! Source: Sturm et al., IROS 2012, sec. VII; A. Geiger et al., "Are we ready for autonomous driving?", CVPR 2012 (by distance).

use super::associate::PosePair;
use super::error::{MetricsError, positive};
use super::rpe_spec::{RpeSpec, RpeStep, StretchesOn};
use super::summary::ErrorSummary;
use nalgebra::Isometry3;

/// How much the length of a stretch may differ from the step, relative to it, unless the caller says otherwise.
pub const RPE_TOLERANCE: f64 = 0.1;

/// Relative errors over stretches of one length.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rpe {
    /// The length asked for.
    pub step: RpeStep,
    /// Translations of E \[m\].
    pub translation: ErrorSummary,
    /// Angles of E \[rad\].
    pub rotation: ErrorSummary,
}

/// Relative errors over stretches of length `step` along the true path, one from every pose, give or take `tolerance` times it ([`RPE_TOLERANCE`]); `None` where no stretch is that long.
///
/// # Errors
/// A step that is not positive and finite, a tolerance outside \[0, 1).
pub fn rpe(pairs: &[PosePair], step: RpeStep, tolerance: f64) -> Result<Option<Rpe>, MetricsError> {
    rpe_by(pairs, &RpeSpec { step, all_pairs: true, on: StretchesOn::Reference }, tolerance)
}

/// Relative errors over the stretches of `spec`; `tolerance` as in [`rpe`], and of use only where stretches begin at every pose.
///
/// # Errors
/// As [`rpe`]; degrees beyond 180.
pub fn rpe_by(pairs: &[PosePair], spec: &RpeSpec, tolerance: f64) -> Result<Option<Rpe>, MetricsError> {
    let (translations, rotations): (Vec<f64>, Vec<f64>) = stretches_of(pairs, spec, tolerance)?
        .into_iter()
        .map(|(i, j)| {
            let error = relative_error(&pairs[i], &pairs[j]);
            (error.translation.vector.norm(), error.rotation.angle())
        })
        .unzip();
    let summaries = ErrorSummary::of(&translations).zip(ErrorSummary::of(&rotations));
    Ok(summaries.map(|(translation, rotation)| Rpe { step: spec.step, translation, rotation }))
}

/// First and last pair of every stretch of `spec`.
///
/// # Errors
/// As [`rpe_by`].
pub(super) fn stretches_of(
    pairs: &[PosePair],
    spec: &RpeSpec,
    tolerance: f64,
) -> Result<Vec<(usize, usize)>, MetricsError> {
    positive("step", spec.length())?;
    if !(0.0..1.0).contains(&tolerance) {
        return Err(MetricsError::BadOption {
            name: "tolerance",
            value: tolerance,
            bound: "0 or more and below 1",
        });
    }
    if let RpeStep::Degrees(value @ 180.0..) = spec.step {
        return Err(MetricsError::BadOption { name: "step", value, bound: "below 180 degrees" });
    }
    Ok(stretches(pairs, spec, tolerance))
}

/// First and last pose of every stretch, as evo 1.38 chooses them (`core/filters.py`).
fn stretches(pairs: &[PosePair], spec: &RpeSpec, tolerance: f64) -> Vec<(usize, usize)> {
    let length = spec.length();
    let poses: Vec<&Isometry3<f64>> = pairs.iter().map(|pair| spec.on.pose(pair)).collect();
    if let (RpeStep::Degrees(degrees), true) = (spec.step, spec.all_pairs) {
        let within = (1.0 - tolerance) * degrees..=(1.0 + tolerance) * degrees;
        let turn = |i: usize, j: usize| poses[i].rotation.angle_to(&poses[j].rotation).to_degrees();
        let from = |i: usize| (i + 1..poses.len()).map(move |j| (i, j));
        return (0..poses.len()).flat_map(from).filter(|&(i, j)| within.contains(&turn(i, j))).collect();
    }
    let steps = pairs.windows(2).zip(poses.windows(2)).map(|(pair, pose)| match spec.step {
        RpeStep::Metres(_) => (pose[1].translation.vector - pose[0].translation.vector).norm(),
        RpeStep::Seconds(_) => pair[1].t.seconds_since(pair[0].t),
        RpeStep::Frames(_) => 1.0,
        RpeStep::Degrees(_) => pose[0].rotation.angle_to(&pose[1].rotation).to_degrees(),
    });
    if !spec.all_pairs {
        let (mut first, mut sum, mut found) = (0, 0.0, Vec::new());
        for (i, step) in steps.enumerate() {
            sum += step;
            if sum >= length {
                found.push((first, i + 1));
                (first, sum) = (i + 1, 0.0);
            }
        }
        return found;
    }
    let along: Vec<f64> = match spec.step {
        RpeStep::Seconds(_) => pairs.iter().map(|p| p.t.seconds_since(pairs[0].t)).collect(),
        _ => std::iter::once(0.0)
            .chain(steps.scan(0.0, |sum, step| {
                *sum += step;
                Some(*sum)
            }))
            .collect(),
    };
    let slack = match spec.step {
        RpeStep::Frames(_) => 0.0,
        _ => tolerance * length,
    };
    (0..pairs.len()).filter_map(|i| Some((i, end_of(&along, i, length, slack)?))).collect()
}

/// E of the module's opening.
pub(super) fn relative_error(i: &PosePair, j: &PosePair) -> Isometry3<f64> {
    let true_i_from_j = i.true_world_from_body.inv_mul(&j.true_world_from_body);
    let est_i_from_j = i.est_world_from_body.inv_mul(&j.est_world_from_body);
    true_i_from_j.inv_mul(&est_i_from_j)
}

/// The pose after `i` whose place `along` is nearest to `length` beyond that of `i`, the earliest of several, if it misses by at most `slack`.
fn end_of(along: &[f64], i: usize, length: f64, slack: f64) -> Option<usize> {
    let rest = &along[i + 1..];
    let miss = |k: usize| (rest[k] - along[i] - length).abs();
    let above = rest.partition_point(|s| s - along[i] < length);
    // The earliest pose at the place just below: a vehicle at rest stays there for many.
    let below = above.checked_sub(1).map(|last| rest.partition_point(|s| *s < rest[last]));
    let nearest = match below {
        Some(below) if above == rest.len() || miss(below) <= miss(above) => below,
        _ if above < rest.len() => above,
        _ => return None,
    };
    (miss(nearest) <= slack).then_some(i + 1 + nearest)
}

#[cfg(test)]
mod tests {
    use super::*;
    use dpn_core::Stamp;
    use nalgebra::{Isometry3, Vector3};

    fn straight(times_ms: &[i64], speed: f64, est_speed: f64) -> Vec<PosePair> {
        let pair = |(i, &ms): (usize, &i64)| {
            let at = |speed: f64, yaw: f64| {
                Isometry3::new(Vector3::x() * speed * ms as f64 * 1e-3, Vector3::z() * yaw)
            };
            PosePair {
                t: Stamp::from_ns(ms * 1_000_000),
                estimate_index: i,
                true_world_from_body: at(speed, 0.0),
                est_world_from_body: at(est_speed, 0.01 * ms as f64 * 1e-3),
            }
        };
        times_ms.iter().enumerate().map(pair).collect()
    }

    #[test]
    fn a_steady_drift_is_the_same_in_every_unit() {
        let times: Vec<i64> = (0..100).map(|i| i * 100).collect();
        let pairs = straight(&times, 2.0, 2.0);
        let by_time = rpe(&pairs, RpeStep::Seconds(1.0), 0.05).unwrap().unwrap();
        let by_path = rpe(&pairs, RpeStep::Metres(2.0), 0.05).unwrap().unwrap();
        assert_eq!(by_time.translation.count, 90);
        assert_eq!(by_path.rotation.count, 90);
        for got in [by_time, by_path] {
            assert!((got.rotation.rmse - 0.01).abs() < 1e-9, "{got:?}");
        }
        let expected = 0.01_f64.to_degrees() / 2.0;
        assert!((by_path.rotation.rmse.to_degrees() / 2.0 - expected).abs() < 1e-9);
    }

    #[test]
    fn too_fast_by_a_tenth_is_ten_per_cent() {
        let times: Vec<i64> = (0..50).map(|i| i * 100).collect();
        let mut pairs = straight(&times, 1.0, 1.1);
        for pair in &mut pairs {
            pair.est_world_from_body.rotation = nalgebra::UnitQuaternion::identity();
        }
        let got = rpe(&pairs, RpeStep::Metres(3.0), 0.02).unwrap().unwrap();
        assert!((100.0 * got.translation.rmse / 3.0 - 10.0).abs() < 1e-9);
        assert!(got.rotation.max < 1e-12);
    }

    #[test]
    fn stretches_end_at_the_nearest_pose_within_the_tolerance() {
        let along = [0.0, 0.5, 0.97, 0.97, 1.05, 3.0];
        assert_eq!(end_of(&along, 0, 1.0, 0.1), Some(2));
        assert_eq!(end_of(&along, 0, 1.0, 0.02), None);
        assert_eq!(end_of(&along, 1, 2.4, 0.2), Some(5));
        assert_eq!(end_of(&along, 2, 5.0, 1.0), None);
        assert_eq!(end_of(&along, 5, 1.0, 0.9), None);
    }

    #[test]
    fn consecutive_stretches_begin_where_the_one_before_ended() {
        let pairs = straight(&[0, 400, 1005, 1920, 2010, 3050], 1.0, 1.0);
        let of = |text: &str| stretches(&pairs, &text.parse().unwrap(), 0.1);
        assert_eq!(of("1m"), [(0, 2), (2, 4), (4, 5)]);
        assert_eq!(of("1s"), of("1m"));
        assert_eq!(of("2f"), [(0, 2), (2, 4)]);
        assert_eq!(of("2f:all_pairs"), [(0, 2), (1, 3), (2, 4), (3, 5)]);
        assert_eq!(of("1m:all_pairs"), [(0, 2), (2, 4), (4, 5)]);
        // The estimate turns by .01 rad a second, the truth not at all.
        let degree = 0.01_f64.to_degrees();
        assert_eq!(of(&format!("{degree}deg")), of("1m"));
        assert_eq!(of(&format!("{degree}deg:all_pairs")), [(0, 2), (2, 3), (2, 4), (4, 5)]);
        assert_eq!(of("0.1deg:pairs_from_reference"), []);
    }

    #[test]
    fn no_stretch_is_no_error_but_a_bad_step_is_one() {
        let pairs = straight(&[0, 100, 200], 1.0, 1.0);
        assert_eq!(rpe(&pairs, RpeStep::Metres(5.0), 0.1).unwrap(), None);
        assert_eq!(rpe(&[], RpeStep::Seconds(1.0), 0.1).unwrap(), None);
        assert!(rpe(&pairs, RpeStep::Seconds(0.0), 0.1).is_err());
        assert!(rpe(&pairs, RpeStep::Seconds(1.0), 1.0).is_err());
        let turned = RpeSpec { step: RpeStep::Degrees(180.0), all_pairs: true, on: StretchesOn::Estimate };
        assert!(rpe_by(&pairs, &turned, 0.1).is_err());
    }
}
