//! The path of a recording with ground truth.
//!
//! Poses are cut where they are farther apart than [`PathConfig::longest_gap_s`]. Within a stretch, position and quaternion (signs made
//! steady) are smoothed by a cubic over [`PathConfig::smoothing_s`] and then joined by a cubic spline of all seven numbers, the quaternion
//! brought to length 1 afterwards. Between poses 5 ms apart that is within 1e-9 rad of a rotation turning at 10 rad/s.

use super::config::PathConfig;
use super::path::{Bounds, CameraPath};
use super::smooth::smooth;
use super::spline::{CubicSpline, FEWEST};
use dpn_core::Stamp;
use dpn_core::config::{ConfigFaults, Validate};
use dpn_core::time::median_step_s;
use dpn_core::truth::{GroundTruth, TrueState};
use nalgebra::{Isometry3, Quaternion, SVector, Translation3, UnitQuaternion};
use thiserror::Error;

/// Position x, y, z and quaternion w, x, y, z.
type Pose = SVector<f64, 7>;

/// Why ground truth is no path.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum PathError {
    /// Settings out of their bounds.
    #[error(transparent)]
    Config(#[from] ConfigFaults),
    /// Nowhere enough poses close together.
    #[error(
        "no {FEWEST} of the {poses} true poses follow each other within {longest_gap_s} s; raise `path.longest_gap_s` (at most 10)"
    )]
    TooSparse {
        /// How many poses there are.
        poses: usize,
        /// The longest step allowed \[s\].
        longest_gap_s: f64,
    },
}

/// One stretch without a gap.
#[derive(Debug, Clone)]
struct Piece {
    first: Stamp,
    last: Stamp,
    spline: CubicSpline<7>,
}

/// A path through ground truth.
#[derive(Debug, Clone)]
pub struct RecordedPath {
    pieces: Vec<Piece>,
    bounds: Bounds,
}

impl RecordedPath {
    /// The path through `truth`. Stretches of fewer than four poses are dropped.
    ///
    /// # Errors
    /// Settings out of their bounds; no stretch of four poses.
    pub fn new(truth: &GroundTruth, config: &PathConfig) -> Result<Self, PathError> {
        config.validate()?;
        let states = truth.states();
        let window = window(states, config.smoothing_s);
        let close = |a: &TrueState, b: &TrueState| b.t.seconds_since(a.t) <= config.longest_gap_s;
        let mut pieces = Vec::new();
        let mut positions = Vec::new();
        for stretch in states.chunk_by(close) {
            if let Some((piece, poses)) = Piece::new(stretch, window) {
                pieces.push(piece);
                positions.extend(poses.iter().map(|pose| pose.fixed_rows::<3>(0).into_owned()));
            }
        }
        if pieces.is_empty() {
            return Err(PathError::TooSparse { poses: states.len(), longest_gap_s: config.longest_gap_s });
        }
        Ok(Self { pieces, bounds: Bounds::of(positions) })
    }
}

/// Poses in `seconds` at the median rate, made odd as the recordings' peers do it: 21 for .1 s at 200 Hz.
fn window(states: &[TrueState], seconds: f64) -> usize {
    let Some(median) = median_step_s(states.iter().map(|state| state.t)) else { return 1 };
    2 * ((seconds / median).round() as usize / 2) + 1
}

impl Piece {
    /// Also gives the smoothed poses.
    fn new(states: &[TrueState], window: usize) -> Option<(Self, Vec<Pose>)> {
        let (first, last) = (states.first()?.t, states.last()?.t);
        let times: Vec<f64> = states.iter().map(|state| state.t.seconds_since(first)).collect();
        let mut poses: Vec<Pose> = Vec::with_capacity(states.len());
        for state in states {
            let p = state.world_from_body.translation.vector;
            let mut q = *state.world_from_body.rotation.quaternion();
            // A quaternion and its negative are one rotation; neighbours must not jump from one to the other.
            if poses.last().is_some_and(|before| dot(before, &q) < 0.0) {
                q = -q;
            }
            poses.push(Pose::from([p.x, p.y, p.z, q.w, q.i, q.j, q.k]));
        }
        let poses = smooth(&times, &poses, window);
        let spline = CubicSpline::new(times, poses.clone())?;
        Some((Self { first, last, spline }, poses))
    }
}

fn dot(pose: &Pose, q: &Quaternion<f64>) -> f64 {
    pose[3] * q.w + pose[4] * q.i + pose[5] * q.j + pose[6] * q.k
}

impl CameraPath for RecordedPath {
    fn world_from_body(&self, t: Stamp) -> Option<Isometry3<f64>> {
        let after = self.pieces.partition_point(|piece| piece.first <= t);
        let piece = self.pieces.get(after.checked_sub(1)?).filter(|piece| t <= piece.last)?;
        let pose = piece.spline.at(t.seconds_since(piece.first));
        let rotation = UnitQuaternion::try_new(Quaternion::new(pose[3], pose[4], pose[5], pose[6]), 1e-6)?;
        Some(Isometry3::from_parts(Translation3::new(pose[0], pose[1], pose[2]), rotation))
    }

    fn pieces(&self) -> Vec<(Stamp, Stamp)> {
        self.pieces.iter().map(|piece| (piece.first, piece.last)).collect()
    }

    fn bounds(&self) -> Bounds {
        self.bounds
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tracks::AnalyticPath;
    use crate::{Flight, FlightConfig, simulate};
    use nalgebra::Vector3;
    use serde::Deserialize;

    fn truth(states: impl IntoIterator<Item = (i64, [f64; 3], [f64; 4])>) -> GroundTruth {
        let states = states.into_iter().map(|(t, p, [w, x, y, z])| TrueState {
            t: Stamp::from_ns(t),
            world_from_body: Isometry3::from_parts(
                Translation3::from(Vector3::from(p)),
                UnitQuaternion::new_normalize(Quaternion::new(w, x, y, z)),
            ),
            vel_in_world: None,
            biases: None,
        });
        GroundTruth::new(states.collect()).unwrap()
    }

    #[derive(Deserialize)]
    struct Golden {
        t_ns: Vec<i64>,
        position: Vec<[f64; 3]>,
        quaternion_wxyz: Vec<[f64; 4]>,
        at_ns: Vec<i64>,
        expected_position: Vec<[f64; 3]>,
        expected_quaternion_wxyz: Vec<[f64; 4]>,
    }

    #[test]
    fn smoothing_and_spline_agree_with_scipy() {
        let golden: Golden = dpn_testing::golden("recorded_path");
        let rows = golden.t_ns.iter().zip(golden.position).zip(golden.quaternion_wxyz);
        let truth = truth(rows.map(|((t, p), q)| (*t, p, q)));
        let path = RecordedPath::new(&truth, &PathConfig::default()).unwrap();
        for ((t, p), q) in
            golden.at_ns.iter().zip(golden.expected_position).zip(golden.expected_quaternion_wxyz)
        {
            let pose = path.world_from_body(Stamp::from_ns(*t)).unwrap();
            assert!((pose.translation.vector - Vector3::from(p)).norm() < 1e-11);
            let [w, x, y, z] = q;
            let expected = UnitQuaternion::new_unchecked(Quaternion::new(w, x, y, z));
            assert!(pose.rotation.angle_to(&expected) < 1e-7, "{}", pose.rotation.angle_to(&expected));
            let difference = (pose.rotation.coords - expected.coords).norm();
            let sum = (pose.rotation.coords + expected.coords).norm();
            assert!(difference.min(sum) < 1e-11, "{difference}");
        }
    }

    #[test]
    fn exact_poses_come_back_between_and_at_their_stamps() {
        let flight = simulate(Flight::RoomAggressive, 2, &FlightConfig::ideal()).unwrap();
        let exact = AnalyticPath::of(&flight);
        let truth = GroundTruth::new(flight.ground_truth.clone()).unwrap();
        let plain = PathConfig { smoothing_s: 0.0, ..PathConfig::default() };
        for (config, metres, radians) in [(plain, 1e-9, 1e-7), (PathConfig::default(), 3e-5, 3e-4)] {
            let path = RecordedPath::new(&truth, &config).unwrap();
            let (first, last) = path.pieces()[0];
            let (mut worst_p, mut worst_q) = (0.0_f64, 0.0_f64);
            for i in 0..2000 {
                let t = first.plus_seconds(last.seconds_since(first) * f64::from(i) / 2000.0);
                let (a, b) = (path.world_from_body(t).unwrap(), exact.world_from_body(t).unwrap());
                worst_p = worst_p.max((a.translation.vector - b.translation.vector).norm());
                worst_q = worst_q.max(a.rotation.angle_to(&b.rotation));
            }
            assert!(worst_p < metres && worst_q < radians, "{config:?}: {worst_p} m, {worst_q} rad");
        }
    }

    /// 100 Hz poses along x, lost from 1 s to 1.5 s and from 2 s to 2.06 s, the quaternion's sign flipped at every second row.
    fn torn() -> GroundTruth {
        let lost = |i: i64| (100..150).contains(&i) || (200..206).contains(&i);
        truth((0..300).filter(|i| !lost(*i)).map(|i| {
            let sign = if i % 2 == 0 { 1.0 } else { -1.0 };
            let angle = 0.004 * i as f64;
            (i * 10_000_000, [0.01 * i as f64, 0.0, 0.0], [sign * angle.cos(), 0.0, 0.0, sign * angle.sin()])
        }))
    }

    #[test]
    fn long_gaps_have_no_pose_short_ones_are_bridged_and_signs_do_not_matter() {
        let path = RecordedPath::new(&torn(), &PathConfig::default()).unwrap();
        let at = |ms: i64| path.world_from_body(Stamp::from_ns(ms * 1_000_000));
        assert_eq!(path.pieces().len(), 2);
        for (ms, there) in [(-1, false), (0, true), (990, true), (991, false), (1499, false), (1500, true)] {
            assert_eq!(at(ms).is_some(), there, "{ms} ms");
        }
        for ms in [3, 503, 987, 1503, 2033, 2987] {
            let pose = at(ms).unwrap();
            let t = ms as f64 * 1e-3;
            assert!((pose.translation.vector - Vector3::new(t, 0.0, 0.0)).norm() < 1e-9, "{ms} ms");
            assert!((pose.rotation.scaled_axis() - Vector3::new(0.0, 0.0, 0.8 * t)).norm() < 1e-6, "{ms} ms");
        }
        assert!(at(2991).is_none());
    }

    #[test]
    fn poses_too_far_apart_are_refused_with_the_gap_allowed() {
        let sparse = truth((0..9).map(|i| (i * 200_000_000, [0.0; 3], [1.0, 0.0, 0.0, 0.0])));
        let error = RecordedPath::new(&sparse, &PathConfig::default()).unwrap_err();
        assert_eq!(
            error.to_string(),
            "no 4 of the 9 true poses follow each other within 0.1 s; raise `path.longest_gap_s` (at most 10)"
        );
        let wide = PathConfig { longest_gap_s: 0.2, ..PathConfig::default() };
        assert!(RecordedPath::new(&sparse, &wide).is_ok());
        let bad = PathConfig { smoothing_s: f64::NAN, ..wide };
        assert!(matches!(RecordedPath::new(&sparse, &bad), Err(PathError::Config(_))));
    }
}
