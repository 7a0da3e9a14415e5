//! Damaged bags for every reader: a recording or an error with words, never a panic.
//!
//! The same readers are fed by the targets in `fuzz/`, for as long as one likes.

use crate::budget::Budget;
use crate::fields::Encoding;
use crate::image_message::{ImageKind, decode};
use crate::messages::Messages;
use crate::{ImageLogOptions, Kind, LogOptions, bag, read_bag, read_log, read_sensors_from, read_stream};
use dpn_core::Samples;
use dpn_testing::forged::{Draw, damage};
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../golden/bags")
}

fn speaks(result: Result<crate::Log, crate::LogError>) {
    match result {
        Ok(log) => assert!(log.warnings().iter().all(|w| !w.is_empty() && !w.contains('\n'))),
        Err(error) => {
            let said = error.to_string();
            assert!(
                !said.is_empty() && !said.contains('\n') && error.hint().is_none_or(|h| !h.is_empty()),
                "{said:?}"
            );
        }
    }
}

#[test]
fn damaged_bags_panic_no_reader() {
    let options = LogOptions::default();
    for name in ["plain.bag", "lz4.bag", "bz2.bag", "two_imus.bag", "plain.mcap", "lz4.mcap", "zstd.mcap"] {
        let whole = std::fs::read(folder().join(name)).unwrap();
        for case in 0..400 {
            let mut bytes = whole.clone();
            damage(&mut bytes, &mut Draw::new(case, name));
            if name.ends_with("bag") {
                speaks(read_bag(Kind::Rosbag1, bytes.as_slice(), Path::new(name), &options));
            } else {
                speaks(read_bag(Kind::Mcap, bytes.as_slice(), Path::new(name), &options));
            }
        }
    }
}

#[test]
fn damaged_logs_of_autopilots_phones_and_packers_panic_no_reader() {
    let options = LogOptions::default();
    let logs = folder().join("../logs");
    for (name, cases) in [
        ("px4.ulg", 600),
        ("px4_integrals.ulg", 600),
        ("ardupilot.bin", 600),
        ("ardupilot.log", 200),
        ("betaflight.bbl", 600),
        ("oxiod.csv", 100),
        ("packed.csv.gz", 300),
        ("packed.csv.xz", 300),
        ("packed.csv.zst", 300),
        ("realsense.mcap.zst", 300),
        ("ros2_echo.csv", 100),
        ("rostopic_echo.txt", 100),
        ("serial_monitor.txt", 100),
        ("decimal_commas.csv", 100),
        ("px4_vehicle_imu_0.csv", 100),
    ] {
        let whole = std::fs::read(logs.join(name)).unwrap();
        for case in 0..cases {
            let mut bytes = whole.clone();
            damage(&mut bytes, &mut Draw::new(case, name));
            speaks(read_stream(bytes.as_slice(), Path::new(name), &options));
        }
    }
}

/// What is left of an autopilot's log that was cut is a prefix of the whole.
#[test]
fn an_autopilots_log_cut_anywhere_gives_everything_before_the_cut() {
    let options = LogOptions::default();
    for name in ["px4.ulg", "px4_integrals.ulg", "ardupilot.bin", "ardupilot.log"] {
        let bytes = std::fs::read(folder().join("../logs").join(name)).unwrap();
        let path = Path::new(name);
        let whole = read_stream(bytes.as_slice(), path, &options).unwrap().recording;
        let mut most = 0;
        for cut in (0..bytes.len()).step_by(101) {
            if let Ok(log) = read_stream(&bytes[..cut], path, &options) {
                let found = log.recording.all().unwrap();
                assert_eq!(found, whole.piece(0..found.len()).unwrap(), "{name} {cut}");
                assert!(found.len() >= most, "{name} {cut}");
                most = found.len();
            }
        }
        assert!(most + 5 >= whole.len(), "{name}: {most}");
    }
}

#[test]
fn damaged_databases_panic_no_reader() {
    let whole = std::fs::read(folder().join("sqlite/sqlite.db3")).unwrap();
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("damaged.db3");
    for case in 0..150 {
        let mut bytes = whole.clone();
        damage(&mut bytes, &mut Draw::new(case, "sqlite"));
        std::fs::write(&path, bytes).unwrap();
        speaks(read_log(&path, &LogOptions::default()));
    }
}

/// The messages of images in a bag, as they lie in it.
#[derive(Default)]
struct Images {
    numbers: Vec<(u32, ImageKind, Encoding)>,
    messages: Vec<(ImageKind, Encoding, Vec<u8>)>,
    budget: Budget,
}

impl Messages for Images {
    fn next_file(&mut self) {}

    fn declare(&mut self, number: u32, _name: &str, kind: &str, encoding: Result<Encoding, String>) -> bool {
        let kind = ImageKind::of(kind).zip(encoding.ok());
        self.numbers.extend(kind.map(|(kind, encoding)| (number, kind, encoding)));
        kind.is_some()
    }

    fn message(&mut self, number: u32, _received_ns: i64, data: &[u8]) {
        let found = self.numbers.iter().find(|(n, ..)| *n == number);
        self.messages.extend(found.map(|(_, kind, encoding)| (*kind, *encoding, data.to_vec())));
    }

    fn budget(&mut self) -> &mut Budget {
        &mut self.budget
    }
}

#[test]
fn damaged_messages_of_images_panic_no_decoder_and_make_no_other_size() {
    for bag in ["encodings.bag", "encodings.mcap"] {
        let mut images = Images::default();
        bag::read(&folder().join("../rigs").join(bag), None, &mut images).unwrap();
        assert_eq!(images.messages.len(), 34);
        for (i, (kind, encoding, whole)) in images.messages.iter().enumerate() {
            for case in 0..300 {
                let mut bytes = whole.clone();
                let mut draw = Draw::new(case, bag);
                // Every other time what stands before the pixels alone, where it is read most.
                match (case % 2, i) {
                    (0, _) => damage(&mut bytes, &mut draw),
                    _ => {
                        let mut head = bytes[..80].to_vec();
                        damage(&mut head, &mut draw);
                        bytes.splice(..80, head);
                    }
                }
                let Ok(message) = decode(&bytes, *encoding, *kind) else { continue };
                match message.grey(Path::new("a.bag"), [64, 48]) {
                    Ok(image) => assert_eq!((image.width(), image.height()), (64, 48)),
                    Err(error) => {
                        let said = error.to_string();
                        assert!(
                            said.starts_with("a.bag ") && !said.contains('\n') && error.hint().is_some(),
                            "{said:?}"
                        );
                    }
                }
            }
        }
    }
}

#[test]
fn damaged_bags_of_images_panic_no_reader() {
    for name in ["encodings.bag", "encodings.mcap"] {
        let whole = std::fs::read(folder().join("../rigs").join(name)).unwrap();
        let options =
            ImageLogOptions { image_topic: Some("/bgr8/image_raw".into()), ..ImageLogOptions::default() };
        for case in 0..150 {
            let mut bytes = whole.clone();
            damage(&mut bytes, &mut Draw::new(case, name));
            let mut images = 0;
            let read = read_sensors_from(bytes.as_slice(), Path::new(name), &options, [64, 48], &mut |_| {
                images += 1;
                if images < 30 { ControlFlow::Continue(()) } else { ControlFlow::Break(()) }
            });
            if let Err(error) = read {
                let said = error.to_string();
                assert!(
                    !said.is_empty() && !said.contains('\n') && error.hint().is_none_or(|h| !h.is_empty()),
                    "{said:?}"
                );
            }
        }
    }
}
