//! `dpn check`: the log's doctor.

use crate::recording::{put, rows, text};
use crate::run::{dpn, end, files};

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
    assert_eq!(names, ["check.json", "spectra.csv", "spectra.png", "spectra.svg"]);
}
