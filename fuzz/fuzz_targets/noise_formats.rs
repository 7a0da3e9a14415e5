//! Configurations with noise figures.
#![no_main]

use dpn_io::noise_formats::{Given, parse};
use libfuzzer_sys::fuzz_target;
use std::path::Path;

fuzz_target!(|bytes: &[u8]| {
    let _ = parse(bytes, Path::new("fuzz"), None, &Given::default());
});
