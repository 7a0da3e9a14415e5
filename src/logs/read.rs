//! The one way in.

use crate::topics::Topics;
use crate::{Kind, Log, LogError, mcap, rosbag1, rosbag2, sqlite};
use dpn_core::ImuRecording;
use dpn_io::asl::Sequence;
use dpn_io::{CsvOptions, IoError, LooseImuLog, Origin, Sieved, read_imu_csv_loosely};
use std::fs::File;
use std::io::{BufReader, Read};
use std::path::Path;

/// Share of the samples whose stamps may go back.
const TOLERATED: f64 = 0.1;

/// What the caller knows about a log.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct LogOptions {
    /// Columns and units of a CSV file.
    pub csv: CsvOptions,
    /// The bag's topic; without it, its only IMU.
    pub topic: Option<String>,
}

/// Reads whatever log is at `path`.
///
/// # Errors
/// See [`LogError`]: nothing there, nothing of use in it, several IMUs and no choice. Damage is none as long as two samples stand before it.
pub fn read_log(path: &Path, options: &LogOptions) -> Result<Log, LogError> {
    let kind = Kind::of(path)?;
    let open = || File::open(path).map(BufReader::new).map_err(|e| IoError::reading(path, e));
    let mut topics = Topics::new(options);
    let damage = match kind {
        Kind::Asl | Kind::Csv => return text(path, kind, options),
        Kind::Rosbag1 => rosbag1::read(open()?, &mut topics).map_err(|e| IoError::reading(path, e))?,
        Kind::Mcap => mcap::read(open()?, &mut topics).map_err(|e| IoError::reading(path, e))?,
        Kind::Sqlite => sqlite::read(path, &mut topics),
        Kind::Rosbag2 => rosbag2::read(path, &mut topics)?,
    };
    bag(path, kind, topics, damage)
}

/// A ROS 1 bag from any source of bytes; `path` is for messages.
///
/// # Errors
/// As [`read_log`].
pub fn read_rosbag1(source: impl Read, path: &Path, options: &LogOptions) -> Result<Log, LogError> {
    let mut topics = Topics::new(options);
    let damage = rosbag1::read(source, &mut topics).map_err(|e| IoError::reading(path, e))?;
    bag(path, Kind::Rosbag1, topics, damage)
}

/// An MCAP file from any source of bytes; `path` is for messages.
///
/// # Errors
/// As [`read_log`].
pub fn read_mcap(source: impl Read, path: &Path, options: &LogOptions) -> Result<Log, LogError> {
    let mut topics = Topics::new(options);
    let damage = mcap::read(source, &mut topics).map_err(|e| IoError::reading(path, e))?;
    bag(path, Kind::Mcap, topics, damage)
}

/// One of rosbag2's SQLite files.
///
/// # Errors
/// As [`read_log`].
pub fn read_sqlite(path: &Path, options: &LogOptions) -> Result<Log, LogError> {
    let mut topics = Topics::new(options);
    let damage = sqlite::read(path, &mut topics);
    bag(path, Kind::Sqlite, topics, damage)
}

fn bag(path: &Path, kind: Kind, topics: Topics, damage: Option<String>) -> Result<Log, LogError> {
    let chosen = topics.choose(path, damage.as_deref())?;
    goes_forward(path, &chosen.sieved, chosen.samples.len())?;
    if chosen.samples.len() < 2 {
        return Err(LogError::TooFew {
            path: path.to_path_buf(),
            topic: chosen.topic,
            found: chosen.samples.len(),
            reason: damage.or_else(|| chosen.remarks.first().cloned()),
        });
    }
    let recording = ImuRecording::new(chosen.samples).expect("a sieve lets finite samples in order through");
    Ok(Log {
        kind,
        topic: Some(chosen.topic),
        recording,
        sieved: chosen.sieved,
        place: "message",
        damage,
        guesses: Vec::new(),
        remarks: chosen.remarks,
    })
}

fn goes_forward(path: &Path, sieved: &Sieved, kept: usize) -> Result<(), LogError> {
    let of = kept + sieved.count();
    match sieved.backward.first {
        Some(first) if sieved.backward.count as f64 > TOLERATED * of as f64 => {
            Err(LogError::Backward { path: path.to_path_buf(), count: sieved.backward.count, of, first })
        }
        _ => Ok(()),
    }
}

fn text(path: &Path, kind: Kind, options: &LogOptions) -> Result<Log, LogError> {
    if options.topic.is_some() {
        return Err(LogError::NoTopicsHere { path: path.to_path_buf(), kind: kind.name() });
    }
    let file = match kind {
        Kind::Asl => Sequence::open(path)?.imu_path(),
        _ => path.to_path_buf(),
    };
    let loose = read_imu_csv_loosely(&file, &options.csv)?;
    let LooseImuLog { recording, columns, time, gyro, accel, sieved, unreadable } = loose;
    let mut log = Log { sieved, ..Log::sound(kind, recording) };
    match unreadable.first {
        Some(first) if unreadable.cut => log.damage = Some(format!("its last line is cut off ({first})")),
        Some(first) => {
            log.remarks.push(format!(
                "left out: {} row(s) that cannot be read, the first: {first}",
                unreadable.count
            ));
        }
        None => {}
    }
    let guess = |origin| matches!(origin, Origin::Guessed | Origin::Assumed);
    let mut guessed = |is: bool, text: String| {
        if is {
            log.guesses.push(text);
        }
    };
    let order = if columns.value.gyro[0] < columns.value.accel[0] {
        "gyroscope, accelerometer"
    } else {
        "accelerometer, gyroscope"
    };
    guessed(guess(columns.origin), format!("columns as stamp, {order} (--columns)"));
    guessed(guess(time.origin), format!("stamps in {} (--time-unit)", time.value));
    guessed(guess(gyro.origin), format!("gyroscope in {} (--gyro-unit)", gyro.value.name()));
    guessed(guess(accel.origin), format!("accelerometer in {} (--accel-unit)", accel.value.name()));
    Ok(log)
}
