//! `dpn train --model inertial` and `dpn eval --inertial`: from recordings with trajectories to the papers' figures, and what is no score.

use crate::run::{Done, dpn, end};
use std::fmt::Write;

#[test]
fn a_correction_is_trained_resumed_and_scored_and_a_recording_that_was_learned_from_is_not() {
    let tmp = tempfile::tempdir().unwrap();
    let dir = tmp.path();
    let call = |line: &str| -> Done { end(dpn().current_dir(dir).args(line.split(' '))) };
    for flight in ["f07-room-medium", "f01-hall-slow"] {
        call(&format!("simulate flight {flight} --out flights")).well();
    }
    let config = |name: &str, train: &str, test: &str| {
        let text = format!(
            "name = \"sim\"\nspeed = 0.5\nsteps = 3\nbatch = 2\nwindow = 512\ntrain = [\"{train}\"]\ntest = [\"{test}\"]\n"
        );
        std::fs::write(dir.join(name), text).unwrap();
    };
    config("sim.toml", "f07-room-medium", "f01-hall-slow");
    let train = "train --model inertial --config sim.toml --data flights --out runs/a";
    call(train).well();
    let whole = std::fs::read(dir.join("runs/a/network.safetensors")).unwrap();
    call(train).refused(dir, "error: runs/a: a run stands there already\n\nhint: go on with it by --resume, or choose another folder with --out");
    call(&format!("{train} --resume")).well();
    assert_eq!(std::fs::read(dir.join("runs/a/network.safetensors")).unwrap(), whole);
    let other = call(&format!("{train} --resume --seed 1"));
    assert!(
        other.code == Some(2) && other.stderr.contains("another configuration or other recordings"),
        "{other:?}"
    );

    let done = call("export onnx --inertial runs/a/network.safetensors --out onnx").well();
    assert_eq!(
        done.stdout,
        "onnx/inertial/sim-s0.onnx: a gyroscope's bias at 200 Hz, to be averaged over 20 s, 309 kB\n"
    );
    let model = std::fs::read(dir.join("onnx/inertial/sim-s0.onnx")).unwrap();
    assert!(String::from_utf8_lossy(&model).contains("never hand single corrected samples to an odometry"));
    assert!(
        String::from_utf8_lossy(&model)
            .contains("what gravity tells of the bias beside it is not in this file")
    );
    let none = call("export onnx --inertial sim.toml --out onnx");
    assert!(none.code == Some(2) && none.stderr.contains("sim.toml: no whole safetensors file"), "{none:?}");

    let done = call("eval --inertial sim.toml --data flights --models runs --out out").well();
    let wanted = [
        "gyro: matrix * reading - bias",
        "network 0 averaged, gravity",
        "raw, its own mean bias",
        "data sheet",
        "dualpronet(effective-s0), scaled",
        "residuals of the last 5 s",
        "figure: out/inertial.svg",
    ];
    for words in wanted {
        assert!(done.stdout.contains(words), "{words}: {}", done.stdout);
    }
    let text = std::fs::read_to_string(dir.join("out/inertial.json")).unwrap();
    let all: serde_json::Value = serde_json::from_str(&text).unwrap();
    let sources = all["sequences"][0]["sources"].as_array().unwrap();
    let aoe = |name: &str| {
        sources.iter().find(|s| s["name"] == name).unwrap()["score"]["aoe_deg"].as_f64().unwrap()
    };
    assert!(aoe("raw, its own mean bias") < aoe("raw"), "{text}");
    let slow = &sources.iter().find(|s| s["name"] == "affine, gravity").unwrap()["slow"];
    assert!(slow["nees"].as_f64().is_some_and(|nees| nees > 0.0), "{text}");

    // The same recording under another name.
    let flight = |part: &str| format!("flights/f07-room-medium/mav0/{part}/data.csv");
    let truth = flight("state_groundtruth_estimate0");
    std::fs::copy(dir.join(flight("imu0")), dir.join("copy.csv")).unwrap();
    config("seen.toml", "f07-room-medium", &format!("../copy.csv=../{truth}"));
    let seen = call("eval --inertial seen.toml --data flights");
    assert!(seen.code == Some(2) && seen.stderr.contains("the very recording was trained on"), "{seen:?}");

    // A trajectory over a third of it.
    let rows = std::fs::read_to_string(dir.join(&truth)).unwrap();
    let third = rows.lines().take(rows.lines().count() / 3).fold(String::new(), |mut text, row| {
        let _ = writeln!(text, "{row}");
        text
    });
    std::fs::write(dir.join("third.csv"), third).unwrap();
    config("third.toml", "../copy.csv=../third.csv", "f01-hall-slow");
    let done = call("train --model inertial --config third.toml --data flights --out runs/b");
    assert!(done.code == Some(2) && done.stderr.contains("33 % of the samples"), "{done:?}");
    assert!(!dir.join("runs/b").exists());
    config("both.toml", "f01-hall-slow", "f01-hall-slow");
    let done = call("train --model inertial --config both.toml --data flights");
    assert!(done.code == Some(2) && done.stderr.contains("none of them in `test`"), "{done:?}");
}
