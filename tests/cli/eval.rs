//! `dpn eval --open-loop`.

use crate::recording::{put, rows, sound, text};
use crate::run::{Done, dpn, end, files};
use crate::training::{tiny, with};
use serde_json::Value;
use std::path::{Path, PathBuf};

const PERIOD_NS: i64 = 5_000_000;

/// Two sequences, of which the first is to train on, and a folder with a network trained on it.
fn prepared(dir: &Path) -> (PathBuf, PathBuf) {
    let data = sound(dir);
    put(&data, "still-2", &text(&rows(2000, PERIOD_NS)));
    let models = dir.join("models");
    end(&mut tiny(dir, &data, 2, &models)).well();
    std::fs::remove_file(models.join("checkpoint.safetensors")).unwrap();
    (data, models)
}

fn judged(data: &Path, models: &Path, out: &Path, more: &[&str]) -> Done {
    let mut command = dpn();
    command.args(["eval", "--open-loop", "--sensor", "accel", "--bases", "sg(11,2)", "--data"]).arg(data);
    command.arg("--models").arg(models).arg("--out").arg(out);
    end(&mut with(command, more))
}

#[test]
fn it_leaves_rows_with_the_promised_keys_and_the_same_ones_twice() {
    let tmp = tempfile::tempdir().unwrap();
    let (data, models) = prepared(tmp.path());
    let (first, again) = (tmp.path().join("a"), tmp.path().join("b"));
    let said = judged(&data, &models, &first, &["--json"]).well().json();
    let rows = said["rows"].as_array().unwrap();
    for key in
        ["sensor", "base", "split", "estimator", "levels", "label", "rmse", "bias", "crb", "ratio", "n"]
    {
        assert!(rows.iter().all(|row| !row[key].is_null()), "`{key}` is missing in {said}");
    }
    let has = |key: &str, value: &str| rows.iter().any(|row| row[key] == value);
    for estimator in ["pronet", "diff2", "sg(11,2)"] {
        assert!(has("estimator", estimator), "no row of {estimator}");
    }
    for (key, value) in [
        ("split", "train"),
        ("split", "test"),
        ("levels", "grid"),
        ("levels", "continuous"),
        ("label", "sigma_inj"),
        ("label", "sigma_tot"),
    ] {
        assert!(has(key, value), "no row with {key} = {value}");
    }
    for row in rows {
        let figure = |key: &str| row[key].as_f64().unwrap();
        assert!((figure("ratio") - figure("rmse") / figure("crb")).abs() < 1e-9 * figure("ratio"), "{row}");
        assert_eq!(row["outside"].is_f64(), row["estimator"] == "pronet", "{row}");
    }

    judged(&data, &models, &again, &[]).well();
    let (first, again) = (files(&first), files(&again));
    assert!(first.keys().any(|name| name.ends_with(".svg")), "{:?}", first.keys());
    assert!(first.keys().any(|name| name.ends_with(".png")), "{:?}", first.keys());
    let file: Value = serde_json::from_slice(&first["open_loop.json"]).unwrap();
    assert_eq!(file, said);
    let lines = String::from_utf8(first["open_loop.csv"].clone()).unwrap().lines().count();
    assert!(lines > rows.len(), "{lines} lines of CSV for {} rows", rows.len());
    for (name, bytes) in &first {
        assert!(Some(bytes) == again.get(name), "{name} differs between two runs");
    }
}

#[test]
fn rows_that_a_reader_looks_for_and_cannot_find_are_explained() {
    let tmp = tempfile::tempdir().unwrap();
    let (data, models) = prepared(tmp.path());
    let of = |base: &str| {
        let mut command = dpn();
        command.args(["eval", "--open-loop", "--sensor", "accel", "--bases", base, "--data"]).arg(&data);
        end(command.arg("--models").arg(&models).arg("--out").arg(tmp.path().join("out"))).well()
    };
    assert!(!of("sg(11,2)").stderr.contains("note:"));
    let words = "note: log, accel, raw (grid, sigma_tot): no row of a network; a network is judged where it was trained, \
                 and those given were on sg(11,2) (grid, sigma_inj)\n";
    let done = of("raw");
    assert!(done.stderr.contains(words), "{}", done.stderr);
    // A sequence that moves as the network has not seen.
    let mut moving = rows(2000, PERIOD_NS);
    moving.iter_mut().enumerate().for_each(|(i, (_, values))| values[3] += 5.0 * (0.03 * i as f64).sin());
    put(&data, "still-2", &text(&moving));
    let done = of("sg(11,2)");
    let words = "warning: OUT OF RANGE: windows are unlike anything the network was trained on, and its errors there are those of an extrapolation: \
                 pronet on log's accel, sg(11,2) (";
    assert!(done.stderr.contains(words), "{}", done.stderr);
    let row = done.stdout.lines().find(|line| line.contains(" pronet ")).unwrap_or_default();
    let share: f64 = row.trim_end_matches(" %").rsplit(' ').next().unwrap().parse().unwrap();
    // One axis of three, and few of the others.
    assert!((33.0..60.0).contains(&share), "{row}");
    std::fs::remove_dir_all(data.join("still-2")).unwrap();
    let done = of("sg(11,2)");
    let words = "note: log: no row, for the table shows test sequences and still is to train on; give two sequences or more\n";
    assert!(done.stderr.contains(words), "{}", done.stderr);
    // A folder with nothing but the results.
    let left: Vec<String> =
        files(&tmp.path().join("out")).into_keys().filter(|name| name.starts_with("cells")).collect();
    assert!(left.is_empty(), "{left:?}");
}

#[test]
fn what_cannot_be_judged_is_refused_and_leaves_nothing() {
    let tmp = tempfile::tempdir().unwrap();
    let (data, models) = prepared(tmp.path());
    let out = tmp.path().join("out");
    let weights = models.join("accel.safetensors");
    let gone = tmp.path().join("gone");
    for done in [judged(&gone, &models, &out, &[]), judged(&data, &gone, &out, &[]), {
        let bytes = std::fs::read(&weights).unwrap();
        std::fs::write(&weights, &bytes[..bytes.len() - 5]).unwrap();
        judged(&data, &models, &out, &[])
    }] {
        assert_eq!(done.code, Some(2), "{done:?}");
        assert!(done.stderr.contains("error: ") && !done.stderr.contains("panicked"), "{done:?}");
        assert!(done.stderr.contains(tmp.path().to_str().unwrap()), "it names no place: {done:?}");
        assert!(!out.exists(), "{done:?} left {}", out.display());
    }
}
