//! What is taken from an earlier run and what is not: results go by what they are made from, wherever that lies.

use crate::run::{Done, dpn, end};
use serde_json::Value;
use std::path::Path;

/// Some seconds of a simulated flight.
fn swept(dir: &Path, noises: &str, more: &[&str]) -> Done {
    let mut command = dpn();
    command.current_dir(dir).args(["eval", "--closed-loop", "--sequences", "room-medium", "--from", "70"]);
    command.args(["--to", "85", "--noise", noises, "--out", "out"]).args(more);
    end(&mut command)
}

/// Rows of the run: what identifies a cell, and its error.
fn rows(dir: &Path) -> Vec<(String, String, f64)> {
    let text = std::fs::read_to_string(dir.join("out/rows.jsonl")).unwrap();
    let row = |line: &str| {
        let row: Value = serde_json::from_str(line).unwrap();
        let text = |key: &str| row[key].as_str().unwrap().to_owned();
        (text("noise"), text("cell"), row["ate_se3"].as_f64().unwrap())
    };
    text.lines().map(row).collect()
}

/// A noise track over every flight, its accelerometer's deviation as given.
fn track(path: &Path, accel: f64) {
    let mut text =
        "#timestamp [ns],accel_std_x,accel_std_y,accel_std_z,gyro_std_x,gyro_std_y,gyro_std_z\n".to_owned();
    for i in 0..1200 {
        let t = 1_399_999_999_000_000_000_i64 + i * 400_000_000;
        text += &format!("{t},{accel},{accel},{accel},0.004,0.004,0.004\n");
    }
    std::fs::create_dir_all(path.parent().unwrap()).unwrap();
    std::fs::write(path, text).unwrap();
}

#[test]
fn another_noise_file_under_the_old_name_is_another_cell_and_a_moved_one_is_not() {
    let tmp = tempfile::tempdir().unwrap();
    let dir = tmp.path();
    let noises = "x4; file(\"n.csv\")";
    track(&dir.join("n.csv"), 0.1);
    let done = swept(dir, noises, &[]).well();
    assert!(done.stderr.contains("closed loop: 2 cells\n"), "{}", done.stderr);
    let first = rows(dir);
    let done = swept(dir, noises, &[]).well();
    assert!(done.stderr.contains("closed loop: 2 cells: 2 kept from out, 0 run\n"), "{}", done.stderr);
    assert_eq!(rows(dir), first);

    track(&dir.join("n.csv"), 2.0);
    let done = swept(dir, noises, &[]).well();
    assert!(done.stderr.contains("closed loop: 2 cells: 1 kept from out, 1 run\n"), "{}", done.stderr);
    let second = rows(dir);
    assert_eq!(second[0], first[0]);
    assert!(
        second[1].0 == first[1].0 && second[1].1 != first[1].1 && second[1].2 != first[1].2,
        "{second:?}"
    );

    std::fs::create_dir(dir.join("sub")).unwrap();
    std::fs::rename(dir.join("n.csv"), dir.join("sub/n.csv")).unwrap();
    let done = swept(dir, "file(\"sub/n.csv\")", &[]).well();
    assert!(done.stderr.contains("closed loop: 1 cells: 1 kept from out, 0 run\n"), "{}", done.stderr);
    let moved = rows(dir);
    assert_eq!(
        (&moved[0].0[..], &moved[0].1, moved[0].2),
        ("file(\"sub/n.csv\")", &second[1].1, second[1].2)
    );
}

#[test]
fn other_weights_under_the_old_name_are_other_cells() {
    let tmp = tempfile::tempdir().unwrap();
    let dir = tmp.path();
    let shipped = Path::new(env!("CARGO_MANIFEST_DIR")).join("models");
    let copy = |folder: &str, sensor: &str, tag: &str| {
        std::fs::create_dir_all(dir.join(folder).join(sensor)).unwrap();
        let from = shipped.join(sensor).join(format!("{tag}.safetensors"));
        std::fs::copy(from, dir.join(folder).join(sensor).join("sg11-s0.safetensors")).unwrap();
    };
    let run = |folder: &str| swept(dir, "dualpronet,x4", &["--models", folder]).well();
    for sensor in ["accel", "gyro"] {
        copy("a", sensor, "sg11-s0");
        copy("b", sensor, "sg11-s0");
    }
    run("a");
    let first = rows(dir);
    let done = run("b");
    assert!(
        done.stderr.contains("2 kept from out, 0 run"),
        "another folder, the same weights: {}",
        done.stderr
    );
    copy("b", "accel", "wide-s0");
    let done = run("b");
    assert!(done.stderr.contains("closed loop: 2 cells: 1 kept from out, 1 run\n"), "{}", done.stderr);
    let second = rows(dir);
    assert!(second[1] == first[1] && second[0].2 != first[0].2, "{second:?}");
}

#[test]
fn trajectories_asked_for_later_are_made_and_no_two_share_a_file() {
    let tmp = tempfile::tempdir().unwrap();
    let dir = tmp.path();
    track(&dir.join("sub/n.csv"), 0.1);
    track(&dir.join("sub_n.csv"), 2.0);
    let noises = "file(\"sub/n.csv\"); file(\"sub_n.csv\")";
    swept(dir, noises, &[]).well();
    assert!(!dir.join("out/trajectories").exists());
    let before = rows(dir);
    let done = swept(dir, noises, &["--trajectories"]).well();
    assert!(done.stderr.contains("closed loop: 2 cells\n"), "{}", done.stderr);
    assert_eq!(rows(dir), before);
    let files = || std::fs::read_dir(dir.join("out/trajectories")).unwrap().map(|e| e.unwrap().path());
    let texts: Vec<Vec<u8>> = files().map(|path| std::fs::read(path).unwrap()).collect();
    assert!(texts.len() == 2 && texts[0] != texts[1], "{:?}", files().collect::<Vec<_>>());
    std::fs::remove_file(files().next().unwrap()).unwrap();
    let done = swept(dir, noises, &["--trajectories"]).well();
    assert!(done.stderr.contains("1 kept from out, 1 run"), "{}", done.stderr);

    // Run anew without them, a cell's old one goes: it is another's.
    track(&dir.join("sub_n.csv"), 0.5);
    swept(dir, noises, &[]).well();
    assert_eq!(files().count(), 1);

    // One that becomes what the other is has its row, and never its own old trajectory.
    swept(dir, noises, &["--trajectories"]).well();
    track(&dir.join("sub_n.csv"), 0.1);
    let done = swept(dir, noises, &[]).well();
    assert!(done.stderr.contains("2 kept from out, 0 run"), "{}", done.stderr);
    swept(dir, noises, &["--trajectories"]).well();
    let texts: Vec<Vec<u8>> = files().map(|path| std::fs::read(path).unwrap()).collect();
    assert!(texts.len() == 2 && texts[0] == texts[1]);
}
