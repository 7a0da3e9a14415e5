//! `dpn noise` of several logs, and `dpn compare`.

use crate::recording::{Rows, rows, text};
use crate::run::{dpn, end, files};
use std::path::Path;

/// A log at rest of 30 s, its gyroscope so many times as noisy.
fn put(dir: &Path, name: &str, louder: f64) {
    let mut still: Rows = rows(6000, 5_000_000);
    if louder != 1.0 {
        // Other draws, too.
        still.reverse();
        let stamps: Vec<i64> = still.iter().rev().map(|(t, _)| *t).collect();
        still.iter_mut().zip(stamps).for_each(|((t, _), stamp)| *t = stamp);
    }
    still.iter_mut().for_each(|(_, values)| values[..3].iter_mut().for_each(|v| *v *= louder));
    std::fs::write(dir.join(name), text(&still)).unwrap();
}

#[test]
fn the_noise_of_several_logs_is_a_row_each_and_what_cannot_be_read_is_one_too() {
    let dir = tempfile::tempdir().unwrap();
    put(dir.path(), "a.csv", 1.0);
    put(dir.path(), "b.csv", 2.0);
    std::fs::write(dir.path().join("c.csv"), "no log\n").unwrap();
    let noise = |more: &[&str]| {
        end(dpn().arg("noise").arg(dir.path()).arg("--out").arg(dir.path().join("out")).args(more))
    };
    let page = noise(&[]).well().stdout;
    let lines: Vec<&str> = page.lines().collect();
    assert!(lines.len() == 5 && lines[1].contains("a.csv  200.0  rest"), "{page}");
    assert!(
        lines[1].ends_with("at rest, by the spectrum") && lines[3].contains("cannot be read: "),
        "{page}"
    );
    let json = noise(&["--json"]).well().json();
    let density = |log: usize| json["logs"][log]["noise"][1]["density"][0]["value"].as_f64().unwrap();
    assert!((density(1) / density(0) - 2.0).abs() < 0.2, "{json}");
    let refused = noise(&["--paste", "vins"]);
    refused.refused(dir.path(), "error: --paste is for one log, and 3 are named\n\nhint: leave it away for a table of all, or name one log");
}

#[test]
fn what_changed_between_two_logs_is_told_with_a_picture() {
    let dir = tempfile::tempdir().unwrap();
    put(dir.path(), "a.csv", 1.0);
    put(dir.path(), "b.csv", 1.5);
    std::fs::write(dir.path().join("short.csv"), text(&rows(20, 5_000_000))).unwrap();
    let compare = |a: &str, b: &str, more: &[&str]| {
        let out = dir.path().join("out");
        end(dpn()
            .arg("compare")
            .args([dir.path().join(a), dir.path().join(b)])
            .arg("--out")
            .arg(out)
            .args(more))
    };
    let page = compare("a.csv", "b.csv", &[]).well().stdout;
    let gyro = page.lines().find(|line| line.starts_with("  gyro at rest")).unwrap();
    assert!(gyro.ends_with("louder") && gyro.contains("1.5"), "{page}");
    let accel = page.lines().find(|line| line.starts_with("  accel at rest")).unwrap();
    assert!(accel.ends_with("no change seen"), "{page}");
    let names: Vec<String> = files(&dir.path().join("out")).into_keys().collect();
    assert_eq!(names, ["compare.json", "spectra.csv", "spectra.pdf", "spectra.png", "spectra.svg"]);
    let json = compare("a.csv", "b.csv", &["--json"]).well().json();
    assert_eq!(json["levels"].as_array().unwrap().len(), 2, "{json}");
    compare("a.csv", "a.csv", &[]).refused(
        dir.path(),
        "error: [DIR]/a.csv is compared with itself\n\nhint: name two logs of one sensor, the earlier one first",
    );
    compare("a.csv", "short.csv", &[]).refused(
        dir.path(),
        "error: nothing in [DIR]/short.csv can be held against [DIR]/a.csv\n\nhint: both need ten seconds at rest, or some seconds of like motion",
    );
}
