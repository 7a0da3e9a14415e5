//! MCAP files.
#![no_main]

use dpn_logs::{LogOptions, read_mcap};
use libfuzzer_sys::fuzz_target;
use std::path::Path;

fuzz_target!(|bytes: &[u8]| {
    let _ = read_mcap(bytes, Path::new("fuzz"), &LogOptions::default());
});
