//! An hour beside an IMU of 1 kHz and a camera of 20 Hz of whose messages one in a hundred is lost, comes twice, late, or with a wrong stamp.

use crate::chaos::{Notes, play};
use crate::flown::Flown;
use dpn_live::{Fed, LiveRun, Watched};
use dpn_testing::SensorFaults;
use dpn_testing::forged::Draw;
use dpn_vio::EstimatorConfig;
use std::time::Instant;

/// What this process holds in memory \[MB\].
fn resident_mb() -> f64 {
    let text = std::fs::read_to_string("/proc/self/statm").unwrap();
    4096e-6 * text.split(' ').nth(1).unwrap().parse::<f64>().unwrap()
}

/// Plays so many minutes; memory at each.
fn beside(minutes: usize) -> Vec<f64> {
    let flown = Flown::new([1000.0, 20.0]);
    let faults =
        SensorFaults { lost: 0.004, twice: 0.002, late: 0.003, jumps: 0.001, ..SensorFaults::default() };
    let calibration = Flown::calibration();
    let noise = "self".parse().unwrap();
    let estimator = EstimatorConfig::default();
    let run = LiveRun::new(&estimator, noise, Vec::new(), &calibration.camera, Fed::Images, 0).unwrap();
    let mut watched = Watched::new(run, &calibration, Notes::default());
    let (begun, mut draw) = (Instant::now(), Draw::new(1, "an hour"));
    let mut held = Vec::new();
    for minute in 0..minutes {
        let from_s = 60.0 * minute as f64;
        let faults = SensorFaults { good_s: 60.0, ..faults.clone() };
        play(&mut watched, &flown, [from_s, 60.0], &faults, &mut draw, (begun, from_s)).unwrap();
        held.push(resident_mb());
        let now_s = watched.listener.now_s;
        let notes = std::mem::replace(&mut watched.listener, Notes { now_s, ..Notes::default() });
        assert_eq!(notes.fault, None, "minute {minute}");
        // Ten a second, and what one in a hundred costs.
        assert!(
            notes.poses.len() > 550 || minute == 0,
            "{} poses in minute {minute}: {:?}",
            notes.poses.len(),
            notes.words
        );
        eprintln!("minute {minute}: {:.1} MB, {} restarts", held[minute], watched.totals().restarts);
        notes
            .words
            .iter()
            .filter(|(_, words)| words.contains("again"))
            .for_each(|(_, words)| eprintln!("{words}"));
    }
    let restarts = watched.totals().restarts;
    watched.end().unwrap();
    eprintln!(
        "{minutes} minutes in {:.0?}: {} messages passed over, {restarts} restarts",
        begun.elapsed(),
        watched.passed_over()
    );
    assert_eq!(restarts, 0);
    held
}

#[test]
#[ignore = "ten minutes; an hour of sensors, or DPN_MINUTES of them"]
fn an_hour_at_1_khz_holds_no_more_memory_than_ten_minutes_and_does_not_begin_again() {
    let minutes = std::env::var("DPN_MINUTES").map_or(60, |text| text.parse().unwrap());
    let held = beside(minutes);
    let [early, last] = [held[9.min(minutes - 1)], held[minutes - 1]];
    assert!(last - early < 0.05 * early, "{early} MB at ten minutes, {last} MB at the end");
}
