//! The strict reader of IMU logs as text.
#![no_main]

use dpn_io::{CsvOptions, parse_imu_csv};
use libfuzzer_sys::fuzz_target;
use std::path::Path;

fuzz_target!(|bytes: &[u8]| {
    let _ = parse_imu_csv(bytes, Path::new("fuzz"), &CsvOptions::default());
});
