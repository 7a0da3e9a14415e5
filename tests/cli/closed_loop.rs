//! `dpn eval --closed-loop`, on the second half of one simulated flight.

use crate::run::{Done, dpn, end, files, run};
use serde_json::Value;
use std::path::Path;

/// The second half of a flight of a minute and a half, two specs, one of them a control that draws.
fn swept(out: &Path, more: &[&str]) -> Done {
    let mut command = dpn();
    command.args(["eval", "--closed-loop", "--sequences", "room-medium", "--from", "50"]);
    if !more.contains(&"--noise") {
        command.args(["--noise", "x4,x1;shuffled(diff2)"]);
    }
    command.arg("--out").arg(out).args(more);
    end(&mut command)
}

/// Rows of `rows.jsonl` without what differs from run to run.
fn rows(out: &Path) -> Vec<Value> {
    let text = std::fs::read_to_string(out.join("rows.jsonl")).unwrap();
    let rows = text.lines().map(|line| serde_json::from_str(line).unwrap());
    rows.map(|mut row: Value| {
        let fields = row.as_object_mut().unwrap();
        for timing in ["cpu_per_data_s", "p95_update_ms", "stage_s"] {
            assert!(fields.remove(timing).is_some(), "no {timing}");
        }
        if let Some(front_end) = fields["front_end"].as_object_mut() {
            for timing in ["cpu_per_data_s", "p95_ms"] {
                assert!(front_end.remove(timing).is_some(), "no {timing}");
            }
        }
        row
    })
    .collect()
}

#[test]
fn rows_have_the_promised_keys_and_a_broken_off_sweep_goes_on_to_the_same_ones() {
    let tmp = tempfile::tempdir().unwrap();
    let (first, second) = (tmp.path().join("a"), tmp.path().join("b"));
    let seeds = ["--seeds", "2", "--json"];
    let said = swept(&first, &[&seeds[..], &["--trajectories", "--threads", "1"]].concat()).well().json();
    let all = said["rows"].as_array().unwrap();
    assert_eq!(all.len(), 4);
    for (row, (seed, noise)) in
        all.iter().zip([(0, "x4,x1"), (0, "shuffled(diff2)"), (1, "x4,x1"), (1, "shuffled(diff2)")])
    {
        assert_eq!((&row["seed"], &row["noise"]), (&seed.into(), &noise.into()));
        assert_eq!((&row["sequence"], &row["camera"]), (&"f07-room-medium".into(), &"tracks".into()));
        assert_eq!(row["truth"], "exact");
        assert_eq!((&row["split"], &row["from_s"]), (&"train".into(), &50.0.into()));
        for key in ["ate_se3", "ate_yaw", "completion", "init_s", "cpu_per_data_s", "rpe_1s", "whitened"] {
            assert!(row[key].is_f64(), "`{key}` of {row}");
        }
        assert!(row["ate_se3"].as_f64().unwrap() < 1.0 && row["failure"].is_null(), "{row}");
    }
    let left = files(&first);
    assert!(left.contains_key("trajectories/f07-room-medium.x4_x1.seed1.tum"), "{:?}", left.keys());
    for name in ["run.json", "closed_loop.txt", "closed_loop.json", "closed_loop.html"] {
        assert!(left.contains_key(name), "{name}");
    }

    // Two threads, stopped after two cells and in the middle of a line.
    swept(&second, &[&seeds[..], &["--threads", "2"]].concat()).well();
    let expected = rows(&first);
    assert_eq!(rows(&second), expected);
    let path = second.join("rows.jsonl");
    let text = std::fs::read_to_string(&path).unwrap();
    let lines: Vec<&str> = text.lines().collect();
    let cut = format!("{}\n{}\n{}", lines[3], lines[0], &lines[1][..60]);
    std::fs::write(&path, cut).unwrap();
    let again = swept(&second, &seeds).well();
    assert_eq!(rows(&second), expected);
    assert!(again.stderr.contains("closed loop: 4 cells: 2 kept from "), "{}", again.stderr);

    // A sweep of fewer cells runs none anew and loses none.
    let before = std::fs::read(&path).unwrap();
    let fewer = swept(&second, &["--json"]).well().json();
    assert_eq!(fewer["rows"].as_array().unwrap().len(), 2);
    assert_eq!(std::fs::read(&path).unwrap().len(), before.len());

    // Other settings are another run.
    let other = swept(&second, &["--set", "window.key_frames=8"]);
    assert_eq!((other.code, other.stdout.as_str()), (Some(2), ""));
    assert!(
        other.stderr.contains("another estimator.window.key_frames: 10 there, 8 now"),
        "{}",
        other.stderr
    );
    assert!(other.stderr.contains("hint: give another folder with --out"), "{}", other.stderr);
}

#[test]
fn a_sweep_ends_where_it_is_told_to() {
    let tmp = tempfile::tempdir().unwrap();
    let out = tmp.path().join("part");
    swept(&out, &["--noise", "x4", "--to", "60", "--trajectories"]).well();
    let text = std::fs::read_to_string(out.join("trajectories/f07-room-medium.x4.seed0.tum")).unwrap();
    let stamps: Vec<f64> = text
        .lines()
        .filter(|line| !line.starts_with('#'))
        .map(|line| line.split(' ').next().unwrap().parse().unwrap())
        .collect();
    let seconds = stamps[stamps.len() - 1] - stamps[0];
    assert!((5.0..=10.0).contains(&seconds), "{seconds} s");
    let other = swept(&out, &["--noise", "x4", "--to", "59"]);
    assert_eq!(other.code, Some(2));
    assert!(other.stderr.contains("another start"), "{}", other.stderr);
}

#[test]
fn what_cannot_be_swept_is_refused_before_anything_runs() {
    let tmp = tempfile::tempdir().unwrap();
    let out = tmp.path().join("out");
    for (more, words) in [
        (&["--noise", "x4,dualpronett"][..], "did you mean `dualpronet`?"),
        (&["--noise", "dualpronet(sg9-s0)"], "there is no accel network `sg9-s0`"),
        (&["--noise", "file(\"none.csv\")"], "none.csv does not exist"),
        (&["--sequences", "cave"], "no sequence is called `cave`; there are f01-hall-slow"),
        (&["--from", "500"], "what is run, from 500 s, has fewer than 20"),
        (&["--set", "window.keyframes=8"], "did you mean `key_frames`?"),
        (&["--set", "window.key_frames=2"], "`window.key_frames` is 2, but must be 3 to 30"),
        (&["--set", "window.handover=true"], "expected one of `reuse`, `split`, `consume`"),
    ] {
        let mut command = dpn();
        command.args(["eval", "--closed-loop", "--out"]).arg(&out).args(more);
        if !more.contains(&"--sequences") {
            command.args(["--sequences", "hover"]);
        }
        let done = end(&mut command);
        assert_eq!((done.code, done.stdout.as_str()), (Some(2), ""), "{more:?}: {done:?}");
        assert!(done.stderr.contains(words), "{more:?}: {}", done.stderr);
        assert!(!out.exists(), "{more:?} left files");
    }
}

#[test]
fn flags_of_one_loop_are_not_those_of_the_other() {
    for line in [
        "eval",
        "eval --open-loop --closed-loop",
        "eval --open-loop --noise x1",
        "eval --closed-loop --bases raw",
        "eval --closed-loop --tracks there",
        "eval --closed-loop --from -3",
        "eval --closed-loop --to soon",
    ] {
        assert_eq!(run(line).code, Some(2), "{line}");
    }
}

#[test]
fn what_one_command_ran_serves_another_through_the_cache_whatever_folder_it_writes_to() {
    let tmp = tempfile::tempdir().unwrap();
    let [first, second, third] = ["a", "b", "c"].map(|name| tmp.path().join(name));
    let kept = tmp.path().join("kept");
    let cache = ["--cache", kept.to_str().unwrap()];
    swept(&first, &cache).well();
    let again = swept(&second, &[&cache[..], &["--noise", "x4,x1;x1"]].concat()).well();
    assert!(again.stderr.contains("cells: 1 taken from "), "{}", again.stderr);
    assert_eq!(rows(&second)[0], rows(&first)[0]);
    // A file that belongs beside a row is none of the cache's.
    let files = swept(&third, &[&cache[..], &["--trajectories"]].concat()).well();
    assert!(!files.stderr.contains("cells: "), "{}", files.stderr);
}
