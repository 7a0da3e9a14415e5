//! A recording as a bag that is written while it is recorded: one record a message, no chunks, no index.

use dpn_core::{GrayImage, ImuSample, Stamp};

pub(crate) fn text(text: &str) -> Vec<u8> {
    [&(text.len() as u32).to_le_bytes(), text.as_bytes()].concat()
}

/// A record of an MCAP file.
pub(crate) fn record(op: u8, content: &[u8]) -> Vec<u8> {
    [&[op], &(content.len() as u64).to_le_bytes()[..], content].concat()
}

/// An MCAP file's begin: an IMU on channel 1, a camera on channel 2, in ROS 1's encoding.
pub(crate) fn begin() -> Vec<u8> {
    channels(&[(1, "sensor_msgs/Imu", "/imu0"), (2, "sensor_msgs/Image", "/cam0/image_raw")])
}

/// The same with these channels: number, type, topic.
pub(crate) fn channels(all: &[(u16, &str, &str)]) -> Vec<u8> {
    let mut file = b"\x89MCAP0\r\n".to_vec();
    for (id, kind, topic) in all {
        let number = id.to_le_bytes();
        file.extend(record(3, &[&number[..], &text(kind), &text("ros1msg"), &text("")].concat()));
        file.extend(record(4, &[&number[..], &number, &text(topic), &text("ros1"), &text("")].concat()));
    }
    file
}

pub(crate) fn message(channel: u16, t_ns: i64, fields: &[u8]) -> Vec<u8> {
    let head =
        [0u32, (t_ns / 1_000_000_000) as u32, (t_ns % 1_000_000_000) as u32].map(u32::to_le_bytes).concat();
    let logged = t_ns.to_le_bytes();
    record(5, &[&channel.to_le_bytes()[..], &[0; 4], &logged, &logged, &head, &text("body"), fields].concat())
}

pub(crate) fn sample_on(channel: u16, s: &ImuSample) -> Vec<u8> {
    let mut values = [0.0; 37];
    values[13..16].copy_from_slice(&s.gyro);
    values[25..28].copy_from_slice(&s.accel);
    message(channel, s.t.ns(), &values.map(f64::to_le_bytes).concat())
}

/// As bgr8 where all three are alike, in rows three bytes longer than they need be.
pub(crate) fn image(t: Stamp, image: &GrayImage) -> Vec<u8> {
    let (width, height) = (image.width(), image.height());
    let mut pixels = Vec::new();
    for row in image.view().rows() {
        pixels.extend(row.iter().flat_map(|p| [*p; 3]).chain([1, 2, 3]));
    }
    let size = [height as u32, width as u32].map(u32::to_le_bytes).concat();
    let step = (3 * width as u32 + 3).to_le_bytes();
    let length = (pixels.len() as u32).to_le_bytes();
    message(2, t.ns(), &[&size[..], &text("bgr8"), &[0], &step, &length, &pixels].concat())
}
