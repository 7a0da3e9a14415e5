//! Damaged bags for every reader: a recording or an error with words, never a panic.
//!
//! The same readers are fed by the targets in `fuzz/`, for as long as one likes.

use crate::{LogOptions, read_log, read_mcap, read_rosbag1};
use dpn_testing::forged::{Draw, damage};
use std::path::{Path, PathBuf};

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../golden/bags")
}

fn speaks(result: Result<crate::Log, crate::LogError>) {
    match result {
        Ok(log) => assert!(log.warnings().iter().all(|w| !w.is_empty() && !w.contains('\n'))),
        Err(error) => {
            let said = error.to_string();
            assert!(
                !said.is_empty() && !said.contains('\n') && error.hint().is_none_or(|h| !h.is_empty()),
                "{said:?}"
            );
        }
    }
}

#[test]
fn damaged_bags_panic_no_reader() {
    let options = LogOptions::default();
    for name in ["plain.bag", "lz4.bag", "bz2.bag", "two_imus.bag", "plain.mcap", "lz4.mcap", "zstd.mcap"] {
        let whole = std::fs::read(folder().join(name)).unwrap();
        for case in 0..400 {
            let mut bytes = whole.clone();
            damage(&mut bytes, &mut Draw::new(case, name));
            if name.ends_with("bag") {
                speaks(read_rosbag1(bytes.as_slice(), Path::new(name), &options));
            } else {
                speaks(read_mcap(bytes.as_slice(), Path::new(name), &options));
            }
        }
    }
}

#[test]
fn damaged_databases_panic_no_reader() {
    let whole = std::fs::read(folder().join("sqlite/sqlite.db3")).unwrap();
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("damaged.db3");
    for case in 0..150 {
        let mut bytes = whole.clone();
        damage(&mut bytes, &mut Draw::new(case, "sqlite"));
        std::fs::write(&path, bytes).unwrap();
        speaks(read_log(&path, &LogOptions::default()));
    }
}
