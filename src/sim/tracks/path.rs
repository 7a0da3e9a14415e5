//! Where the body is: the seam between tracks and any source of poses, and the exact path of a simulated flight.

use crate::simulate::SimulatedFlight;
use crate::trajectory::Trajectory;
use dpn_core::{SampleRate, Stamp};
use nalgebra::{Isometry3, Vector3};

/// A box, its axes along the world's \[m\].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bounds {
    /// The lowest x, y, z.
    pub low: Vector3<f64>,
    /// The highest x, y, z.
    pub high: Vector3<f64>,
}

impl Bounds {
    /// The smallest box around `points`; a point at the origin without any.
    pub(super) fn of(points: impl IntoIterator<Item = Vector3<f64>>) -> Self {
        let mut points = points.into_iter();
        let first = points.next().unwrap_or_default();
        points.fold(Self { low: first, high: first }, |bounds, point| Self {
            low: bounds.low.inf(&point),
            high: bounds.high.sup(&point),
        })
    }
}

/// Where a body is at any time of a recording.
pub trait CameraPath: Sync {
    /// Pose at `t`: points in the body's frame to the world's. `None` before the path begins, after it ends and in its gaps.
    fn world_from_body(&self, t: Stamp) -> Option<Isometry3<f64>>;

    /// First and last instant of every stretch without a gap, in order of time.
    fn pieces(&self) -> Vec<(Stamp, Stamp)>;

    /// Where it leads; the world is built around it.
    fn bounds(&self) -> Bounds;
}

/// The exact path of a trajectory with analytic derivatives.
#[derive(Debug, Clone)]
pub struct AnalyticPath {
    trajectory: Trajectory,
    start: Stamp,
    bounds: Bounds,
}

impl AnalyticPath {
    /// `trajectory` flown from `start` on.
    pub fn new(trajectory: Trajectory, start: Stamp) -> Self {
        // Between steps a body at 10 m/s^2 leaves the box by 30 micrometres.
        const STEP_S: f64 = 0.005;
        let steps = (trajectory.duration() / STEP_S).ceil() as usize;
        let bounds = Bounds::of((0..=steps).map(|i| trajectory.pose(STEP_S * i as f64).translation.vector));
        Self { trajectory, start, bounds }
    }

    /// The path of a simulated flight, on its recording's clock.
    pub fn of(flight: &SimulatedFlight) -> Self {
        let first = flight.recording.samples().first().map_or(Stamp::from_ns(0), |sample| sample.t);
        Self::new(flight.trajectory.clone(), first)
    }
}

impl CameraPath for AnalyticPath {
    fn world_from_body(&self, t: Stamp) -> Option<Isometry3<f64>> {
        let seconds = t.seconds_since(self.start);
        (0.0..=self.trajectory.duration()).contains(&seconds).then(|| self.trajectory.pose(seconds))
    }

    fn pieces(&self) -> Vec<(Stamp, Stamp)> {
        vec![(self.start, self.start.plus_seconds(self.trajectory.duration()))]
    }

    fn bounds(&self) -> Bounds {
        self.bounds
    }
}

/// Stamps of a camera at `rate` from a path's begin to its end, none in its gaps: for recordings that have no camera.
pub fn camera_stamps(path: &dyn CameraPath, rate: SampleRate) -> Vec<Stamp> {
    let pieces = path.pieces();
    let Some(&(first, _)) = pieces.first() else {
        return Vec::new();
    };
    let frame = |t: Stamp| t.seconds_since(first) * rate.hz();
    let stamps = pieces.iter().flat_map(|&(from, to)| {
        // A frame more at each end, for rounding; those outside are dropped.
        let (low, high) = ((frame(from) - 1.0).max(0.0) as u64, (frame(to) + 1.0).max(0.0) as u64);
        let stamps = (low..=high).map(move |i| first.plus_seconds(i as f64 * rate.period()));
        stamps.filter(move |t| (from..=to).contains(t))
    });
    stamps.collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Flight, FlightConfig, simulate};

    /// Two stretches with nothing between.
    struct Torn;

    impl CameraPath for Torn {
        fn world_from_body(&self, _: Stamp) -> Option<Isometry3<f64>> {
            None
        }

        fn pieces(&self) -> Vec<(Stamp, Stamp)> {
            let at = |ms: i64| Stamp::from_ns(ms * 1_000_000);
            vec![(at(7), at(157)), (at(i64::MAX / 2_000_000), at(i64::MAX / 2_000_000 + 60))]
        }

        fn bounds(&self) -> Bounds {
            Bounds::of([])
        }
    }

    #[test]
    fn made_stamps_are_on_one_grid_from_the_first_pose_to_the_last_and_none_is_in_a_gap() {
        let stamps = camera_stamps(&Torn, SampleRate::from_hz(20.0).unwrap());
        let early: Vec<_> = stamps.iter().map(|t| t.ns()).take_while(|t| *t < 1_000_000_000).collect();
        assert_eq!(early, [7_000_000, 57_000_000, 107_000_000, 157_000_000]);
        // A century later: one or two more, and no list of those between.
        assert!((1..=2).contains(&(stamps.len() - 4)), "{stamps:?}");
    }

    #[test]
    fn the_path_of_a_flight_is_its_ground_truth() {
        let flight = simulate(Flight::RoomWild, 3, &FlightConfig::ideal()).unwrap();
        let path = AnalyticPath::of(&flight);
        let bounds = path.bounds();
        for state in flight.ground_truth.iter().step_by(97) {
            let pose = path.world_from_body(state.t).unwrap();
            assert_eq!(pose, state.world_from_body);
            let p = pose.translation.vector;
            assert!((0..3).all(|i| bounds.low[i] - 0.05 <= p[i] && p[i] <= bounds.high[i] + 0.05));
        }
        let (first, last) = path.pieces()[0];
        assert!(path.world_from_body(first.plus_seconds(-1e-9)).is_none());
        assert!(path.world_from_body(last.plus_seconds(1e-3)).is_none());
    }
}
