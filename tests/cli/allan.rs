//! `dpn allan`: a made-up log at rest whose white noise is known.

use crate::recording::{put, rows, text};
use crate::run::{Done, dpn, end, files};
use std::path::Path;

/// Densities of the uniform noise of `recording::rows` at 200 Hz.
const ACCEL: f64 = 0.05 / 3.464_101_6 / 14.142_135_6;
const GYRO: f64 = 0.004 / 3.464_101_6 / 14.142_135_6;

fn allan(dir: &Path, log: &str, more: &[&str]) -> Done {
    let data = put(&dir.join("log"), "still", log);
    end(dpn().arg("allan").arg(data.join("still")).arg("--out").arg(dir.join("out")).args(more))
}

#[test]
fn white_noise_is_told_to_three_per_cent_and_walks_are_not_made_up() {
    let dir = tempfile::tempdir().unwrap();
    let done = allan(dir.path(), &text(&rows(24_000, 5_000_000)), &["--json"]).well();
    let json = done.json();
    for (name, density) in [("accel_white", ACCEL), ("gyro_white", GYRO)] {
        for axis in json["figures"][name].as_array().unwrap() {
            let got = axis.as_f64().unwrap();
            assert!((got / density - 1.0).abs() < 0.03, "{name}: {got} {density}");
        }
    }
    for axis in json["log"]["axes"].as_array().unwrap() {
        let walk = &axis["estimates"][3];
        assert_eq!((walk["coefficient"].as_str(), walk["seen"].as_bool()), (Some("walk"), Some(false)));
    }
    let names: Vec<String> = files(&dir.path().join("out")).into_keys().collect();
    assert_eq!(names, ["allan.csv", "allan.json", "allan.pdf", "allan.png", "allan.svg"]);
}

#[test]
fn the_page_holds_what_is_to_be_pasted_and_what_is_lacking() {
    let dir = tempfile::tempdir().unwrap();
    let done = allan(dir.path(), &text(&rows(12_000, 5_000_000)), &[]).well();
    for words in [
        "12000 samples at 200.0 Hz, 60 s at rest",
        "N white noise",
        "gyro x y z: bias walk not seen in 60 s; a log of",
        "Configurations that programs ship have 1 to 20 times",
        "--- openvins ---\n%YAML:1.0",
        "gyroscope_random_walk: ",
        "not seen in this log: an upper bound",
        "\"accel_noise_std\": [",
    ] {
        assert!(done.stdout.contains(words), "{words}: {}", done.stdout);
    }
}

#[test]
fn a_configuration_is_held_against_the_log() {
    let dir = tempfile::tempdir().unwrap();
    let config = dir.path().join("vins.yaml");
    // Densities where deviations per sample belong, and degrees.
    let degrees = GYRO * 14.142 * 57.3;
    std::fs::write(
        &config,
        format!("%YAML:1.0\nacc_n: {ACCEL:e}\nacc_w: 4e-5\ngyr_n: {degrees}\ngyr_w: 2e-6\n"),
    )
    .unwrap();
    let done =
        allan(dir.path(), &text(&rows(12_000, 5_000_000)), &["--check", config.to_str().unwrap()]).well();
    let line = |key: &str| {
        done.stdout.lines().find(|l| l.contains(&format!("`{key}` is"))).unwrap_or_default().to_owned()
    };
    assert!(
        line("acc_n").starts_with("warning:")
            && line("acc_n").contains("a density where a deviation per sample belongs"),
        "{done:?}"
    );
    assert!(line("gyr_n").contains("degrees where radians belong"), "{done:?}");
    assert!(line("gyr_w").starts_with("ok:"), "{done:?}");
    assert!(!done.stdout.contains("--- "), "who asks for a verdict gets no lines to paste: {done:?}");
    std::fs::write(&config, "acc_n: 0.014\nacc_w: 4e-5\ngyr_n: 0\ngyr_w: 2e-6\n").unwrap();
    let done =
        allan(dir.path(), &text(&rows(12_000, 5_000_000)), &["--check", config.to_str().unwrap()]).well();
    let zero = done.stdout.lines().find(|l| l.contains("`gyr_n` is 0.0")).unwrap_or_default();
    assert!(zero.starts_with("warning:") && zero.contains("put the sensor's figure there"), "{done:?}");
}

#[test]
fn a_log_that_moves_is_refused_with_its_seconds_and_one_that_is_knocked_is_cut() {
    let dir = tempfile::tempdir().unwrap();
    let mut moving = rows(12_000, 5_000_000);
    for (i, (_, values)) in moving.iter_mut().enumerate() {
        values[0] += (i as f64 * 0.01).sin();
    }
    let done = allan(dir.path(), &text(&moving), &[]);
    assert_eq!(done.code, Some(2), "{done:?}");
    assert!(done.stderr.starts_with("error: the log is not at rest: "), "{done:?}");
    assert!(done.stderr.contains("add --all"), "{done:?}");
    assert_eq!(done.stdout, "");
    let mut knocked = rows(12_000, 5_000_000);
    for (_, values) in &mut knocked[3000..3040] {
        values[3] += 0.5;
    }
    let done = allan(dir.path(), &text(&knocked), &[]).well();
    assert!(done.stdout.contains("not at rest throughout: "), "{done:?}");
}

#[test]
fn a_log_too_short_and_a_dead_axis_are_refused() {
    let dir = tempfile::tempdir().unwrap();
    allan(dir.path(), &text(&rows(1000, 5_000_000)), &[]).refused(
        dir.path(),
        "error: the log has 5.0 s without a hole; an Allan plot needs 10 s, one with a bias walk hours\n\n\
         hint: record for longer: minutes for white noise, hours for the bias",
    );
    let mut dead = rows(6000, 5_000_000);
    dead.iter_mut().for_each(|(_, values)| values[1] = 0.25);
    allan(dir.path(), &text(&dead), &[]).refused(
        dir.path(),
        "error: gyro y reads 0.25 throughout; a live sensor is never without noise\n\nhint: look at the wiring or the column",
    );
}
