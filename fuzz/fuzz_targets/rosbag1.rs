//! ROS 1 bags.
#![no_main]

use dpn_logs::{Kind, LogOptions, read_bag};
use libfuzzer_sys::fuzz_target;
use std::path::Path;

fuzz_target!(|bytes: &[u8]| {
    let _ = read_bag(Kind::Rosbag1, bytes, Path::new("fuzz"), &LogOptions::default());
});
