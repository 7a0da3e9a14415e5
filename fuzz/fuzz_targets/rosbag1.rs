//! ROS 1 bags.
#![no_main]

use dpn_logs::{LogOptions, read_rosbag1};
use libfuzzer_sys::fuzz_target;
use std::path::Path;

fuzz_target!(|bytes: &[u8]| {
    let _ = read_rosbag1(bytes, Path::new("fuzz"), &LogOptions::default());
});
