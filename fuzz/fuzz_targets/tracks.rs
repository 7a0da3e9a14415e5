//! Camera tracks; what is read is written and read again.
#![no_main]

use dpn_io::{read_tracks, write_tracks};
use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    let Ok(file) = tempfile::NamedTempFile::new() else { return };
    if std::fs::write(file.path(), bytes).is_err() {
        return;
    }
    if let Ok(frames) = read_tracks(file.path()) {
        write_tracks(file.path(), &frames).expect("what was read can be written");
        assert_eq!(read_tracks(file.path()).expect("what was written can be read").len(), frames.len());
    }
});
