//! Ground truth as a function of time.
//!
//! Rotations go along the geodesic between two samples (slerp); positions along the chord, or along a cubic whose slopes at the
//! samples are those of the parabola through a sample and its neighbours. Nothing reaches across a gap: where two samples lie further
//! apart than [`TruthOptions::max_gap_s`], there is no truth between them, and no slope looks over it. There is none before the first
//! and after the last sample either.

use super::error::{MetricsError, Trajectory, check, positive};
use dpn_core::Stamp;
use dpn_core::trajectory::StampedPose;
use dpn_core::truth::GroundTruth;
use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3};

/// How positions are interpolated; rotations always go along the geodesic.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Interpolation {
    /// Along the chord; the error is at most acceleration times the square of the samples' distance over 8 (at 200 Hz and 10 m/s^2, .03 mm).
    #[default]
    Linear,
    /// Along a cubic: for ground truth of 20 Hz and less (at 20 Hz the chord is off by 3 mm at 10 m/s^2).
    Cubic,
}

/// How ground truth is read between its samples.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TruthOptions {
    /// Samples further apart than this have no truth between them \[s\]; positive.
    pub max_gap_s: f64,
    /// How positions are interpolated.
    pub interpolation: Interpolation,
}

impl Default for TruthOptions {
    /// 0.1 s, linear.
    fn default() -> Self {
        Self { max_gap_s: 0.1, interpolation: Interpolation::Linear }
    }
}

/// Where an instant lies among the samples.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Cover {
    /// On the sample of this index.
    At(usize),
    /// Between the sample of this index and the next, which is near enough.
    After(usize),
    /// Between two samples too far apart.
    InGap,
    /// Before the first or after the last sample.
    Outside,
}

/// Ground truth as a function of time.
#[derive(Debug, Clone, Copy)]
pub struct TruthTrack<'a> {
    poses: &'a [StampedPose],
    options: TruthOptions,
}

impl<'a> TruthTrack<'a> {
    /// Checks `poses` and takes them.
    ///
    /// # Errors
    /// No pose; stamps that do not increase; values that are not finite; a `max_gap_s` that is not positive.
    pub fn new(poses: &'a [StampedPose], options: TruthOptions) -> Result<Self, MetricsError> {
        check(poses, Trajectory::Truth)?;
        positive("max_gap_s", options.max_gap_s)?;
        Ok(Self { poses, options })
    }

    /// Where `t` lies among the samples.
    pub fn cover(&self, t: Stamp) -> Cover {
        let next = self.poses.partition_point(|pose| pose.t <= t);
        if next == 0 {
            return Cover::Outside;
        }
        let at = next - 1;
        if self.poses[at].t == t {
            Cover::At(at)
        } else if next == self.poses.len() {
            Cover::Outside
        } else if self.joined(at) {
            Cover::After(at)
        } else {
            Cover::InGap
        }
    }

    /// `world_from_body` at `t`; `None` in a gap and outside.
    pub fn world_from_body(&self, t: Stamp) -> Option<Isometry3<f64>> {
        match self.cover(t) {
            Cover::At(i) => Some(self.poses[i].world_from_body),
            Cover::After(i) => Some(self.between(i, t)),
            Cover::InGap | Cover::Outside => None,
        }
    }

    /// Whether sample `i` and the next are near enough to interpolate between.
    fn joined(&self, i: usize) -> bool {
        self.step(i) <= self.options.max_gap_s
    }

    /// Seconds from sample `i` to the next.
    fn step(&self, i: usize) -> f64 {
        self.poses[i + 1].t.seconds_since(self.poses[i].t)
    }

    fn position(&self, i: usize) -> Vector3<f64> {
        self.poses[i].world_from_body.translation.vector
    }

    fn between(&self, i: usize, t: Stamp) -> Isometry3<f64> {
        let step = self.step(i);
        let share = t.seconds_since(self.poses[i].t) / step;
        let (a, b) = (self.position(i), self.position(i + 1));
        let position = match self.options.interpolation {
            Interpolation::Linear => a + (b - a) * share,
            Interpolation::Cubic => {
                let (out_of_a, into_b) = self.slopes(i);
                let left = 1.0 - share;
                a * (left * left * (1.0 + 2.0 * share))
                    + b * (share * share * (1.0 + 2.0 * left))
                    + (out_of_a * left - into_b * share) * (step * share * left)
            }
        };
        let (r_a, r_b) = (self.poses[i].world_from_body.rotation, self.poses[i + 1].world_from_body.rotation);
        let turn = (r_a.inverse() * r_b).scaled_axis() * share;
        Isometry3::from_parts(Translation3::from(position), r_a * UnitQuaternion::from_scaled_axis(turn))
    }

    /// Velocities at both ends of the interval after sample `i` \[m/s\].
    fn slopes(&self, i: usize) -> (Vector3<f64>, Vector3<f64>) {
        let chord = (self.position(i + 1) - self.position(i)) / self.step(i);
        let before = (i > 0 && self.joined(i - 1)).then(|| self.parabola(i));
        let after = (i + 2 < self.poses.len() && self.joined(i + 1)).then(|| self.parabola(i + 1));
        // Without a neighbour the curve is the parabola that has the other end's slope; without both, the chord.
        match (before, after) {
            (Some(a), Some(b)) => (a, b),
            (Some(a), None) => (a, chord * 2.0 - a),
            (None, Some(b)) => (chord * 2.0 - b, b),
            (None, None) => (chord, chord),
        }
    }

    /// Slope at sample `i` of the parabola through it and its two neighbours.
    fn parabola(&self, i: usize) -> Vector3<f64> {
        let (before, after) = (self.step(i - 1), self.step(i));
        let chord_before = (self.position(i) - self.position(i - 1)) / before;
        let chord_after = (self.position(i + 1) - self.position(i)) / after;
        (chord_before * after + chord_after * before) / (before + after)
    }
}

/// The poses of a ground-truth file, as trajectories are compared.
pub fn poses_of(truth: &GroundTruth) -> Vec<StampedPose> {
    let pose = |state: &dpn_core::truth::TrueState| StampedPose {
        t: state.t,
        world_from_body: state.world_from_body,
    };
    truth.states().iter().map(pose).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pose(t_s: f64, position: Vector3<f64>, turn: Vector3<f64>) -> StampedPose {
        StampedPose {
            t: Stamp::from_ns(0).plus_seconds(t_s),
            world_from_body: Isometry3::new(position, turn),
        }
    }

    fn cubic() -> TruthOptions {
        TruthOptions { interpolation: Interpolation::Cubic, ..TruthOptions::default() }
    }

    #[test]
    fn a_gap_has_no_truth_but_its_ends_have() {
        let at = |t| pose(t, Vector3::x() * t, Vector3::zeros());
        let poses = [at(0.0), at(0.1), at(0.25), at(0.3)];
        let track = TruthTrack::new(&poses, TruthOptions::default()).unwrap();
        let cover = |t: f64| track.cover(Stamp::from_ns(0).plus_seconds(t));
        assert_eq!(cover(-1e-9), Cover::Outside);
        assert_eq!(cover(0.05), Cover::After(0));
        assert_eq!(cover(0.1), Cover::At(1));
        assert_eq!(cover(0.1 + 1e-9), Cover::InGap);
        assert_eq!(cover(0.25), Cover::At(2));
        assert_eq!(cover(0.3), Cover::At(3));
        assert_eq!(cover(0.3 + 1e-9), Cover::Outside);
        assert!(track.world_from_body(Stamp::from_ns(200_000_000)).is_none());
    }

    #[test]
    fn a_constant_turn_and_a_parabola_come_out_exactly() {
        // Uneven samples, a quaternion of either sign, and a neighbour beyond a gap that would spoil a slope.
        let times = [0.0, 0.05, 0.08, 0.15, 0.6];
        let position = |t: f64| Vector3::new(1.0 + 2.0 * t - 3.0 * t * t, t * t, 0.5);
        let rate = Vector3::new(0.4, -1.0, 2.0);
        let mut poses = times.map(|t| pose(t, position(t), rate * t));
        poses[4].world_from_body.translation.vector = Vector3::repeat(99.0);
        let q = poses[1].world_from_body.rotation.into_inner();
        poses[1].world_from_body.rotation = UnitQuaternion::new_unchecked(-q);
        let track = TruthTrack::new(&poses, cubic()).unwrap();
        for ms in 0..=150 {
            let t = f64::from(ms) * 1e-3;
            let got = track.world_from_body(Stamp::from_ns(0).plus_seconds(t)).unwrap();
            assert!((got.translation.vector - position(t)).norm() < 1e-12, "{t} s: {got}");
            let turned = UnitQuaternion::from_scaled_axis(rate * t);
            assert!(got.rotation.angle_to(&turned) < 1e-12, "{t} s: {got}");
        }
    }

    #[test]
    fn halving_the_step_quarters_the_chords_error_and_does_better_on_the_cubic() {
        let position = |t: f64| Vector3::new((3.0 * t).sin(), (2.0 * t).cos(), 0.0);
        let worst = |step: f64, options: TruthOptions| {
            let poses: Vec<_> = (0..100)
                .map(|i| pose(f64::from(i) * step, position(f64::from(i) * step), Vector3::zeros()))
                .collect();
            let track = TruthTrack::new(&poses, options).unwrap();
            (10..400)
                .map(|i| f64::from(i) * step * 0.23)
                .map(|t| {
                    let t_ns = Stamp::from_ns(0).plus_seconds(t);
                    (track.world_from_body(t_ns).unwrap().translation.vector - position(t)).norm()
                })
                .fold(0.0, f64::max)
        };
        let order = |options| (worst(0.04, options) / worst(0.02, options)).log2();
        let linear = order(TruthOptions::default());
        assert!((linear - 2.0).abs() < 0.1, "{linear}");
        let cubic = order(cubic());
        assert!(cubic > 2.8, "{cubic}");
    }

    #[test]
    fn what_is_no_trajectory_is_refused() {
        let at = |t| pose(t, Vector3::zeros(), Vector3::zeros());
        let refused = |poses: &[StampedPose], max_gap_s| {
            let options = TruthOptions { max_gap_s, ..TruthOptions::default() };
            TruthTrack::new(poses, options).unwrap_err().to_string()
        };
        assert_eq!(refused(&[], 0.1), "the ground truth holds no pose");
        assert!(refused(&[at(1.0), at(1.0)], 0.1).contains("do not increase at pose 1 (1000000000 ns)"));
        let mut bad = at(0.0);
        bad.world_from_body.translation.vector.y = f64::NAN;
        assert!(refused(&[bad], 0.1).contains("pose 0 (0 ns) holds a value that is not finite"));
        assert!(refused(&[at(0.0)], f64::NAN).starts_with("`max_gap_s` is NaN; it must be positive"));
    }
}
