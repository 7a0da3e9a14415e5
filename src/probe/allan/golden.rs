//! Held to allantools, and to logs whose coefficients are known.

use super::fit::Planner;
use super::model::Coefficient;
use super::{deviation, simulate};
use dpn_core::random::Stream;
use dpn_core::{SampleRate, Sensor};
use dpn_io::{CsvOptions, read_imu_csv};
use dpn_testing::{pack, repository};
use serde::Deserialize;
use std::collections::BTreeMap;

#[derive(Deserialize)]
struct Golden {
    made_up: MadeUp,
    adis16405: Recorded,
}

#[derive(Deserialize)]
struct MadeUp {
    rate_hz: f64,
    signal: Vec<f64>,
    averages: Vec<usize>,
    deviations: Vec<f64>,
}

#[derive(Deserialize)]
struct Recorded {
    rate_hz: f64,
    averages: Vec<usize>,
    deviations: BTreeMap<String, Vec<f64>>,
}

fn golden() -> Golden {
    let text = std::fs::read_to_string(repository().join("golden/allantools/golden.json")).unwrap();
    serde_json::from_str(&text).unwrap()
}

fn agree(ours: &[f64], theirs: &[f64], tolerance: f64) {
    assert_eq!(ours.len(), theirs.len());
    for (i, (a, b)) in ours.iter().zip(theirs).enumerate() {
        assert!((a.sqrt() / b - 1.0).abs() < tolerance, "{i}: {} {b}", a.sqrt());
    }
}

#[test]
fn overlapping_deviations_are_those_of_allantools() {
    let case = golden().made_up;
    assert_eq!(deviation::averages(case.signal.len()), case.averages);
    let rate = SampleRate::from_hz(case.rate_hz).unwrap();
    agree(&deviation::variances(&case.signal, rate, &case.averages), &case.deviations, 1e-9);
}

/// All of a recorded log, and the fitted white noise against allantools' deviations on the slope of -1/2.
#[test]
fn a_recorded_log_gives_allantools_deviations_and_its_white_noise() {
    let case = golden().adis16405;
    let Some(path) = pack("static/adis16405_imu1.csv") else { return };
    let recording = read_imu_csv(&path, &CsvOptions::default()).unwrap().recording;
    let rate = SampleRate::from_hz(case.rate_hz).unwrap();
    let planner = Planner::new(recording.len(), rate);
    for sensor in Sensor::ALL {
        for (axis, name) in ["x", "y", "z"].into_iter().enumerate() {
            let signal = recording.axis(sensor, axis);
            let theirs = &case.deviations[&format!("{sensor} {name}")];
            agree(&deviation::variances(&signal, rate, &case.averages), theirs, 1e-6);
            let fit = planner.fit(&signal).unwrap();
            let white = fit.of(Coefficient::White);
            // Where their curve falls by a half, give or take .08: of this accelerometer's, over a hump at 1 s, no more is left.
            let taus: Vec<f64> = case.averages.iter().map(|m| *m as f64 / case.rate_hz).collect();
            let slope = |i: usize| (theirs[i + 1] / theirs[i - 1]).ln() / (taus[i + 1] / taus[i - 1]).ln();
            let flat = |i: &usize| (slope(*i) + 0.5).abs() < 0.08;
            let inner: Vec<usize> = (1..taus.len() - 1).collect();
            // The first stretch that does: behind the hump of something that swings the curve crosses that slope once more.
            let on: Vec<f64> = inner
                .chunk_by(|a, b| flat(a) == flat(b))
                .find(|stretch| stretch.len() >= 3 && flat(&stretch[0]))
                .unwrap_or_default()
                .iter()
                .map(|&i| theirs[i] * taus[i].sqrt())
                .collect();
            assert!(!on.is_empty(), "{sensor} {name}: no slope");
            let mean = on.iter().sum::<f64>() / on.len() as f64;
            eprintln!(
                "{sensor} {name}: N {:.4e}, allantools {mean:.4e} over {} times",
                white.value,
                on.len()
            );
            assert!((white.value / mean - 1.0).abs() < 0.03, "{sensor} {name}: {} {mean}", white.value);
        }
    }
}

/// The whole promise is in `examples/allan_coverage.rs`; here few and short logs.
#[test]
fn intervals_hold_the_truth_of_simulated_logs() {
    const LOGS: u64 = 24;
    let truth: [f64; 5] = [2e-6, 1e-3, 3e-4, 3e-5, 0.0];
    let rate = SampleRate::from_hz(100.0).unwrap();
    let planner = Planner::new(60_000, rate);
    let mut held = [0; 5];
    for log in 0..LOGS {
        let mut rng = Stream::new(log).named("allan-golden").rng();
        let signal = simulate::at_rest(&truth.map(|v| v * v), 60_000, rate, &mut rng);
        let fit = planner.fit(&signal).unwrap();
        assert!(fit.of(Coefficient::White).seen);
        assert!(fit.misfit < 2.0, "{}", fit.misfit);
        for (k, estimate) in fit.estimates.iter().enumerate() {
            held[k] += u64::from((estimate.low..=estimate.high).contains(&truth[k]));
        }
    }
    // 95 % intervals: of 24, 20 or fewer would be one in a hundred.
    assert!(held.iter().all(|h| *h >= 21), "{held:?}");
}

#[test]
fn the_length_that_is_asked_for_shows_what_was_not_seen() {
    let truth: [f64; 5] = [0.0, 1e-3, 0.0, 2e-4, 0.0];
    let rate = SampleRate::from_hz(50.0).unwrap();
    let simulated = |samples: usize, seed: u64| {
        let mut rng = Stream::new(seed).named("allan-needs").rng();
        let signal = simulate::at_rest(&truth.map(|v| v * v), samples, rate, &mut rng);
        Planner::new(samples, rate).fit(&signal).unwrap().of(Coefficient::Walk)
    };
    let short = simulated(1500, 1);
    assert!(!short.seen && short.value <= short.high, "{short:?}");
    let needs = short.needs_s.unwrap();
    assert!(needs > 30.0, "{needs}");
    // One as large as the truth shows in a log forty times as long, and lies in its interval.
    let long = simulated(60_000, 2);
    assert!(long.seen && (long.low..=long.high).contains(&2e-4), "{long:?}");
}
