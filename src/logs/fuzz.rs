//! Damaged bags for every reader: a recording or an error with words, never a panic.
//!
//! The same readers are fed by the targets in `fuzz/`, for as long as one likes.

use crate::{LogOptions, read_log, read_mcap, read_rosbag1, read_stream};
use dpn_core::random::{Stream, StreamRng};
use rand::Rng;
use std::path::{Path, PathBuf};

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../golden/bags")
}

/// Damages as disks and cut transfers do; lengths and counts get extreme values.
fn mutate(bytes: &mut Vec<u8>, rng: &mut StreamRng) {
    const WORDS: [u32; 6] = [0, 1, 0x7fff_ffff, 0x8000_0000, 0xffff_fffe, 0xffff_ffff];
    for _ in 0..rng.random_range(1..5) {
        if bytes.is_empty() {
            return;
        }
        let at = rng.random_range(0..bytes.len());
        match rng.random_range(0..6) {
            0 => bytes[at] = rng.random(),
            1 => bytes[at] ^= 1 << rng.random_range(0..8),
            2 => bytes.truncate(at),
            3 => drop(bytes.remove(at)),
            4 => {
                let word = WORDS[rng.random_range(0..WORDS.len())].to_le_bytes();
                let end = (at + 4).min(bytes.len());
                bytes[at..end].copy_from_slice(&word[..end - at]);
            }
            _ => {
                let end = (at + rng.random_range(1..200)).min(bytes.len());
                let copy = bytes[at..end].to_vec();
                bytes.splice(at..at, copy);
            }
        }
    }
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
            let mut rng = Stream::new(1).named("fuzz-bags").named(name).index(case).rng();
            let mut bytes = whole.clone();
            mutate(&mut bytes, &mut rng);
            if name.ends_with("bag") {
                speaks(read_rosbag1(bytes.as_slice(), Path::new(name), &options));
            } else {
                speaks(read_mcap(bytes.as_slice(), Path::new(name), &options));
            }
        }
    }
}

#[test]
fn damaged_logs_of_autopilots_phones_and_packers_panic_no_reader() {
    let options = LogOptions::default();
    let logs = folder().join("../logs");
    for (name, cases) in [
        ("px4.ulg", 600),
        ("px4_integrals.ulg", 600),
        ("ardupilot.bin", 600),
        ("ardupilot.log", 200),
        ("packed.csv.gz", 300),
        ("packed.csv.xz", 300),
        ("packed.csv.zst", 300),
        ("realsense.mcap.zst", 300),
        ("ros2_echo.csv", 100),
        ("decimal_commas.csv", 100),
        ("px4_vehicle_imu_0.csv", 100),
    ] {
        let whole = std::fs::read(logs.join(name)).unwrap();
        for case in 0..cases {
            let mut rng = Stream::new(1).named("fuzz-logs").named(name).index(case).rng();
            let mut bytes = whole.clone();
            mutate(&mut bytes, &mut rng);
            speaks(read_stream(bytes.as_slice(), Path::new(name), &options));
        }
    }
}

/// What is left of an autopilot's log that was cut is a prefix of the whole.
#[test]
fn an_autopilots_log_cut_anywhere_gives_everything_before_the_cut() {
    let options = LogOptions::default();
    for name in ["px4.ulg", "px4_integrals.ulg", "ardupilot.bin", "ardupilot.log"] {
        let bytes = std::fs::read(folder().join("../logs").join(name)).unwrap();
        let path = Path::new(name);
        let whole = read_stream(bytes.as_slice(), path, &options).unwrap().recording;
        let mut most = 0;
        for cut in (0..bytes.len()).step_by(101) {
            if let Ok(log) = read_stream(&bytes[..cut], path, &options) {
                let found = log.recording.samples();
                assert_eq!(found, &whole.samples()[..found.len()], "{name} {cut}");
                assert!(found.len() >= most, "{name} {cut}");
                most = found.len();
            }
        }
        assert!(most + 5 >= whole.len(), "{name}: {most}");
    }
}

#[test]
fn damaged_databases_panic_no_reader() {
    let whole = std::fs::read(folder().join("sqlite/sqlite.db3")).unwrap();
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("damaged.db3");
    for case in 0..150 {
        let mut rng = Stream::new(1).named("fuzz-sqlite").index(case).rng();
        let mut bytes = whole.clone();
        mutate(&mut bytes, &mut rng);
        std::fs::write(&path, bytes).unwrap();
        speaks(read_log(&path, &LogOptions::default()));
    }
}
