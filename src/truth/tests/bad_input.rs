//! Gaps, jumps, a wrong clock, another frame, no ground truth at all: said, left out, or refused.

use crate::degrade::{Degradation, against};
use dpn_core::signal::stats::median;
use dpn_core::truth::{GroundTruth, TrueState};
use dpn_sim::{Flight, FlightConfig, SimulatedFlight, simulate};
use dpn_truth::{Reconciled, Trust, TruthConfig, TruthError, reconcile};
use nalgebra::{Translation3, UnitQuaternion, Vector3};

fn flight() -> SimulatedFlight {
    let mut config = FlightConfig::default();
    config.vibration.scale = 0.0;
    simulate(Flight::RoomMedium, 5, &config).unwrap()
}

/// Reconciles what `change` makes of degraded poses, given their seconds after the first.
fn changed(
    change: impl Fn(f64, TrueState) -> Option<TrueState>,
) -> (SimulatedFlight, Result<Reconciled, TruthError>) {
    let flight = flight();
    let published = Degradation { rate_hz: 50.0, ..Degradation::NOISE }.of(&flight, 1);
    let first = published.states()[0].t;
    let states = published.states().iter().filter_map(|s| change(s.t.seconds_since(first), *s));
    let published = GroundTruth::new(states.collect()).unwrap();
    let done = reconcile(&flight.recording, &published, &TruthConfig::default());
    (flight, done)
}

fn left_out(done: &Reconciled) -> Vec<(f64, f64)> {
    let spans = done.report.spans.iter().filter(|s| s.trust == Trust::LeftOut);
    spans.map(|s| (s.from_s, s.to_s)).collect()
}

#[test]
fn a_gap_too_long_to_bridge_is_left_out_and_said() {
    let (flight, done) = changed(|s, state| (!(20.0..35.0).contains(&s)).then_some(state));
    let done = done.unwrap();
    let spans = left_out(&done);
    assert!(spans.len() == 1 && spans[0].0 > 20.0 && spans[0].1 < 36.0, "{spans:?}");
    assert!(done.report.warnings.iter().any(|w| w.contains("nothing is written")));
    assert!(against(&done.truth, &flight).0 < 3e-3);
}

#[test]
fn poses_after_a_jump_of_the_frame_are_not_used() {
    let shifted = |s: f64, mut state: TrueState| {
        if s > 45.0 {
            state.world_from_body = Translation3::new(0.5, 0.0, 0.1) * state.world_from_body;
        }
        Some(state)
    };
    let (flight, done) = changed(shifted);
    let done = done.unwrap();
    assert!(
        done.report.warnings.iter().any(|w| w.contains("its frame is not that")),
        "{:?}",
        done.report.warnings
    );
    let (metres, ..) = against(&done.truth, &flight);
    // One of both frames it is, and never one between.
    let first = done.truth.states()[0].t.seconds_since(flight.recording.samples()[0].t);
    assert!(metres < 5e-3 || first > 40.0, "{metres}");
}

#[test]
fn a_clock_that_is_half_a_second_late_is_found() {
    let (flight, done) = changed(|_, mut state| {
        state.t = state.t.plus_seconds(0.5);
        Some(state)
    });
    let done = done.unwrap();
    assert!((done.report.delay_ms.value - 500.0).abs() < 0.2, "{:?}", done.report.delay_ms);
    assert!(against(&done.truth, &flight).0 < 3e-3);
    // Late, and steadily so.
    let (said, delays) = steps(&done);
    assert!(!said && delays.len() > 3 && delays.iter().all(|ms| (ms - 500.0).abs() < 2.0), "{delays:?}");
}

/// Whether a clock that does not keep time is said, and the delay of each window \[ms\].
fn steps(done: &Reconciled) -> (bool, Vec<f64>) {
    let said = done.report.warnings.iter().any(|w| w.contains("do not keep the IMU's time"));
    (said, done.report.window_delays.iter().map(|w| w.delay_ms).collect())
}

#[test]
fn stamps_that_step_or_drift_are_named() {
    let late = |by: fn(f64) -> f64| {
        let (_, done) = changed(|s, mut state| {
            state.t = state.t.plus_seconds(by(s));
            Some(state)
        });
        steps(&done.unwrap())
    };
    // An adjustment of one delay bends the motion where there are two: windows tell the way of it, not each its own.
    let rises = |delays: &[f64]| {
        let (early, late) = delays.split_at(delays.len() / 2);
        median(late) - median(early)
    };
    let (said, delays) = late(|s| if s > 30.0 { 0.03 } else { 0.0 });
    assert!(said && rises(&delays) > 15.0, "{delays:?}");
    let (said, delays) = late(|s| 0.0008 * s);
    assert!(said && rises(&delays) > 10.0, "{delays:?}");
}

#[test]
fn another_flight_s_poses_are_refused() {
    let other = simulate(Flight::RoomWild, 9, &FlightConfig::default()).unwrap();
    let published = Degradation::NOISE.of(&other, 1);
    let error = reconcile(&flight().recording, &published, &TruthConfig::default()).unwrap_err();
    assert!(matches!(error, TruthError::RatesDisagree { .. }), "{error}");
    assert!(error.to_string().contains("do not turn as the gyro does"));
}

#[test]
fn a_world_whose_z_axis_lies_is_set_upright() {
    let (flight, done) = changed(|_, mut state| {
        let lying = UnitQuaternion::from_scaled_axis(Vector3::x() * -std::f64::consts::FRAC_PI_2);
        state.world_from_body =
            nalgebra::Isometry3::from_parts(Translation3::identity(), lying) * state.world_from_body;
        Some(state)
    });
    let done = done.unwrap();
    assert!((done.report.tilt_deg.value - 90.0).abs() < 0.1, "{:?}", done.report.tilt_deg);
    assert!(against(&done.truth, &flight).0 < 5e-3);
}

#[test]
fn inverse_quaternions_are_refused() {
    let (_, done) = changed(|_, mut state| {
        state.world_from_body.rotation = state.world_from_body.rotation.inverse();
        Some(state)
    });
    let error = done.unwrap_err();
    assert!(
        matches!(
            error,
            TruthError::AxesDisagree { .. }
                | TruthError::NotGravity { .. }
                | TruthError::NothingTrusted { .. }
        ),
        "{error}"
    );
}

#[test]
fn too_little_is_refused_with_counts() {
    let (_, done) = changed(|s, state| (s < 1.0).then_some(state));
    let error = done.unwrap_err();
    assert!(matches!(error, TruthError::TooShort { least: 100, .. }), "{error}");
}
