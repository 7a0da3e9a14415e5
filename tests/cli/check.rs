//! `dpn check`: the log's doctor.

use crate::recording::{Rows, put, rows, text};
use crate::run::{Done, dpn, end, files};

#[test]
fn a_sound_log_has_notes_only_and_a_sick_one_is_told_what_ails_it() {
    let dir = tempfile::tempdir().unwrap();
    let check = |log: &str, more: &[&str]| {
        let data = put(&dir.path().join("log"), "still", log);
        end(dpn().arg("check").arg(data.join("still")).arg("--out").arg(dir.path().join("out")).args(more))
            .well()
    };
    let sound = check(&text(&rows(6000, 5_000_000)), &[]).stdout;
    assert!(sound.starts_with("6000 samples, 30.0 s, 200.00 Hz\n"), "{sound}");
    assert!(sound.contains("up is z") && sound.contains("at rest throughout, 30 s"), "{sound}");
    assert!(!sound.contains("bad:") && !sound.contains("warning:"), "{sound}");
    let mut sick = rows(6000, 5_000_000);
    sick.drain(2000..2100);
    for (_, values) in &mut sick {
        (values[3], values[4], values[5]) = (values[3] / 9.81, values[4] / 9.81, values[5] / 9.81);
    }
    let json = check(&text(&sick), &["--json"]).json();
    let bad: Vec<&str> = json["findings"]
        .as_array()
        .unwrap()
        .iter()
        .filter(|f| f["weight"] == "bad")
        .map(|f| f["about"].as_str().unwrap())
        .collect();
    assert_eq!(bad, ["gaps", "units"]);
    let names: Vec<String> = files(&dir.path().join("out")).into_keys().collect();
    assert_eq!(names, ["check.json", "spectra.csv", "spectra.pdf", "spectra.png", "spectra.svg"]);
}

/// Checks made-up rows; the files it left come along.
fn check(rows: &Rows) -> (Done, Vec<String>) {
    let dir = tempfile::tempdir().unwrap();
    let data = put(&dir.path().join("log"), "still", &text(rows));
    let done = end(dpn().arg("check").arg(data.join("still")).arg("--out").arg(dir.path().join("out")));
    let left = if dir.path().join("out").exists() {
        files(&dir.path().join("out")).into_keys().collect()
    } else {
        Vec::new()
    };
    (done, left)
}

#[test]
fn a_dead_sensor_is_a_finding_and_the_other_checks_run() {
    let mut dead = rows(6000, 5_000_000);
    dead.iter_mut().for_each(|(_, values)| values[..3].fill(0.0));
    let (done, left) = check(&dead);
    let page = done.well().stdout;
    for axis in ["x", "y", "z"] {
        assert!(
            page.contains(&format!("bad:     dead: gyro {axis} is dead: it reads 0 rad/s throughout")),
            "{page}"
        );
    }
    // The other sensor has its spectrum.
    assert!(page.contains("up is z") && page.contains("picture: "), "{page}");
    assert_eq!(left, ["check.json", "spectra.csv", "spectra.pdf", "spectra.png", "spectra.svg"]);
}

#[test]
fn a_clock_that_jumps_a_pause_and_a_sample_of_nonsense_are_named() {
    let mut jump = rows(6000, 5_000_000);
    jump[0].0 = 976;
    let page = check(&jump).0.well().stdout;
    assert!(page.starts_with("5999 samples, 30.0 s, 200.00 Hz\n"), "{page}");
    assert!(
        page.contains(
            "bad:     clock: the stamps jump 1 time(s), first by 44.4 years after sample 1, from 976 ns"
        ),
        "{page}"
    );
    let mut pause = rows(6000, 5_000_000);
    pause[3000..].iter_mut().for_each(|(t, _)| *t += 60_000_000_000);
    let page = check(&pause).0.well().stdout;
    assert!(page.contains("bad:     gaps: 1 hole(s), ") && !page.contains("jitter"), "{page}");
    let mut nonsense = rows(6000, 5_000_000);
    nonsense[100].1[4] = 1e30;
    nonsense[200].1[1] = -1000.0;
    let page = check(&nonsense).0.well().stdout;
    assert!(page.contains("values: left out: 1 sample(s) with values beyond 1e12 or below 1e-150, which no sensor measures, first at line 102"), "{page}");
    assert!(
        page.contains(
            "bad:     outliers: gyro y reads -1.0000e3 rad/s at 1.000 s, more than any IMU measures"
        ),
        "{page}"
    );
    assert!(page.contains("up is z, 0 degrees off") && !page.contains("inf"), "{page}");
}

#[test]
fn a_rate_of_a_wrong_unit_and_raw_counts_are_asked_about() {
    let page = check(&rows(6000, 100_000)).0.well().stdout;
    assert!(
        page.contains("warning: rate: 10000.000 Hz is faster than IMUs are read (10 to 8000 Hz)"),
        "{page}"
    );
    let page = check(&rows(100, 1)).0.well().stdout;
    assert!(page.contains("bad:     rate: 1000000000 Hz: no IMU is as fast"), "{page}");
    let mut counts = rows(6000, 5_000_000);
    for (_, values) in &mut counts {
        values[3..].iter_mut().for_each(|v| *v = (*v / 9.81 * 16384.0).round());
    }
    let page = check(&counts).0.well().stdout;
    assert!(page.contains("raw counts, all of them whole numbers? Some 163"), "{page}");
    assert!(!page.contains("% off 9.81"), "{page}");
}

#[test]
fn nothing_is_left_behind_where_the_picture_cannot_be_written() {
    let dir = tempfile::tempdir().unwrap();
    let data = put(&dir.path().join("log"), "still", &text(&rows(6000, 5_000_000)));
    let out = dir.path().join("out");
    std::fs::create_dir_all(out.join("spectra.svg")).unwrap();
    let done = end(dpn().arg("check").arg(data.join("still")).arg("--out").arg(&out));
    assert!(done.code == Some(2) && !out.join("check.json").exists(), "{done:?}");
}
