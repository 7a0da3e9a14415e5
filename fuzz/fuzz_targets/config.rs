//! Typed configurations of TOML: the estimator's and a network's.
#![no_main]

use dpn_io::config::parse;
use dpn_pronet::ProNetConfig;
use dpn_vio::EstimatorConfig;
use libfuzzer_sys::fuzz_target;
use std::path::Path;

fuzz_target!(|text: &str| {
    let path = Path::new("fuzz");
    let _ = parse::<EstimatorConfig>(text, path);
    let _ = parse::<ProNetConfig>(text, path);
});
