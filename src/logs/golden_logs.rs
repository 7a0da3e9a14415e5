//! Logs as people have them (`golden/logs`), untouched: rate, units and axes, and what was taken for granted.

use crate::{LogOptions, read_log};
use dpn_core::{Recorded, SampleRate, Samples};
use serde_json::Value;
use std::path::{Path, PathBuf};

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../golden/logs")
}

fn numbers(value: &Value) -> [f64; 3] {
    std::array::from_fn(|i| value[i].as_f64().unwrap())
}

#[test]
fn every_log_has_its_rate_units_and_axes_and_says_what_was_assumed() {
    let text = std::fs::read_to_string(folder().join("expected.json")).unwrap();
    let expected: Value = serde_json::from_str(&text).unwrap();
    let logs = expected["logs"].as_object().unwrap();
    assert!(logs.len() >= 50);
    let mut faults = Vec::new();
    for (name, expected) in logs {
        if let Err(fault) = std::panic::catch_unwind(|| check(name, expected)) {
            let words = fault.downcast_ref::<String>().cloned();
            faults.push(words.or_else(|| fault.downcast_ref::<&str>().map(|s| (*s).to_owned())));
        }
    }
    assert!(faults.is_empty(), "{} of {}: {faults:#?}", faults.len(), logs.len());
}

fn check(name: &str, expected: &Value) {
    let mut options = LogOptions::default();
    match (expected["flags"][0].as_str(), expected["flags"][1].as_str()) {
        (Some("--rate"), Some(hz)) => options.csv.rate = SampleRate::from_hz(hz.parse().unwrap()),
        (Some("--columns"), Some(columns)) => options.csv.columns = Some(columns.parse().unwrap()),
        (Some(_), Some(sensor)) => options.scales = sensor.parse().unwrap(),
        _ => {}
    }
    let log = read_log(&folder().join(name), &options).unwrap_or_else(|e| panic!("{name}: {e}"));
    assert_eq!(serde_json::to_value(log.kind).unwrap(), expected["kind"], "{name}");
    let rate = expected["rate_hz"].as_f64().unwrap();
    let found = log.recording.rate().hz();
    assert!((found / rate - 1.0).abs() < 1e-3, "{name}: {found} Hz, not {rate}");
    let samples = log.recording.all().unwrap();
    assert_eq!(samples.len() as u64, expected["count"].as_u64().unwrap(), "{name}");
    // That a log has one sensor alone is said.
    assert_eq!(log.warnings().len(), usize::from(log.alone.is_some()), "{name}: {:?}", log.warnings());
    assert_eq!(log.motors.is_empty(), !name.starts_with("betaflight"), "{name}");
    let tolerance = expected["tolerance"].as_f64().unwrap();
    for wanted in expected["samples"].as_array().unwrap() {
        let at = wanted["at"].as_u64().unwrap() as usize;
        let sample = samples[at];
        assert_eq!(sample.t.ns(), wanted["t_ns"].as_i64().unwrap(), "{name}: stamp of sample {at}");
        for (found, wanted) in [(sample.gyro, &wanted["gyro"]), (sample.accel, &wanted["accel"])] {
            for (found, wanted) in found.into_iter().zip(numbers(wanted)) {
                assert!(
                    (found - wanted).abs() < tolerance,
                    "{name}, sample {at}: {found}, not {wanted}: {sample:?}"
                );
            }
        }
    }
    let guesses = log.guesses.join(", ");
    for words in expected["guesses"].as_array().unwrap() {
        assert!(guesses.contains(words.as_str().unwrap()), "{name}: {guesses:?} lacks {words}");
    }
}
