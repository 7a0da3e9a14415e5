//! Cameras as other programs' configurations describe them.
#![no_main]

use dpn_io::calibration::parse;
use libfuzzer_sys::fuzz_target;
use std::path::Path;

fuzz_target!(|bytes: &[u8]| {
    let _ = parse(bytes, Path::new("fuzz"));
});
