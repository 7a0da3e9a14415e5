//! Images of every kind by other people's programs, to the grey pixels that OpenCV makes of them.

use crate::{ImageLog, ImageLogOptions, ImageSpan, LogError, SensorEvent, read_sensors};
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};

const SIZE: [usize; 2] = [64, 48];
/// A JPEG's decoders may round its cosines as they please.
const JPEG_TOLERANCE: u8 = 2;

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../golden/rigs")
}

fn expected() -> serde_json::Value {
    serde_json::from_str(&std::fs::read_to_string(folder().join("expected.json")).unwrap()).unwrap()
}

fn stamps() -> Vec<i64> {
    expected()["stamps_ns"].as_array().unwrap().iter().map(|t| t.as_i64().unwrap()).collect()
}

/// The pixels behind a PGM's head.
fn pixels(kind: &str, index: usize) -> Vec<u8> {
    let bytes = std::fs::read(folder().join(format!("expected/{kind}_{index}.pgm"))).unwrap();
    bytes[bytes.len() - SIZE[0] * SIZE[1]..].to_vec()
}

fn log(name: &str, topic: Option<&str>) -> ImageLog {
    let options = ImageLogOptions { image_topic: topic.map(str::to_owned), ..ImageLogOptions::default() };
    ImageLog::find(&folder().join(name), options).unwrap().unwrap()
}

fn holds(log: &ImageLog, kind: &str) {
    let imu = log.imu(SIZE).unwrap();
    assert_eq!(imu.warnings(), Vec::<String>::new());
    let found: Vec<i64> = imu.recording.held().unwrap().samples().iter().map(|s| s.t.ns()).collect();
    assert_eq!(serde_json::json!(found), expected()["imu_stamps_ns"]);
    let images: Vec<_> = log.images(SIZE, ImageSpan::ALL).unwrap().collect();
    assert_eq!(images.iter().map(|(t, _)| t.ns()).collect::<Vec<_>>(), stamps());
    for (i, (_, image)) in images.iter().enumerate() {
        let (found, expected) = (image.as_ref().unwrap().pixels(), pixels(kind, i));
        let apart = found.iter().zip(&expected).map(|(a, b)| a.abs_diff(*b)).max().unwrap();
        let tolerance = if kind == "jpeg" { JPEG_TOLERANCE } else { 0 };
        assert!(apart <= tolerance, "{log:?} {i}: {apart}");
    }
}

#[test]
fn every_encoding_in_every_bag_is_the_same_grey_as_opencvs() {
    let expected = expected();
    let topics = expected["topics"].as_object().unwrap();
    assert_eq!(topics.len(), 17);
    for bag in ["encodings.bag", "encodings.mcap"] {
        for (topic, kind) in topics {
            holds(&log(bag, Some(topic)), kind.as_str().unwrap());
        }
    }
    for (topic, kind) in [("/bgr8/image_raw", "colour"), ("/jpeg/image_raw/compressed", "jpeg")] {
        holds(&log("sqlite", Some(topic)), kind);
        holds(&log("sqlite/sqlite.db3", Some(topic)), kind);
    }
}

#[test]
fn folders_with_times_hold_the_same() {
    holds(&log("folder_png", None), "colour");
    holds(&log("folder_jpeg", None), "jpeg");
}

#[test]
fn a_part_in_seconds_is_what_is_read() {
    for log in [log("sqlite", Some("/bgr8/image_raw")), log("folder_png", None)] {
        let of = |from_s, to_s| -> Vec<i64> {
            log.images(SIZE, ImageSpan { from_s, to_s }).unwrap().map(|(t, _)| t.ns()).collect()
        };
        let stamps = stamps();
        assert_eq!(of(0.1, None), stamps[1..]);
        assert_eq!(of(0.0, Some(0.05)), stamps[..1]);
        assert!(of(0.01, Some(0.05)).is_empty());
        // One that is dropped early ends too.
        assert!(log.images(SIZE, ImageSpan::ALL).unwrap().next().is_some());
    }
}

#[test]
fn what_is_not_there_is_named_with_what_is() {
    let error = |name, topic, size| log(name, topic).imu(size).unwrap_err();
    let several = error("sqlite", None, SIZE);
    let said = several.to_string();
    let listed =
        "sqlite: 2 topics of images: /bgr8/image_raw (2 images), /jpeg/image_raw/compressed (2 images)";
    assert!(said.ends_with(listed), "{said}");
    assert_eq!(several.hint().unwrap(), "say which one: --image-topic /bgr8/image_raw");
    let none = error("sqlite", Some("/bgr8/image"), SIZE);
    let listed = "no topic of images `/bgr8/image`; it has /bgr8/image_raw, /jpeg/image_raw/compressed";
    assert!(none.to_string().ends_with(listed), "{none}");
    assert_eq!(none.hint().unwrap(), "did you mean `/bgr8/image_raw`?");
    let size = error("sqlite", Some("/bgr8/image_raw"), [752, 480]);
    let words = "sqlite: image 1 on /bgr8/image_raw has 64 x 48 px; the camera's have 752 x 480";
    assert!(size.to_string().ends_with(words), "{size}");
    let jpeg = error("sqlite", Some("/jpeg/image_raw/compressed"), [32, 24]).to_string();
    assert!(jpeg.ends_with("has 64 x 48 px; the camera's have 32 x 24"), "{jpeg}");
    let blind = error("../bags/plain.bag", None, SIZE);
    let words = "no images on any topic of type sensor_msgs/Image or CompressedImage; it has /talk (std_msgs/String), /imu0 (sensor_msgs/Imu)";
    assert!(blind.to_string().ends_with(words), "{blind}");
    let dir = tempfile::tempdir().unwrap();
    std::fs::create_dir(dir.path().join("images")).unwrap();
    std::fs::write(dir.path().join("times.txt"), "0 1.5 1\n1 1.6 1\n").unwrap();
    let log = |skip_missing| {
        ImageLog::find(dir.path(), ImageLogOptions { skip_missing, ..ImageLogOptions::default() })
            .unwrap()
            .unwrap()
    };
    assert!(
        log(false)
            .imu(SIZE)
            .unwrap_err()
            .to_string()
            .contains("lists 2 images, and images/ beside it holds 0")
    );
    assert!(matches!(log(true).imu(SIZE), Err(LogError::NoImuFile { .. })));
}

#[test]
fn samples_and_images_come_in_the_order_of_their_recording() {
    let options =
        ImageLogOptions { image_topic: Some("/bgr8/image_raw".to_owned()), ..ImageLogOptions::default() };
    let (mut samples, mut images) = (0, Vec::new());
    let damage = read_sensors(&folder().join("encodings.mcap"), &options, SIZE, &mut |event| {
        match event {
            SensorEvent::Sample(_) => samples += 1,
            SensorEvent::Image(t, image) => {
                images.push((t.ns(), image.unwrap().pixels() == pixels("colour", images.len()), samples));
            }
            SensorEvent::PassedOver(why) => panic!("{why}"),
        }
        ControlFlow::Continue(())
    });
    assert_eq!(damage.unwrap(), None);
    let stamps = stamps();
    // Images were received 2 ms after their stamps, samples .3 ms.
    assert_eq!((samples, images), (40, vec![(stamps[0], true, 11), (stamps[1], true, 31)]));
    let error = read_sensors(&folder().join("encodings.bag"), &ImageLogOptions::default(), SIZE, &mut |_| {
        ControlFlow::Continue(())
    });
    assert!(matches!(error, Err(LogError::SeveralImageTopics { .. })), "{error:?}");
    let error =
        read_sensors(&folder().join("../bags/two_imus.bag"), &ImageLogOptions::default(), SIZE, &mut |_| {
            ControlFlow::Continue(())
        });
    assert!(matches!(error, Err(LogError::SeveralTopics { .. })), "{error:?}");
}
