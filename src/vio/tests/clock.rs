//! A camera whose stamps are late or early by the IMU's clock: found, taken off, followed; one that is right is left alone.

use crate::flown::{Case, make, run};
use dpn_core::TrackFrame;
use dpn_sim::Flight;
use dpn_vio::EstimatorConfig;
use dpn_vio::estimator::{RunReport, Update};

/// Frames stamped later by `late_s`, and by `drift` of their time since the first.
fn runs(case: &Case, given_s: Option<f64>, late_s: f64, drift: f64) -> (Vec<Update>, RunReport) {
    let mut config = EstimatorConfig::default();
    config.front_end.time_offset_s = given_s;
    let first = case.frames[0].t;
    let stamped = |frame: &mut TrackFrame| {
        frame.t = frame.t.plus_seconds(late_s + drift * frame.t.seconds_since(first));
    };
    run(case, config, 1.0, |_| (), stamped)
}

/// By how much the ways over a second differ between two runs, root mean square \[m\]: where and how they began does not matter.
fn ways_apart(a: &[Update], b: &[Update]) -> f64 {
    let at = |updates: &[Update], k: usize| Some(updates[k].state?.world_from_body.translation.vector);
    let way = |updates: &[Update], k: usize| Some((at(updates, k + 10)? - at(updates, k)?).norm());
    let both = (0..a.len().min(b.len()) - 10).filter_map(|k| Some(way(a, k)? - way(b, k)?));
    let squares: Vec<f64> = both.map(|off| off * off).collect();
    (squares.iter().sum::<f64>() / squares.len() as f64).sqrt()
}

#[test]
fn a_clock_that_is_off_is_found_within_a_millisecond_and_costs_less() {
    let case = make(Flight::RoomMedium, 3, 0.0, 25.0);
    let (exact, _) = runs(&case, Some(0.0), 0.0, 0.0);
    let late_s = -0.1;
    let (found, report) = runs(&case, None, late_s, 0.0);
    let (wrong, _) = runs(&case, Some(0.0), late_s, 0.0);
    let (off, lost) = (ways_apart(&found, &exact), ways_apart(&wrong, &exact));
    println!("{late_s} s: {:?}, ways are {off:.3} m apart, {lost:.3} m as stamped", report.clock);
    assert!((report.clock.offset_s + late_s).abs() < 0.001, "{:?}", report.clock);
    let poses = report.poses as f64 / exact.iter().filter(|u| u.state.is_some()).count() as f64;
    // What began before the clock was known begins again: of nine seconds in the air that costs some.
    assert!(off < 0.8 * lost && poses > 0.85, "{off} m, {lost} m as stamped, {poses} of the poses");
    let stamps: Vec<_> = found.iter().filter(|u| u.state.is_some()).map(|u| u.t).collect();
    assert!(stamps.is_sorted_by(|a, b| a < b));
}

#[test]
fn a_clock_that_runs_fast_is_followed() {
    let case = make(Flight::RoomMedium, 3, 0.0, 40.0);
    let (_, report) = runs(&case, None, 0.02, 3e-3);
    let end = case.frames.last().unwrap().t.seconds_since(case.frames[0].t);
    let true_s = -(0.02 + 3e-3 * end);
    println!("{:?}, {true_s} s", report.clock);
    assert!((report.clock.offset_s - true_s).abs() < 0.01, "{:?}", report.clock);
}

#[test]
fn a_clock_that_is_right_changes_no_bit() {
    let case = make(Flight::RoomMedium, 5, 1.0, 20.0);
    let (given, _) = runs(&case, Some(0.0), 0.0, 0.0);
    let (found, report) = runs(&case, None, 0.0, 0.0);
    let states = |updates: &[Update]| updates.iter().map(|u| (u.t, u.state, u.phase)).collect::<Vec<_>>();
    assert!(states(&given) == states(&found), "{:?}", report.clock);
    let clock = report.clock;
    assert!(clock.found.is_none() && clock.seen_s.unwrap().abs() < 0.003, "{clock:?}");
}
