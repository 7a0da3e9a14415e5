//! Files of images; the first two bytes say the size that the calibration has.
#![no_main]

use dpn_io::parse_image;
use libfuzzer_sys::fuzz_target;
use std::path::Path;

fuzz_target!(|bytes: &[u8]| {
    let [width, height, file @ ..] = bytes else { return };
    let size = [usize::from(*width), usize::from(*height)];
    if let Ok(image) = parse_image(file, Path::new("fuzz"), size) {
        assert_eq!([image.width(), image.height()], size);
    }
});
