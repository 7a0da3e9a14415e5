//! Bags written by PyPI's `rosbags` and `mcap-ros2-support`, whole and damaged.

use crate::{Kind, Log, LogError, LogOptions, read_bag, read_log};
use dpn_core::{ImuSample, Samples, Stamp};
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
        ("ros1.mcap", Kind::Mcap),
        ("big_endian.mcap", Kind::Mcap),
        ("packed_messages", Kind::Rosbag2),
        ("packed_messages/packed_messages.db3", Kind::Sqlite),
    ] {
        let log = open(name, None).unwrap();
        assert_eq!((log.kind, log.topic.as_deref()), (kind, Some("/imu0")), "{name}");
        assert_eq!(*log.recording.all().unwrap(), expected, "{name}");
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
    assert_eq!(*second.recording.all().unwrap(), moved);
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

/// What is not known is named: the encoding of a channel, the representation of a message, a message's broken compression.
#[test]
fn messages_that_cannot_be_understood_say_how_they_are_written() {
    for topic in [None, Some("/imu0")] {
        let error = open("json.mcap", topic).unwrap_err();
        assert!(
            error
                .to_string()
                .ends_with("the messages on `/imu0` are written as `json`; known are cdr and ros1"),
            "{error}"
        );
        assert!(error.hint().unwrap().starts_with("convert the bag to ROS 2's cdr"));
    }
    // Delimited CDR2 in all messages: the representation stands behind their stamps in the file.
    let mut bytes = std::fs::read(folder().join("plain.mcap")).unwrap();
    let header = [0, 1, 0, 0];
    let stamp = 1_600_000_000u32.to_le_bytes();
    let pattern: Vec<u8> = [header, stamp].concat();
    let places: Vec<usize> = (0..bytes.len() - 8).filter(|&i| bytes[i..i + 8] == pattern[..]).collect();
    assert_eq!(places.len(), 12);
    for &i in &places {
        bytes[i + 1] = 9;
    }
    let error =
        read_bag(Kind::Mcap, strip_checksums(bytes).as_slice(), Path::new("a.mcap"), &LogOptions::default());
    let error = error.unwrap_err();
    assert_eq!(error.to_string(), "a.mcap: 0 sample(s) of use on /imu0; a recording needs at least 2");
    assert_eq!(
        error.hint().unwrap(),
        "12 of 12 messages on /imu0 are in delimited CDR (XCDR2, 0x0009), which is not known; they are left out; \
         copy, convert or record it again"
    );
    let whole = std::fs::read(folder().join("packed_messages/packed_messages.db3")).unwrap();
    let frame = b"\x28\xb5\x2f\xfd";
    // The third message as it lies in the file: its compressed content is broken.
    let at = (0..whole.len() - 4).filter(|&i| whole[i..i + 4] == frame[..]).nth(2).unwrap();
    let mut broken = whole.clone();
    broken[at + 4..at + 12].fill(0xff);
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("broken.db3");
    std::fs::write(&path, broken).unwrap();
    let log = read_log(&path, &LogOptions::default()).unwrap();
    assert!(log.recording.len() < 12, "{}", log.recording.len());
    assert!(log.warnings()[0].contains("bad zstd data"), "{:?}", log.warnings());
}

/// Sets the checksum of every chunk to 0, which says that there is none.
fn strip_checksums(mut bytes: Vec<u8>) -> Vec<u8> {
    let mut at = 8;
    while at + 9 < bytes.len() {
        let length = u64::from_le_bytes(bytes[at + 1..at + 9].try_into().unwrap()) as usize;
        if bytes[at] == 6 {
            bytes[at + 9 + 24..at + 9 + 28].fill(0);
        }
        at += 9 + length;
    }
    bytes
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
                read_bag(Kind::Rosbag1, bytes, path, &options)
            } else {
                read_bag(Kind::Mcap, bytes, path, &options)
            };
            match read {
                Ok(log) => {
                    let found = log.recording.all().unwrap();
                    assert_eq!(*found, expected[..found.len()], "{name} {cut}");
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
fn a_bag_whose_record_lacks_a_field_says_so() {
    let path = folder().join("plain.bag");
    let whole = std::fs::read(&path).unwrap();
    for (field, damaged) in [("conn=", "conm="), ("time=", "tine="), ("compression=", "compresion_=")] {
        let mut bytes = whole.clone();
        let places: Vec<usize> =
            (0..bytes.len() - field.len()).filter(|at| bytes[*at..].starts_with(field.as_bytes())).collect();
        // In the middle of the bag: what stands before it is still read.
        let at = places[places.len() / 2];
        bytes[at..at + field.len()].copy_from_slice(damaged.as_bytes());
        match read_bag(Kind::Rosbag1, bytes.as_slice(), &path, &LogOptions::default()) {
            Ok(log) => {
                assert!(log.damage.as_ref().is_some_and(|d| d.contains("lacks")), "{field} {:?}", log.damage);
            }
            Err(error) => assert!(error.to_string().contains("lacks"), "{field}: {error}"),
        }
    }
}

#[test]
fn rows_of_a_database_that_hold_no_message_are_counted() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("a.db3");
    std::fs::copy(folder().join("sqlite/sqlite.db3"), &path).unwrap();
    let database = rusqlite::Connection::open(&path).unwrap();
    let rows =
        database.execute("UPDATE messages SET data = 7 WHERE id IN (SELECT MAX(id) FROM messages)", ());
    assert_eq!(rows.unwrap(), 1);
    drop(database);
    let log = read_log(&path, &LogOptions::default()).unwrap();
    assert_eq!(log.recording.len() + 1, expected().len());
    assert!(log.damage.as_ref().is_some_and(|d| d.starts_with("1 of its ")), "{:?}", log.damage);
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
                let found = log.recording.all().unwrap();
                assert_eq!(*found, expected[..found.len()]);
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
        error.to_string().ends_with(
            "looked for mav0/imu0/data.csv, imu0/data.csv, *.mcap, *.db3, a *gyro* and an *accel* file"
        ),
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
    assert!(matches!(error, LogError::Damaged { .. }), "{error}");
    // In a folder it is one of a bag's files.
    let folder = tempfile::tempdir().unwrap();
    std::fs::rename(&packed, folder.path().join("a.mcap.zst")).unwrap();
    let error = read_log(folder.path(), &LogOptions::default()).unwrap_err();
    assert!(matches!(error, LogError::Packed { .. }), "{error}");
    let gone = read_log(&dir.path().join("gone.bag"), &LogOptions::default()).unwrap_err();
    assert!(gone.to_string().ends_with("gone.bag does not exist"), "{gone}");
    let other = dir.path().join("a.bag");
    std::fs::write(&other, b"t,gx,gy\n").unwrap();
    let error = read_log(&other, &LogOptions::default()).unwrap_err();
    assert!(error.to_string().ends_with("does not begin as a bag file does"), "{error}");
}
