//! Bags written by PyPI's `rosbags` and `mcap-ros2-support`, whole and damaged.

use crate::{Kind, Log, LogError, LogOptions, read_log, read_mcap, read_rosbag1};
use dpn_core::{ImuSample, Stamp};
use std::path::{Path, PathBuf};

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../golden/bags")
}

fn expected() -> Vec<ImuSample> {
    let text = std::fs::read_to_string(folder().join("expected.json")).unwrap();
    let all: serde_json::Value = serde_json::from_str(&text).unwrap();
    let axes =
        |key: &str, i: usize| -> [f64; 3] { std::array::from_fn(|k| all[key][i][k].as_f64().unwrap()) };
    let stamps = all["stamps_ns"].as_array().unwrap();
    (0..stamps.len())
        .map(|i| ImuSample {
            t: Stamp::from_ns(stamps[i].as_i64().unwrap()),
            gyro: axes("gyro", i),
            accel: axes("accel", i),
        })
        .collect()
}

fn open(name: &str, topic: Option<&str>) -> Result<Log, LogError> {
    let options = LogOptions { topic: topic.map(str::to_owned), ..LogOptions::default() };
    read_log(&folder().join(name), &options)
}

#[test]
fn every_bag_holds_what_its_writer_put_there() {
    let expected = expected();
    for (name, kind) in [
        ("plain.bag", Kind::Rosbag1),
        ("lz4.bag", Kind::Rosbag1),
        ("bz2.bag", Kind::Rosbag1),
        ("plain.mcap", Kind::Mcap),
        ("lz4.mcap", Kind::Mcap),
        ("zstd.mcap", Kind::Mcap),
        ("mcap", Kind::Rosbag2),
        ("mcap/mcap.mcap", Kind::Mcap),
        ("sqlite", Kind::Rosbag2),
        ("sqlite/sqlite.db3", Kind::Sqlite),
    ] {
        let log = open(name, None).unwrap();
        assert_eq!((log.kind, log.topic.as_deref()), (kind, Some("/imu0")), "{name}");
        assert_eq!(log.recording.samples(), expected, "{name}");
        assert_eq!(log.warnings(), Vec::<String>::new(), "{name}");
    }
}

#[test]
fn a_topic_is_chosen_and_one_that_cannot_be_says_what_there_is() {
    let error = open("two_imus.bag", None).unwrap_err();
    assert!(
        error.to_string().ends_with("two_imus.bag: 2 IMU topics: /imu0 (12 messages), /imu1 (12 messages)"),
        "{error}"
    );
    assert_eq!(error.hint().unwrap(), "say which one: --topic /imu0");
    let second = open("two_imus.bag", Some("/imu1")).unwrap();
    let moved: Vec<ImuSample> = expected()
        .into_iter()
        .map(|mut s| {
            s.gyro[0] += 1.0;
            s.accel[1] += 1.0;
            s
        })
        .collect();
    assert_eq!(second.recording.samples(), moved);
    let error = open("two_imus.bag", Some("imu1")).unwrap_err();
    assert_eq!(error.hint().unwrap(), "did you mean `/imu1`?");
    let error = open("two_imus.bag", Some("/talk")).unwrap_err();
    assert!(
        error.to_string().ends_with("`/talk` is of type std_msgs/String, not sensor_msgs/Imu"),
        "{error}"
    );
    let error = open("no_imu.bag", None).unwrap_err();
    assert!(
        error.to_string().ends_with("no topic of type sensor_msgs/Imu; it has /talk (std_msgs/String)"),
        "{error}"
    );
}

/// Cut at every length: what is left is a prefix of the whole, never an empty one once two messages are there, and the cut is said.
#[test]
fn a_bag_cut_anywhere_gives_everything_before_the_cut() {
    let expected = expected();
    let options = LogOptions::default();
    for name in ["plain.bag", "lz4.bag", "bz2.bag", "plain.mcap", "lz4.mcap", "zstd.mcap"] {
        let whole = std::fs::read(folder().join(name)).unwrap();
        let path = Path::new(name);
        let mut before = 0;
        for cut in (0..whole.len()).step_by(37) {
            let bytes = &whole[..cut];
            let read = if name.ends_with("bag") {
                read_rosbag1(bytes, path, &options)
            } else {
                read_mcap(bytes, path, &options)
            };
            match read {
                Ok(log) => {
                    let found = log.recording.samples();
                    assert_eq!(found, &expected[..found.len()], "{name} {cut}");
                    assert!(found.len() >= before, "{name} {cut}");
                    before = found.len();
                    // Behind the last message stand index and summary only.
                    let words = log.warnings();
                    assert!(
                        words.iter().any(|w| w.starts_with("damaged log: ")) || before == expected.len(),
                        "{name} {cut}: {words:?}"
                    );
                }
                Err(error) => {
                    assert_eq!(before, 0, "{name} {cut}: {error}");
                    assert!(error.hint().is_some(), "{name} {cut}: {error}");
                }
            }
        }
        assert_eq!(before, expected.len(), "{name}");
    }
}

#[test]
fn half_a_database_gives_what_is_in_the_half() {
    let whole = std::fs::read(folder().join("sqlite/sqlite.db3")).unwrap();
    let dir = tempfile::tempdir().unwrap();
    let expected = expected();
    for pages in 1..whole.len() / 4096 {
        let path = dir.path().join("cut.db3");
        std::fs::write(&path, &whole[..4096 * pages]).unwrap();
        match read_log(&path, &LogOptions::default()) {
            Ok(log) => {
                let found = log.recording.samples();
                assert_eq!(found, &expected[..found.len()]);
                assert!(log.damage.is_some() || found.len() == expected.len(), "{pages}");
            }
            Err(error) => assert!(error.hint().is_some(), "{error}"),
        }
    }
}

#[test]
fn paths_without_a_log_say_what_was_looked_for() {
    let dir = tempfile::tempdir().unwrap();
    let error = read_log(dir.path(), &LogOptions::default()).unwrap_err();
    assert!(
        error.to_string().ends_with("looked for mav0/imu0/data.csv, imu0/data.csv, *.mcap, *.db3"),
        "{error}"
    );
    let deeper = dir.path().join("flight/mav0/imu0");
    std::fs::create_dir_all(&deeper).unwrap();
    std::fs::write(deeper.join("data.csv"), "").unwrap();
    let hint = read_log(dir.path(), &LogOptions::default()).unwrap_err().hint().unwrap();
    assert!(
        hint.starts_with("there are 1 below it: give one, for example ") && hint.ends_with("flight"),
        "{hint}"
    );
    let packed = dir.path().join("a.mcap.zst");
    std::fs::write(&packed, b"\x28\xb5\x2f\xfdxxxx").unwrap();
    let error = read_log(&packed, &LogOptions::default()).unwrap_err();
    assert!(matches!(error, LogError::Packed { .. }), "{error}");
    let gone = read_log(&dir.path().join("gone.bag"), &LogOptions::default()).unwrap_err();
    assert!(gone.to_string().ends_with("gone.bag does not exist"), "{gone}");
    let other = dir.path().join("a.bag");
    std::fs::write(&other, b"t,gx,gy\n").unwrap();
    let error = read_log(&other, &LogOptions::default()).unwrap_err();
    assert!(error.to_string().ends_with("does not begin as a bag file does"), "{error}");
}
