//! PX4's ULogs.
#![no_main]

use dpn_logs::{LogOptions, read_stream};
use libfuzzer_sys::fuzz_target;
use std::path::Path;

const MAGIC: &[u8] = b"ULog\x01\x12\x35";

fuzz_target!(|bytes: &[u8]| {
    let log = [&MAGIC[..], bytes].concat();
    let _ = read_stream(log.as_slice(), Path::new("fuzz"), &LogOptions::default());
});
