//! Messages of images: the first byte says the type, the next two the size that the calibration has, the rest is the message in an MCAP file.
#![no_main]

use dpn_logs::{ImageLogOptions, SensorEvent, read_sensors_from};
use libfuzzer_sys::fuzz_target;
use std::ops::ControlFlow;
use std::path::Path;

fn text(text: &str) -> Vec<u8> {
    [&(text.len() as u32).to_le_bytes(), text.as_bytes()].concat()
}

fn record(op: u8, content: &[u8]) -> Vec<u8> {
    [&[op], &(content.len() as u64).to_le_bytes()[..], content].concat()
}

fuzz_target!(|bytes: &[u8]| {
    let [kind, width, height, message @ ..] = bytes else { return };
    let size = [usize::from(*width), usize::from(*height)];
    let schema = if kind & 1 == 0 { "sensor_msgs/msg/Image" } else { "sensor_msgs/msg/CompressedImage" };
    let encoding = if kind & 2 == 0 { "cdr" } else { "ros1" };
    let schema = [&1u16.to_le_bytes()[..], &text(schema), &text(""), &text("")].concat();
    let channel = [&[1, 0, 1, 0][..], &text("/cam"), &text(encoding), &text("")].concat();
    let message = [&1u16.to_le_bytes()[..], &[0; 20], message].concat();
    let magic = b"\x89MCAP0\r\n".to_vec();
    let file = [magic, record(3, &schema), record(4, &channel), record(5, &message), record(15, &[0; 4])].concat();
    let options = ImageLogOptions::default();
    let _ = read_sensors_from(file.as_slice(), Path::new("fuzz"), &options, size, &mut |event| {
        if let SensorEvent::Image(_, Ok(image)) = event {
            assert_eq!([image.width(), image.height()], size);
        }
        ControlFlow::Continue(())
    });
});
