//! The whole estimator on a simulated flight: accuracy, determinism, and what it does when its input fails.

use dpn_core::camera::CameraModel;
use dpn_core::{ImuNoise, ImuSample, SampleRate, Stamp, TrackFrame};
use dpn_sim::tracks::{AnalyticPath, CameraSettings, TracksConfig, camera_stamps, simulate_tracks};
use dpn_sim::{Flight, FlightConfig, SimulatedFlight, simulate};
use dpn_vio::estimator::{FeedError, Phase, RestartReason, Update};
use dpn_vio::preint::NoisySample;
use dpn_vio::{Estimator, EstimatorConfig};
use std::sync::OnceLock;

/// A flight's first seconds and its tracks.
struct Case {
    flight: SimulatedFlight,
    frames: Vec<TrackFrame>,
}

/// Long enough to take off, start and fly.
const SECONDS: f64 = 32.0;
/// By then the estimator runs, if nothing fails.
const RUNNING: f64 = 20.0;

fn case() -> &'static Case {
    static CASE: OnceLock<Case> = OnceLock::new();
    CASE.get_or_init(|| {
        let flight = simulate(Flight::RoomMedium, 3, &FlightConfig::default()).unwrap();
        let path = AnalyticPath::of(&flight);
        let stamps = camera_stamps(&path, SampleRate::from_hz(20.0).unwrap());
        let mut frames = simulate_tracks(&TracksConfig::default(), &path, &stamps, 3).unwrap();
        let end = frames[0].t.plus_seconds(SECONDS);
        frames.retain(|f| f.t <= end);
        Case { flight, frames }
    })
}

fn estimator() -> Estimator {
    let body_from_cam = CameraSettings::default().body_from_cam().unwrap();
    Estimator::new(EstimatorConfig::default(), CameraModel::euroc_cam0(), body_from_cam, 1).unwrap()
}

fn noisy(sample: &ImuSample) -> NoisySample {
    NoisySample { sample: *sample, noise: ImuNoise::from_values([0.32; 3], [0.016; 3]).unwrap() }
}

/// Feeds what `samples` and `frames` leave of the case.
fn run(
    estimator: &mut Estimator,
    samples: impl Fn(&ImuSample) -> bool,
    frames: impl Fn(&TrackFrame) -> Option<TrackFrame>,
) -> Vec<Update> {
    let mut updates = Vec::new();
    let mut left = case().flight.recording.samples().iter().filter(|s| samples(s)).peekable();
    for frame in &case().frames {
        let Some(frame) = frames(frame) else { continue };
        let t = frame.t;
        estimator.feed_frame(frame).unwrap();
        while left.peek().is_some_and(|s| s.t <= t.plus_seconds(0.006)) {
            estimator.feed_imu(noisy(left.next().unwrap())).unwrap();
            while let Some(update) = estimator.next_update() {
                updates.push(update);
            }
        }
    }
    updates
}

fn seconds(t: Stamp) -> f64 {
    t.seconds_since(case().frames[0].t)
}

/// Largest distance between the path's shape and the truth's: distances from the first pose, which no alignment changes.
fn worst_shape_error(updates: &[Update]) -> f64 {
    let truth = |t: Stamp| {
        let states = &case().flight.ground_truth;
        let at = states.partition_point(|s| s.t < t).min(states.len() - 1);
        states[at].world_from_body.translation.vector
    };
    let posed: Vec<_> =
        updates.iter().filter_map(|u| Some((u.t, u.state?.world_from_body.translation.vector))).collect();
    let (first_t, first) = posed[0];
    posed
        .iter()
        .map(|(t, p)| ((p - first).norm() - (truth(*t) - truth(first_t)).norm()).abs())
        .fold(0.0, f64::max)
}

#[test]
fn a_flight_is_followed_and_two_runs_give_the_same_bits() {
    let one = run(&mut estimator(), |_| true, |f| Some(f.clone()));
    let posed = one.iter().filter(|u| u.state.is_some()).count();
    assert!(posed > 100, "{posed} poses of {}", one.len());
    assert!(one.iter().all(|u| !matches!(u.phase, Phase::Restarted(_))));
    assert!(worst_shape_error(&one) < 0.15, "{} m", worst_shape_error(&one));
    let two = run(&mut estimator(), |_| true, |f| Some(f.clone()));
    for (a, b) in one.iter().zip(&two) {
        assert_eq!(a.state, b.state);
    }
}

#[test]
fn a_hole_in_the_samples_is_a_restart_that_goes_on_from_the_last_pose() {
    let hole = |s: &ImuSample| !(RUNNING..RUNNING + 0.4).contains(&seconds(s.t));
    let updates = run(&mut estimator(), hole, |f| Some(f.clone()));
    let restarts: Vec<_> = updates
        .iter()
        .filter_map(|u| match u.phase {
            Phase::Restarted(reason) => Some((seconds(u.t), reason)),
            _ => None,
        })
        .collect();
    assert_eq!(restarts.len(), 1, "{restarts:?}");
    assert!(matches!(restarts[0].1, RestartReason::ImuGap { seconds } if (seconds - 0.4).abs() < 0.02));
    let last = updates.iter().rev().find(|u| seconds(u.t) < RUNNING && u.state.is_some()).unwrap();
    let next = updates.iter().find(|u| seconds(u.t) > RUNNING + 0.4 && u.state.is_some()).unwrap();
    let apart = |u: &Update| u.state.unwrap().world_from_body.translation.vector;
    // It goes on near where it ended, within what the flight moved meanwhile.
    assert!((apart(last) - apart(next)).norm() < 6.0 * (seconds(next.t) - seconds(last.t)).max(0.5));
    assert!(updates.last().unwrap().state.is_some());
}

#[test]
fn ten_seconds_without_tracks_are_starvation_and_no_pose_is_invented() {
    let blind = |f: &TrackFrame| {
        let mut frame = f.clone();
        if (RUNNING..RUNNING + 10.0).contains(&seconds(f.t)) {
            frame.tracks.clear();
        }
        Some(frame)
    };
    let updates = run(&mut estimator(), |_| true, blind);
    let starved =
        updates.iter().find(|u| matches!(u.phase, Phase::Restarted(RestartReason::Starved { .. }))).unwrap();
    assert!(seconds(starved.t) < RUNNING + 4.0, "at {:.1} s", seconds(starved.t));
    let invented = updates
        .iter()
        .filter(|u| u.t > starved.t && seconds(u.t) < RUNNING + 10.0 && u.state.is_some())
        .count();
    assert_eq!(invented, 0);
    assert!(updates.iter().flat_map(|u| u.state).all(|s| s.is_finite()));
}

#[test]
fn a_third_of_the_frames_lost_and_ids_that_jump_are_survived() {
    let mangled = |f: &TrackFrame| {
        let k = (seconds(f.t) * 10.0).round() as u64;
        let mut frame = f.clone();
        // Every three seconds the tracker forgets all it followed.
        frame.tracks.iter_mut().for_each(|t| t.id += 1_000_000 * (k / 30));
        (k % 3 != 1).then_some(frame)
    };
    let updates = run(&mut estimator(), |_| true, mangled);
    assert!(updates.iter().flat_map(|u| u.state).all(|s| s.is_finite()));
    assert!(updates.iter().filter(|u| u.state.is_some()).count() > 30);
}

#[test]
fn frames_before_the_first_sample_are_counted_and_what_goes_back_in_time_is_refused() {
    let mut estimator = estimator();
    let (first, second) = (&case().frames[0], &case().frames[1]);
    estimator.feed_frame(first.clone()).unwrap();
    assert!(matches!(estimator.feed_frame(first.clone()), Err(FeedError::FrameOutOfOrder { .. })));
    estimator.feed_frame(second.clone()).unwrap();
    let samples = case().flight.recording.samples();
    let late = samples.iter().position(|s| s.t > first.t).unwrap();
    for sample in &samples[late..late + 60] {
        estimator.feed_imu(noisy(sample)).unwrap();
    }
    assert!(matches!(estimator.feed_imu(noisy(&samples[late])), Err(FeedError::SampleOutOfOrder { .. })));
    let mut bad = samples[late + 60];
    bad.accel[1] = f64::NAN;
    assert!(matches!(estimator.feed_imu(noisy(&bad)), Err(FeedError::NotFinite { .. })));
    assert!(estimator.next_update().is_some());
    assert_eq!(estimator.report().skipped, 1);
}
