//! Exact ground truth, degraded as published ones are, and reconciled: back to the exact one.

use crate::degrade::{Degradation, against};
use dpn_sim::{Flight, FlightConfig, simulate};
use dpn_truth::{TruthConfig, reconcile};

/// A flight without vibration: the simulated rotors' alias reaches down to zero frequency, where no reconciliation can see it.
fn config() -> FlightConfig {
    let mut config = FlightConfig::default();
    config.vibration.scale = 0.0;
    config
}

/// Root mean square an axis \[mm\], rotation \[deg\] and the error of the delay \[ms\].
fn reached(name: &str) -> (f64, f64, f64) {
    let flight = simulate(Flight::RoomMedium, 5, &config()).unwrap();
    let (_, degradation) = Degradation::all().into_iter().find(|(n, _)| *n == name).unwrap();
    let done = reconcile(&flight.recording, &degradation.of(&flight, 1), &TruthConfig::default()).unwrap();
    let (metres, degrees, share) = against(&done.truth, &flight);
    assert!(share > 0.96, "{name}: {share} of the flight");
    assert!(done.report.settled);
    let delay = done.report.delay_ms.value - 1e3 * degradation.delay_s;
    (1e3 * metres / 3f64.sqrt(), degrees, delay.abs())
}

#[test]
fn noise_lateness_and_sparse_poses_come_back() {
    for name in ["noise", "late", "20 Hz"] {
        let (millimetres, degrees, delay) = reached(name);
        assert!(
            millimetres < 1.0 && degrees < 0.05 && delay < 0.1,
            "{name}: {millimetres} mm {degrees} deg {delay} ms"
        );
    }
}

#[test]
fn turned_frames_and_smoothing_come_back() {
    for name in ["turned", "smoothed"] {
        let (millimetres, degrees, delay) = reached(name);
        assert!(
            millimetres < 1.0 && degrees < 0.05 && delay < 0.1,
            "{name}: {millimetres} mm {degrees} deg {delay} ms"
        );
    }
}

#[test]
fn gaps_of_three_seconds_are_bridged_as_well_as_the_samples_allow() {
    // A bridge of 3 s by samples of .09 m/s^2 is known to sqrt(q T^3 / 192) = 2.4 mm in its middle.
    let (millimetres, degrees, _) = reached("gaps");
    assert!(millimetres < 1.5 && degrees < 0.05, "{millimetres} mm {degrees} deg");
}

/// Rates of a noisy attitude at 200 Hz are larger than those of a slow flight; they turn with the gyro all the same.
#[test]
fn a_slow_flight_under_a_noisy_attitude_is_mounted() {
    let flight = simulate(Flight::HallSlow, 5, &config()).unwrap();
    let published = Degradation::NOISE.of(&flight, 1);
    let done = reconcile(&flight.recording, &published, &TruthConfig::default()).unwrap();
    let (_, degrees, share) = against(&done.truth, &flight);
    assert!(degrees < 0.05 && share > 0.96, "{degrees} deg, {share} of the flight");
}

#[test]
fn twice_the_same_is_the_same_to_the_last_bit() {
    let flight = simulate(Flight::Hover, 2, &config()).unwrap();
    let published = Degradation { rate_hz: 50.0, ..Degradation::NOISE }.of(&flight, 3);
    let run = || reconcile(&flight.recording, &published, &TruthConfig::default()).unwrap();
    let (first, second) = (run(), run());
    assert_eq!(first.truth, second.truth);
    assert_eq!(first.report, second.report);
}
