//! The one way in.

use crate::kind::HEAD;
use crate::topics::Topics;
use crate::{Kind, Log, LogError, mcap, rosbag1, rosbag2, sqlite};
use dpn_core::ImuRecording;
use dpn_io::asl::{Sequence, is_there};
use dpn_io::{CsvOptions, IoError, LooseImuLog, Origin, Sieved, parse_imu_csv_loosely, scratch_file};
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
    /// Bytes that a bag's chunks may unpack to, all together; without it, 32 MB and 32 times the packed ones.
    pub max_uncompressed: Option<u64>,
}

/// Reads whatever log is at `path`: a folder, a file, a sequence of a data pack (`PACK/NAME`), a pipe, or stdin for `-`. Files and pipes are opened once and read once through.
///
/// # Errors
/// See [`LogError`]: nothing there, nothing of use in it, several IMUs and no choice. Damage is none as long as two samples stand before it.
pub fn read_log(path: &Path, options: &LogOptions) -> Result<Log, LogError> {
    if path == Path::new("-") {
        return read_stream(std::io::stdin().lock(), Path::new("stdin"), options);
    }
    let reading = |e| IoError::reading(path, e);
    if !path.is_dir() && is_there(path) {
        return match options.topic {
            Some(_) => Err(LogError::NoTopicsHere { path: path.to_path_buf(), kind: "data pack" }),
            None => Ok(Log::sound(Kind::Asl, Sequence::open(path)?.imu()?)),
        };
    }
    if !path.is_dir() {
        return read_stream(File::open(path).map_err(reading)?, path, options);
    }
    match Kind::of(path)? {
        Kind::Rosbag2 => {
            let mut topics = Topics::new(options);
            let damage = rosbag2::read(path, &mut topics)?;
            bag(path, Kind::Rosbag2, topics, damage)
        }
        kind => {
            let file = Sequence::open(path)?.imu_path();
            let source = File::open(&file).map_err(|e| IoError::reading(&file, e))?;
            text(source, &file, path, kind, options)
        }
    }
}

/// Reads a log of any kind from bytes as they come; `path` is for messages. A database, whose reader must seek, is copied to a
/// temporary file first where `path` is no file to seek in.
///
/// # Errors
/// As [`read_log`].
pub fn read_stream(mut source: impl Read, path: &Path, options: &LogOptions) -> Result<Log, LogError> {
    let reading = |e| IoError::reading(path, e);
    let mut head = Vec::new();
    source.by_ref().take(HEAD).read_to_end(&mut head).map_err(reading)?;
    let kind = Kind::of_head(&head, path)?;
    let mut source = BufReader::new(head.chain(source));
    match kind {
        Kind::Rosbag1 => read_rosbag1(source, path, options),
        Kind::Mcap => read_mcap(source, path, options),
        Kind::Sqlite if path.is_file() => read_sqlite(path, options),
        Kind::Sqlite => {
            let mut copy = scratch_file().map_err(reading)?;
            std::io::copy(&mut source, &mut copy).map_err(reading)?;
            let mut topics = Topics::new(options);
            let damage = sqlite::read(copy.path(), &mut topics);
            let mut log = bag(path, Kind::Sqlite, topics, damage)?;
            log.remarks.push(
                "a database cannot be read as it comes: it was copied to a temporary file first".to_owned(),
            );
            Ok(log)
        }
        Kind::Asl | Kind::Csv | Kind::Rosbag2 => text(source, path, path, kind, options),
    }
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

/// A text log: `file` names its rows, `path` the whole.
fn text(
    source: impl Read,
    file: &Path,
    path: &Path,
    kind: Kind,
    options: &LogOptions,
) -> Result<Log, LogError> {
    if options.topic.is_some() {
        return Err(LogError::NoTopicsHere { path: path.to_path_buf(), kind: kind.name() });
    }
    let loose = parse_imu_csv_loosely(source, file, &options.csv)?;
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
