//! rosbag2's SQLite files.
#![no_main]

use dpn_logs::{LogOptions, read_sqlite};
use libfuzzer_sys::fuzz_target;
use std::io::Write;

fuzz_target!(|bytes: &[u8]| {
    let Ok(mut file) = tempfile::NamedTempFile::new() else { return };
    if file.write_all(bytes).is_ok() {
        let _ = read_sqlite(file.path(), &LogOptions::default());
    }
});
