//! Weights of a network.
#![no_main]

use dpn_pronet::network::Network;
use libfuzzer_sys::fuzz_target;
use std::path::Path;

fuzz_target!(|bytes: &[u8]| {
    let _ = Network::from_bytes(bytes, Path::new("fuzz"));
});
