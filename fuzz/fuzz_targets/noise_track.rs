//! Noise tracks and trajectories.
#![no_main]

use dpn_io::{read_noise_track, read_tum};
use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    let Ok(file) = tempfile::NamedTempFile::new() else { return };
    if std::fs::write(file.path(), bytes).is_ok() {
        let _ = (read_noise_track(file.path()), read_tum(file.path()));
    }
});
