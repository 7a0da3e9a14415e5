//! The reader of anybody's text logs, and the one that takes them line by line.
#![no_main]

use dpn_io::{CsvOptions, ImuLines, parse_imu_csv_loosely};
use libfuzzer_sys::fuzz_target;
use std::path::Path;

fuzz_target!(|bytes: &[u8]| {
    let path = Path::new("fuzz");
    let _ = parse_imu_csv_loosely(bytes, path, &CsvOptions::default());
    let mut lines = ImuLines::new(path, CsvOptions::default());
    for line in bytes.split_inclusive(|b| *b == b'\n') {
        let _ = lines.push(line);
    }
});
