//! `dpn run` and `dpn eval --closed-loop` on folders of images, good and bad. The excerpt's IMU, and a picture that stands still.

use crate::run::{Done, dpn, end, files};
use serde_json::Value;
use std::path::{Path, PathBuf};

/// Images that the excerpt lists.
const LISTED: usize = 80;
const SIZE: [u32; 2] = [376, 240];

/// Grey PNG of `size`, 8 or 16 bits.
fn png(size: [u32; 2], grey: impl Fn(u32, u32) -> u8) -> Vec<u8> {
    let mut pixels = Vec::new();
    for y in 0..size[1] {
        for x in 0..size[0] {
            pixels.push(grey(x, y));
        }
    }
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, size[0], size[1]);
    encoder.set_color(png::ColorType::Grayscale);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.write_header().unwrap().write_image_data(&pixels).unwrap();
    bytes
}

/// Boxes of random greys under a sensor's noise, another one in every image.
fn scene(i: usize) -> Vec<u8> {
    let hash =
        |a: u32, b: u32| (a.wrapping_mul(7919) ^ b.wrapping_mul(104_729)).wrapping_mul(2_654_435_761) >> 16;
    png(SIZE, |x, y| (60 + hash(x / 13, y / 11) % 120 + hash(x + 977 * i as u32, y) % 3) as u8)
}

/// The excerpt with a camera half as wide and an image wherever `image` has one.
fn folder(dir: &Path, name: &str, image: impl Fn(usize) -> Option<Vec<u8>>) -> PathBuf {
    let copy = dir.join(name);
    let excerpt = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/euroc/V1_01_easy");
    for (name, bytes) in files(&excerpt) {
        let to = copy.join(&name);
        std::fs::create_dir_all(to.parent().unwrap()).unwrap();
        let halved = |text: String| {
            text.replace("[752, 480]", "[376, 240]")
                .replace("[458.654, 457.296, 367.215, 248.375]", "[229.327, 228.648, 183.358, 123.938]")
        };
        let bytes = match name.ends_with("cam0/sensor.yaml") {
            true => halved(String::from_utf8(bytes).unwrap()).into_bytes(),
            false => bytes,
        };
        std::fs::write(to, bytes).unwrap();
    }
    let cam = copy.join("mav0/cam0");
    std::fs::create_dir_all(cam.join("data")).unwrap();
    let listed = std::fs::read_to_string(cam.join("data.csv")).unwrap();
    for (i, line) in listed.lines().skip(1).enumerate() {
        if let Some(bytes) = image(i) {
            std::fs::write(cam.join("data").join(line.split(',').nth(1).unwrap()), bytes).unwrap();
        }
    }
    copy
}

fn odometry(source: &Path, out: &Path, more: &[&str]) -> Done {
    end(dpn().arg("run").arg(source).args(["--noise", "x4", "--out"]).arg(out).args(more))
}

#[track_caller]
fn refused(done: &Done, words: &[&str]) {
    assert_eq!((done.code, done.stdout.as_str()), (Some(2), ""), "{done:?}");
    for words in words {
        assert!(done.stderr.contains(words), "no `{words}` in {}", done.stderr);
    }
}

#[test]
fn a_folder_with_images_is_run_on_them_and_without_on_tracks() {
    let tmp = tempfile::tempdir().unwrap();
    let dir = folder(tmp.path(), "whole", |i| Some(scene(i)));
    let draw = tmp.path().join("pictures");
    let more = ["--json", "--draw", draw.to_str().unwrap(), "--draw-every", "2"];
    let said = odometry(&dir, &tmp.path().join("out"), &more).without_pose().json();
    let row = &said["report"]["row"];
    assert_eq!(row["camera"], "images");
    let seen = &row["front_end"];
    assert_eq!((&seen["images"], &seen["passed_over"]), (&LISTED.into(), &0.into()), "{seen}");
    assert!(
        seen["inlier_share"].as_f64().unwrap() > 0.9 && seen["tracks"].as_f64().unwrap() > 20.0,
        "{seen}"
    );
    let drawn: Vec<String> = files(&draw).into_keys().collect();
    let expected = [
        "timeline.csv",
        "timeline.pdf",
        "timeline.png",
        "timeline.svg",
        "top.csv",
        "top.pdf",
        "top.png",
        "top.svg",
        "tracks-0000.000s.png",
        "tracks-0002.000s.png",
    ];
    assert_eq!(drawn, expected);
    let said = odometry(&dir, &tmp.path().join("other"), &["--json", "--camera", "tracks"]).well().json();
    assert_eq!(
        (&said["report"]["row"]["camera"], &said["report"]["row"]["front_end"]),
        (&"tracks".into(), &Value::Null)
    );
}

#[test]
fn missing_images_are_counted_and_the_range_that_is_there_can_be_run() {
    let tmp = tempfile::tempdir().unwrap();
    let dir = folder(tmp.path(), "part", |i| (20..60).contains(&i).then(|| scene(i)));
    let out = tmp.path().join("out");
    let expected = [
        "40 of 80 images are not there",
        "40 in a row are",
        "hint: run what is there with --from 1 --to 2.95",
    ];
    refused(&odometry(&dir, &out, &[]), &expected);
    assert!(!out.exists(), "a refused run left files");
    let of = |more: &[&str]| {
        let said = odometry(&dir, &out, &[&["--json"], more].concat()).without_pose().json();
        said["report"]["row"]["front_end"]["images"].clone()
    };
    assert_eq!(of(&["--from", "1", "--to", "2.95"]), 40);
    assert_eq!(of(&["--skip-missing"]), 40);
    refused(&odometry(&dir, &out, &["--from", "1", "--to", "3"]), &["are not there"]);

    let none = folder(tmp.path(), "none", |_| None);
    refused(
        &odometry(&none, &out, &["--camera", "images"]),
        &["80 of 80 images are not there", "unpack the images"],
    );
    let flight = end(dpn().args(["run", "hover", "--camera", "images"]));
    refused(&flight, &["a flight has no folder of images"]);
}

#[test]
fn images_that_cannot_be_used_are_named_and_the_run_goes_on() {
    let tmp = tempfile::tempdir().unwrap();
    let dir = folder(tmp.path(), "bad", |i| {
        Some(match i {
            10 => b"<html>not found</html>".to_vec(),
            20 => b"\xff\xd8\xff\xe0no JPEG".to_vec(),
            30 => png([752, 480], |x, y| (x ^ y) as u8),
            40..=43 => png(SIZE, |_, _| 0),
            50 => scene(49),
            _ => scene(i),
        })
    });
    let done = odometry(&dir, &tmp.path().join("out"), &["--json"]).without_pose();
    let report = &done.json()["report"];
    let events = report["images"].as_array().unwrap();
    let reasons: Vec<&str> = events.iter().map(|event| event["reason"].as_str().unwrap()).collect();
    assert_eq!(reasons, ["unreadable", "unreadable", "unreadable", "blind", "repeated"], "{events:?}");
    assert_eq!((&events[3]["images"], &report["row"]["front_end"]["passed_over"]), (&4.into(), &8.into()));
    assert!((events[3]["from_s"].as_f64().unwrap() - 2.0).abs() < 0.01, "{events:?}");
    for words in [
        "is no readable PNG",
        "is no readable JPEG",
        "has 752 x 480 px; the camera's have 376 x 240",
        "4 images passed over from 2.00 to 2.15 s",
    ] {
        assert!(done.stderr.contains(words), "no `{words}` in {}", done.stderr);
    }
}

#[test]
fn a_recording_that_shows_nothing_and_a_calibration_of_another_camera_are_refused() {
    let tmp = tempfile::tempdir().unwrap();
    let out = tmp.path().join("out");
    let dark = folder(tmp.path(), "dark", |i| Some(png(SIZE, move |x, y| ((x + y + i as u32) % 2) as u8)));
    refused(&odometry(&dark, &out, &[]), &["no track in its 80 images", "dark, saturated, or all alike"]);
    let other = folder(tmp.path(), "other", |i| Some(png([640, 400], move |x, y| (x * y + i as u32) as u8)));
    refused(&odometry(&other, &out, &[]), &["has 640 x 400 px; the camera's have 376 x 240"]);
    assert!(!out.exists(), "a refused run left files");
}

#[test]
fn a_list_of_images_that_does_not_read_is_an_error_and_no_reason_to_run_on_tracks() {
    let tmp = tempfile::tempdir().unwrap();
    let out = tmp.path().join("out");
    let dir = folder(tmp.path(), "broken", |i| Some(scene(i)));
    let list = dir.join("mav0/cam0/data.csv");
    let text = std::fs::read_to_string(&list).unwrap().replacen(",", ";", 7);
    std::fs::write(&list, text).unwrap();
    refused(&odometry(&dir, &out, &[]), &["cam0/data.csv:"]);
    assert!(!out.exists(), "a refused run left files");
}

/// Rows without what differs from run to run.
fn rows(out: &Path) -> Vec<Value> {
    let text = std::fs::read_to_string(out.join("rows.jsonl")).unwrap();
    let mut rows: Vec<Value> = text.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    for row in &mut rows {
        for timing in ["cpu_per_data_s", "p95_update_ms", "stage_s"] {
            row.as_object_mut().unwrap().remove(timing);
        }
        for timing in ["cpu_per_data_s", "p95_ms"] {
            row["front_end"].as_object_mut().unwrap().remove(timing);
        }
    }
    rows
}

#[test]
fn a_sweep_over_images_is_the_same_on_one_thread_and_on_two() {
    let tmp = tempfile::tempdir().unwrap();
    folder(&tmp.path().join("data"), "whole", |i| Some(scene(i)));
    let sweep = |out: &Path, threads: &str| {
        let mut command = dpn();
        command.args([
            "eval",
            "--closed-loop",
            "--camera",
            "images",
            "--noise",
            "x1,x4",
            "--seeds",
            "2",
            "--data",
        ]);
        command.arg(tmp.path().join("data")).args(["--threads", threads, "--json", "--out"]).arg(out);
        end(&mut command)
    };
    let (one, two) = (tmp.path().join("one"), tmp.path().join("two"));
    sweep(&one, "1").well();
    sweep(&two, "2").well();
    let found = rows(&one);
    assert_eq!((found.len(), &found[0]["camera"]), (4, &"images".into()));
    assert_eq!(found, rows(&two));
}
