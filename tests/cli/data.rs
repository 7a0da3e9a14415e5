//! `dpn data`: a data set in one file, and the same results from it.

use crate::run::{dpn, end};
use dpn_testing::repository;
use std::path::{Path, PathBuf};

fn packed(dir: &Path) -> PathBuf {
    let out = dir.join("set.dpn");
    let set = repository().join("tests/data");
    let said = end(dpn().args(["data", "pack"]).arg(set).arg("--out").arg(&out)).well().stdout;
    assert!(said.contains("3 sequences") && said.contains("images in "), "{said}");
    out
}

/// Rows without what the clock says.
fn rows(path: &Path) -> Vec<serde_json::Value> {
    let row = |line: &str| {
        let mut row: serde_json::Value = serde_json::from_str(line).unwrap();
        for key in ["cpu_per_data_s", "p95_update_ms", "stage_s"] {
            row.as_object_mut().unwrap().remove(key);
        }
        row
    };
    std::fs::read_to_string(path.join("rows.jsonl")).unwrap().lines().map(row).collect()
}

#[test]
fn a_pack_gives_the_rows_of_its_folder_under_the_same_names_so_that_they_are_kept() {
    let dir = tempfile::tempdir().unwrap();
    let pack = packed(dir.path());
    let eval = |data: &Path, out: &str| {
        let out = dir.path().join(out);
        let done = end(dpn()
            .args(["eval", "--closed-loop", "--sequences", "V1_01", "--noise", "x1,x4", "--data"])
            .arg(data)
            .arg("--out")
            .arg(&out))
        .well();
        (rows(&out), done)
    };
    let (folder, _) = eval(&repository().join("tests/data"), "folder");
    let (file, _) = eval(&pack, "file");
    assert_eq!(folder, file);
    let (again, done) = eval(&pack, "folder");
    assert_eq!(again, folder);
    assert!(done.stderr.contains("2 kept from"), "{}", done.stderr);
}

#[test]
fn a_damaged_a_cut_and_a_foreign_file_are_one_line_each_and_exit_code_2() {
    let dir = tempfile::tempdir().unwrap();
    let pack = packed(dir.path());
    let whole = std::fs::read(&pack).unwrap();
    let check = || end(dpn().args(["data", "check"]).arg(&pack));
    assert!(check().well().stdout.contains("parts are whole"));
    assert!(end(dpn().args(["data", "list"]).arg(&pack)).well().stdout.contains("imu0/data.csv"));
    let mut bad = whole.clone();
    let last = bad.len() - 1;
    bad[last] ^= 1;
    std::fs::write(&pack, &bad).unwrap();
    let done = check();
    assert_eq!(done.code, Some(2));
    assert!(done.stdout.contains("is damaged: its checksum does not fit"), "{}", done.stdout);
    assert!(done.stderr.contains("1 column(s) damaged"), "{}", done.stderr);
    let eval = || {
        end(dpn()
            .args(["eval", "--closed-loop", "--noise", "x1", "--data"])
            .arg(&pack)
            .arg("--out")
            .arg(dir.path().join("out")))
    };
    for (bytes, said) in [
        (&whole[..last], "cut off"),
        (&whole[..5], "a file of 5 bytes, where a data pack is needed"),
        (&b"some words that are no pack"[..], "a file of another kind, where a data pack is needed"),
    ] {
        std::fs::write(&pack, bytes).unwrap();
        for done in [check(), eval()] {
            assert_eq!(done.code, Some(2));
            let first = done.stderr.lines().next().unwrap();
            assert!(first.starts_with("error: ") && first.contains(said), "{}", done.stderr);
        }
    }
    assert!(!dir.path().join("out").exists());
}
