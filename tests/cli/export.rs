//! `dpn export`.

use crate::run::{dpn, end};

#[test]
fn models_are_written_by_name_for_both_sensors_and_twice_the_same() {
    let tmp = tempfile::tempdir().unwrap();
    let written = |out: &str| {
        let done = end(dpn()
            .args(["export", "onnx", "--network", "sg11-s0", "--json", "--out"])
            .arg(tmp.path().join(out)));
        assert_eq!(done.code, Some(0), "{done:?}");
        let lines: Vec<serde_json::Value> =
            done.stdout.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
        assert_eq!(lines.len(), 2);
        assert_eq!((&lines[0]["sensor"], &lines[0]["unit"]), (&"accel".into(), &"m/s^2".into()));
        assert_eq!((&lines[1]["sensor"], &lines[1]["rate_hz"]), (&"gyro".into(), &200.0.into()));
        dpn_testing::files(&tmp.path().join(out))
    };
    let first = written("a");
    assert_eq!(first.keys().collect::<Vec<_>>(), ["accel/sg11-s0.onnx", "gyro/sg11-s0.onnx"]);
    assert!(first.values().all(|bytes| (10_000..400_000).contains(&bytes.len())));
    assert_eq!(first, written("b"));
}

#[test]
fn networks_that_are_not_there_are_named_beside_those_that_are() {
    let tmp = tempfile::tempdir().unwrap();
    let out = tmp.path().join("out");
    let done = end(dpn().args(["export", "onnx", "--network", "sg12-s0", "--out"]).arg(&out));
    assert_eq!(done.code, Some(2), "{done:?}");
    assert!(done.stderr.contains("`sg12-s0`") && done.stderr.contains("sg11-s0"), "{}", done.stderr);
    assert!(!out.exists());
    std::fs::write(tmp.path().join("broken.safetensors"), b"no weights").unwrap();
    let done = end(dpn().args(["export", "onnx", "--models"]).arg(tmp.path()).arg("--out").arg(&out));
    assert_eq!(done.code, Some(2), "{done:?}");
    assert!(done.stderr.contains("broken.safetensors") && !out.exists(), "{}", done.stderr);
}
