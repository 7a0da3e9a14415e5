//! The one way in.

use crate::records::Records;
use crate::topics::Topics;
use crate::two_files::TwoFiles;
use crate::{Kind, Log, LogError, LogOptions, Scales, ardupilot, bag, rosbag2, ulog};
use dpn_io::asl::Sequence;
use dpn_io::{
    AccelUnit, GyroUnit, ImuColumns, IoError, LooseImuLog, Origin, SampleStore, StoredRecording, Understood,
    parse_imu_csv_loosely,
};
use std::fs::File;
#[cfg(feature = "zip")]
use std::io::Seek;
use std::io::{BufReader, Read};
use std::path::Path;

/// Reads whatever log is at `path`: a folder, a file, a pipe, or stdin for `-`. Files and pipes are opened once and read once through.
///
/// # Errors
/// See [`LogError`]: nothing there, nothing of use in it, several IMUs and no choice. Damage is none as long as two samples stand before it.
pub fn read_log(path: &Path, options: &LogOptions) -> Result<Log, LogError> {
    if path == Path::new("-") {
        return read_stream(std::io::stdin().lock(), Path::new("stdin"), options);
    }
    let reading = |e| IoError::reading(path, e);
    if !path.is_dir() {
        let file = File::open(path).map_err(reading)?;
        #[cfg(feature = "zip")]
        if is_archive(&file).map_err(reading)? {
            return crate::zipped::read(file, path, options, &|source, path| {
                read_stream(source, path, options)
            });
        }
        return read_stream(file, path, options);
    }
    match Kind::of(path)? {
        Kind::Rosbag2 => {
            let mut topics = Topics::new(options);
            let damage = rosbag2::read(path, &mut topics)?;
            bag_log(path, Kind::Rosbag2, topics, damage, options)
        }
        Kind::TwoFiles => match TwoFiles::find(path)? {
            Some(files) => files.read(path, options),
            None => Err(LogError::NoLog { dir: path.to_path_buf(), below: Vec::new() }),
        },
        kind => {
            let file = Sequence::open(path)?.imu_path();
            let source = File::open(&file).map_err(|e| IoError::reading(&file, e))?;
            text(source, &file, path, kind, options)
        }
    }
}

/// Whether a file, in which one can seek, begins as a zip archive does; it stands at its beginning again.
#[cfg(feature = "zip")]
fn is_archive(mut file: &File) -> std::io::Result<bool> {
    let mut head = Vec::new();
    if file.metadata()?.is_file() {
        file.take(crate::detect::HEAD).read_to_end(&mut head)?;
        file.rewind()?;
    }
    Ok(crate::detect::is_zip(&head))
}

/// Reads a log of any kind, packed or not, from bytes as they come; `path` is for messages. A database, whose reader must seek, is copied to a
/// temporary file first where `path` is no file to seek in.
///
/// # Errors
/// As [`read_log`].
pub fn read_stream(source: impl Read, path: &Path, options: &LogOptions) -> Result<Log, LogError> {
    let (log, damage) = bag::unpacked(source, path, options.max_uncompressed, |head, plain, is_file| {
        read_plain(head, plain, path, is_file, options)
    })?;
    Ok(Log { damage: damage.or(log.damage), ..log })
}

/// Reads what is not packed; `is_file` where these bytes lie at `path`.
fn read_plain(
    head: &[u8],
    source: impl Read,
    path: &Path,
    is_file: bool,
    options: &LogOptions,
) -> Result<Log, LogError> {
    let kind = Kind::of_head(head, path)?;
    match kind {
        Kind::Rosbag1 | Kind::Mcap | Kind::Sqlite => bag_file(kind, source, path, is_file, options),
        Kind::Ulog | Kind::Ardupilot | Kind::ArdupilotText => {
            let (mut records, source) = (Records::default(), BufReader::new(source));
            let damage = match kind {
                Kind::Ulog => ulog::read(source, &mut records),
                Kind::Ardupilot => ardupilot::read(source, &mut records),
                _ => ardupilot::read_text(source, &mut records),
            };
            records.log(path, kind, damage.map_err(|e| IoError::reading(path, e))?, options)
        }
        Kind::Asl | Kind::Csv | Kind::Rosbag2 | Kind::TwoFiles => text(source, path, path, kind, options),
    }
}

/// A bag of this kind, not packed, from any source of bytes; `path` is for messages.
///
/// # Errors
/// As [`read_log`]; a kind that is no bag's file.
pub fn read_bag(kind: Kind, source: impl Read, path: &Path, options: &LogOptions) -> Result<Log, LogError> {
    bag_file(kind, source, path, false, options)
}

/// The same; `is_file` where these bytes lie at `path`.
fn bag_file(
    kind: Kind,
    source: impl Read,
    path: &Path,
    is_file: bool,
    options: &LogOptions,
) -> Result<Log, LogError> {
    let mut topics = Topics::new(options);
    let damage = bag::plainly(kind, BufReader::new(source), path, is_file, &mut topics)?;
    let mut log = bag_log(path, kind, topics, damage, options)?;
    if kind == Kind::Sqlite && !is_file {
        log.remarks.push(
            "a database cannot be read as it comes: it was copied to a temporary file first".to_owned(),
        );
    }
    Ok(log)
}

pub(crate) fn bag_log(
    path: &Path,
    kind: Kind,
    topics: Topics,
    damage: Option<String>,
    options: &LogOptions,
) -> Result<Log, LogError> {
    topics.choose(path, damage.as_deref())?.log(path, kind, "message", damage, options)
}

fn scaled(samples: SampleStore, path: &Path, options: &LogOptions) -> Result<StoredRecording, LogError> {
    let recording = options.scales.apply(samples).and_then(SampleStore::recording);
    let short = |found| IoError::TooShort { path: path.to_path_buf(), found };
    Ok(recording.map_err(|e| IoError::reading(path, e))?.map_err(short)?)
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
    // A scale is instead of a unit.
    let mut csv = options.csv.clone();
    csv.gyro = options.scales.gyro.map_or(csv.gyro, |_| Some(GyroUnit::RadPerSecond));
    csv.accel = options.scales.accel.map_or(csv.accel, |_| Some(AccelUnit::MetrePerSecond2));
    let loose = parse_imu_csv_loosely(source, file, &csv)?;
    let LooseImuLog { recording, understood, sieved, unreadable, wraps, said_hz } = loose;
    let Understood { columns, time, gyro, accel, passed, .. } = understood;
    let recording = match options.scales == Scales::default() {
        true => recording,
        false => scaled(recording.into_store(), path, options)?,
    };
    let mut log = Log { sieved, said_hz, ..Log::sound(kind, recording) };
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
    guessed(
        guess(columns.origin),
        match columns.value {
            ImuColumns::ROS2_ECHO => {
                "columns as `ros2 topic echo --csv` prints an IMU's message (--columns)".to_owned()
            }
            _ => format!("columns as stamp, {order} (--columns)"),
        },
    );
    for passed in passed {
        guessed(true, format!("{passed} (--columns)"));
    }
    if wraps > 0 {
        guessed(true, format!("stamps a counter of 32 bits that began anew {wraps} time(s)"));
    }
    if columns.value.intervals != [None; 2] {
        guessed(true, "increments divided by their intervals".to_owned());
    }
    guessed(guess(time.origin), format!("stamps in {} (--time-unit)", time.value));
    guessed(guess(gyro.origin), format!("gyroscope in {} (--gyro-unit)", gyro.value.name()));
    guessed(guess(accel.origin), format!("accelerometer in {} (--accel-unit)", accel.value.name()));
    Ok(log)
}
