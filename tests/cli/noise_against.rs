//! `dpn noise LOG --against FILE` and `dpn convert`: the page, its files, and trajectories that do not belong to the log.

use crate::recording::{put, rows, text};
use crate::run::{Done, dpn, end, files};
use std::fmt::Write;

#[test]
fn a_trajectory_tells_the_noise_and_one_that_does_not_fit_is_named() {
    let tmp = tempfile::tempdir().unwrap();
    let dir = tmp.path();
    let call = |line: &str| end(dpn().current_dir(dir).args(line.split(' ')));
    call("simulate flight f07-room-medium --out flights").well();
    // Fifteen seconds of it.
    let part = |name: &str| {
        let text = std::fs::read_to_string(dir.join("flights/f07-room-medium/mav0").join(name)).unwrap();
        text.lines().enumerate().filter(|(i, _)| *i == 0 || (2000..5000).contains(i)).fold(
            String::new(),
            |mut text, (_, line)| {
                let _ = writeln!(text, "{line}");
                text
            },
        )
    };
    std::fs::write(dir.join("log.csv"), part("imu0/data.csv")).unwrap();
    let truth = part("state_groundtruth_estimate0/data.csv");
    std::fs::write(dir.join("truth.csv"), &truth).unwrap();
    let against = |more: &str| -> Done { call(&format!("noise log.csv --out out --against {more}")) };
    let done = against("truth.csv --paste kalibr").well();
    assert!(done.stdout.lines().count() <= 30, "{}", done.stdout);
    for words in
        ["the trajectory's stamps are late by ", "scale off by ", "against a trajectory", "--- kalibr ---"]
    {
        assert!(done.stdout.contains(words), "{words}: {}", done.stdout);
    }
    let names: Vec<String> = files(&dir.join("out")).into_keys().collect();
    assert_eq!(names, ["against.json", "biases.csv"]);

    // The same as a calibration, and the samples under it.
    let done = call("fit log.csv --against truth.csv --out fit").well();
    assert!(done.stdout.contains("gyro: matrix * reading - bias, 95 %"), "{}", done.stdout);
    let rows = |path: &str| std::fs::read_to_string(dir.join(path)).unwrap().lines().count();
    assert_eq!(rows("fit/calibrated.csv"), rows("log.csv"));
    let fitted: serde_json::Value =
        serde_json::from_str(&std::fs::read_to_string(dir.join("fit/calibration.json")).unwrap()).unwrap();
    assert_eq!(fitted["calibration"][1]["sensor"], "gyro");

    assert!(!done.stderr.contains("lies beside"), "{done:?}");
    let less: String = truth.lines().take(1201).map(|line| format!("{line}\n")).collect();
    std::fs::write(dir.join("less.csv"), less).unwrap();
    let done = call("fit log.csv --against less.csv --out less").well();
    assert!(done.stderr.contains("warning: the trajectory lies beside 40 % of the log: "), "{done:?}");

    // Half its size, in TUM's columns.
    let half = truth.lines().skip(1).fold(String::new(), |mut text, line| {
        let v: Vec<f64> = line.split(',').map(|v| v.parse().unwrap()).collect();
        let _ = writeln!(
            text,
            "{:.9} {} {} {} {} {} {} {}",
            1e-9 * v[0],
            0.5 * v[1],
            0.5 * v[2],
            0.5 * v[3],
            v[5],
            v[6],
            v[7],
            v[4]
        );
        text
    });
    std::fs::write(dir.join("half.tum"), half).unwrap();
    let done = against("half.tum");
    assert_eq!(done.code, Some(2), "{done:?}");
    assert!(
        done.stderr.contains("log.csv against half.tum")
            && done.stderr.contains("multiply the positions by "),
        "{done:?}"
    );
}

#[test]
fn a_log_gets_a_lower_rate_behind_a_low_pass_and_never_a_higher_one() {
    let tmp = tempfile::tempdir().unwrap();
    let dir = tmp.path();
    let data = put(&dir.join("log"), "log", &text(&rows(2000, 5_000_000)));
    let convert = |more: &[&str]| {
        end(dpn().arg("convert").arg(data.join("log")).arg("--out").arg(dir.join("out.csv")).args(more))
    };
    let done = convert(&["--to-rate", "80"]).well();
    assert!(done.stderr.contains("200.0 Hz to 80.0 Hz behind a low pass: flat to 32.0 Hz"), "{done:?}");
    let written = std::fs::read_to_string(dir.join("out.csv")).unwrap();
    let stamps: Vec<i64> =
        written.lines().skip(1).map(|row| row.split(',').next().unwrap().parse().unwrap()).collect();
    // Ten seconds, less half a window at both ends.
    assert!((755..=770).contains(&stamps.len()), "{}", stamps.len());
    assert!(stamps.windows(2).all(|two| (two[1] - two[0] - 12_500_000).abs() <= 1));
    let done = convert(&["--to-rate", "400"]);
    assert!(done.code == Some(2) && done.stderr.contains("give a lower rate"), "{done:?}");
    let done = convert(&["--to-rate", "1"]);
    assert!(done.code == Some(2) && done.stderr.contains("it needs 36.00 s"), "{done:?}");
}
