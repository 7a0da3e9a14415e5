//! ArduPilot's binary logs, and text where the first byte is odd.
#![no_main]

use dpn_logs::{LogOptions, read_stream};
use libfuzzer_sys::fuzz_target;
use std::path::Path;

const MAGIC: [u8; 3] = [0xa3, 0x95, 0x80];

fuzz_target!(|bytes: &[u8]| {
    let text = bytes.first().is_some_and(|b| b % 2 == 1);
    let log = [if text { b"FMT, " } else { &MAGIC[..] }, bytes.get(1..).unwrap_or_default()].concat();
    let _ = read_stream(log.as_slice(), Path::new("fuzz"), &LogOptions::default());
});
