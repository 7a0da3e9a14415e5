//! `dpn truth`: a ground truth reconciled with the IMU beside it, and what is run along it.

use crate::run::{dpn, end};
use std::path::Path;

const FLIGHT: &str = "f07-room-medium";

#[test]
fn a_reconciled_truth_is_written_with_its_report_and_runs_go_along_it() {
    let tmp = tempfile::tempdir().unwrap();
    let dir = tmp.path();
    let call = |line: &str| end(dpn().current_dir(dir).args(line.split(' ')));
    call(&format!("simulate flight {FLIGHT} --out flights")).well();
    let said = call(&format!("truth flights/{FLIGHT} --out truth --json")).well().json();
    // The flight's own truth has neither noise nor delay.
    let delay = said["report"]["delay_ms"]["value"].as_f64().unwrap();
    assert!(delay.abs() < 0.1, "{delay}");
    let rows = std::fs::read_to_string(dir.join(format!("truth/{FLIGHT}.csv"))).unwrap();
    assert!(rows.lines().skip(1).all(|row| row.split(',').count() == 17) && rows.lines().count() > 5000);
    assert!(dir.join(format!("truth/{FLIGHT}.json")).is_file());

    let evaluation =
        format!("eval --closed-loop --data flights --sequences {FLIGHT} --noise x1 --from 20 --to 26");
    call(&format!("{evaluation} --truth truth --out along")).well();
    let manifest = std::fs::read_to_string(dir.join("along/run.json")).unwrap();
    assert!(manifest.contains(r#""truth":"reconciled""#) || manifest.contains(r#""truth": "reconciled""#));
    let rows = std::fs::read_to_string(dir.join("along/rows.jsonl")).unwrap();
    assert!(rows.contains(r#""truth":"reconciled""#), "{rows}");
    // Another truth is another run.
    let other = call(&format!("{evaluation} --out along"));
    assert_eq!(other.code, Some(2), "{other:?}");
    // None for this sequence: nothing is run along the published one instead.
    std::fs::create_dir(dir.join("empty")).unwrap();
    let none = call(&format!("{evaluation} --truth empty --out none"));
    assert_eq!(none.code, Some(2), "{none:?}");
    assert!(none.stderr.contains(&format!("empty/{FLIGHT}.csv does not exist")), "{}", none.stderr);
    assert!(!dir.join("none").exists());
}

#[test]
fn a_recording_too_short_is_refused_and_nothing_is_written() {
    let tmp = tempfile::tempdir().unwrap();
    let excerpt = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/euroc/MH_01_easy");
    let out = tmp.path().join("truth");
    let done = end(dpn().arg("truth").arg(&excerpt).arg("--out").arg(&out));
    assert_eq!(done.code, Some(2), "{done:?}");
    assert!(done.stderr.contains("at least 100 of each are needed"), "{}", done.stderr);
    assert!(!out.exists());
}
