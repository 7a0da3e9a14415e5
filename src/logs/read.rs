//! The one way in.

#[cfg(feature = "blackbox")]
use crate::blackbox;
use crate::imu_file::ImuFile;
use crate::log::other_parts;
use crate::long::{Long, gyro_and_accel};
use crate::plain::Coding;
use crate::records::Records;
use crate::topics::{Topics, shortened};
use crate::two_files::{Source, TwoFiles};
use crate::{
    Kind, Log, LogError, LogOptions, Scales, ardupilot, bag, gcsv, json, oxiod, rosbag2, serial_monitor, ulog,
};
use dpn_core::{ImuSample, Sensor};
use dpn_io::asl::Sequence;
use dpn_io::{
    AccelUnit, GyroUnit, ImuColumns, IoError, LooseImuLog, OneEach, Origin, SampleStore, Settled,
    StoredRecording, Understood, names_all, only_sensor, parse_imu_csv_loosely, parse_one_sensor_loosely,
    printable, settle_units,
};
use std::fs::File;
#[cfg(feature = "zip")]
use std::io::Seek;
use std::io::{BufReader, Read};
use std::path::Path;

/// Bytes of a text file in which rows of several sensors are looked for.
const LOOKED_AT: u64 = 1 << 16;

/// Reads whatever log is at `path`: a folder, a file, a pipe, or stdin for `-`. Files and pipes are opened once and read once through.
///
/// # Errors
/// See [`LogError`]: nothing there, nothing of use in it, several IMUs and no choice. Damage is none as long as two samples stand before it.
pub fn read_log(path: &Path, options: &LogOptions) -> Result<Log, LogError> {
    options.span.of(read_whole(path, options)?, path)
}

fn read_whole(path: &Path, options: &LogOptions) -> Result<Log, LogError> {
    if path == Path::new("-") {
        return stream(std::io::stdin().lock(), Path::new("stdin"), options);
    }
    let reading = |e| IoError::reading(path, e);
    if !path.is_dir() {
        let file = File::open(path).map_err(reading)?;
        #[cfg(feature = "zip")]
        if is_archive(&file).map_err(reading)? {
            let read_stream = |source: &mut dyn Read, path: &Path| stream(source, path, options);
            return crate::zipped::read(file, path, options, &read_stream, &|tables| {
                two_files(tables, path, options)
            });
        }
        return stream(file, path, options);
    }
    let kind = match Kind::of(path) {
        // A folder of images with the IMU's file beside them.
        Err(LogError::NoLog { below, .. }) if below.is_empty() && ImuFile::of(path).is_ok() => {
            return read_whole(ImuFile::of(path)?.path(), options);
        }
        kind => kind?,
    };
    match kind {
        Kind::Rosbag2 => {
            let mut topics = Topics::new(options);
            let damage = rosbag2::read(path, &mut topics)?;
            bag_log(path, Kind::Rosbag2, topics, damage, options)
        }
        Kind::TwoFiles => match TwoFiles::find(path)? {
            Some(files) => two_files(files, path, options),
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
    options.span.of(stream(source, path, options)?, path)
}

fn stream(source: impl Read, path: &Path, options: &LogOptions) -> Result<Log, LogError> {
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
        #[cfg(feature = "blackbox")]
        Kind::Blackbox => {
            let (mut records, mut bytes) = (Records::default(), Vec::new());
            let mut source = source;
            source.read_to_end(&mut bytes).map_err(|e| IoError::reading(path, e))?;
            match blackbox::read(&bytes, &mut records) {
                Some(why) if records.are_none() => {
                    let what = format!(
                        "{why}; decode it by `blackbox_decode --unit-acceleration g FILE` of blackbox-tools, and give the CSV that it writes"
                    );
                    Err(LogError::Damaged { path: path.to_path_buf(), what })
                }
                damage => records.log(path, kind, damage, options),
            }
        }
        #[cfg(not(feature = "blackbox"))]
        Kind::Blackbox => {
            Err(LogError::NoImu { path: path.to_path_buf(), topics: String::new(), damage: None })
        }
        Kind::Json | Kind::Echo => json_text(source, path, kind, options),
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

fn without_topic(path: &Path, kind: Kind, options: &LogOptions) -> Result<(), LogError> {
    let (path, flag, of, kind) = (path.to_path_buf(), "--topic", "bags", kind.name());
    options.topic.as_ref().map_or(Ok(()), |_| Err(LogError::NotHere { path, flag, of, kind }))
}

/// A folder with a file of each sensor.
fn two_files(files: TwoFiles, dir: &Path, options: &LogOptions) -> Result<Log, LogError> {
    match files.pasted(dir, options)? {
        Some(rows) => text(rows.as_bytes(), dir, dir, Kind::TwoFiles, options),
        None => files.read(dir, options),
    }
}

/// A log of objects with both sensors, or of one each.
fn json_text(mut source: impl Read, path: &Path, kind: Kind, options: &LogOptions) -> Result<Log, LogError> {
    without_topic(path, kind, options)?;
    let mut bytes = Vec::new();
    source.read_to_end(&mut bytes).map_err(|e| IoError::reading(path, e))?;
    let (mut tables, damage) = if kind == Kind::Echo { json::echoed(&bytes) } else { json::tables(&bytes) };
    drop(bytes);
    let whole = tables.iter().position(|table| names_all(&table.names));
    let log = match (whole, gyro_and_accel(&tables.iter().map(|table| table.sensor.as_str()))) {
        (Some(whole), _) => text(tables.swap_remove(whole).text.as_bytes(), path, path, kind, options)?,
        (None, [Some(gyro), Some(accel)]) => {
            let (gyro, accel) = (gyro.to_owned(), accel.to_owned());
            let mut of = |name: String| {
                let at =
                    tables.iter().position(|table| table.sensor == name).expect("it was found among them");
                Source::Text(name, tables.swap_remove(at).text, path.to_path_buf())
            };
            TwoFiles::of(of(gyro), of(accel)).read(path, options)?
        }
        (None, found) => {
            let alone = |name: &str, sensor: &str| {
                format!(
                    "of the {sensor} alone (`{}`); give the folder in which the other sensor's lies too",
                    printable(name)
                )
            };
            let shown = |t: &json::Table| format!("{}: {}", t.sensor, t.names.join(" "));
            let names = tables.iter().map(|t| printable(shown(t).trim_start_matches(": ")));
            let problem = match (found, damage) {
                ([Some(gyro), _], _) => alone(gyro, "gyroscope"),
                ([_, Some(accel)], _) => alone(accel, "accelerometer"),
                (_, Some(damage)) if tables.is_empty() => format!("that cannot be read: {damage}"),
                _ => format!(
                    "without samples that are known; it has {}",
                    shortened(names.collect::<Vec<_>>().into_iter())
                ),
            };
            let what = if kind == Kind::Echo { "messages" } else { "JSON" };
            return Err(LogError::Json { path: path.to_path_buf(), what, problem });
        }
    };
    Ok(Log { kind, damage: damage.or(log.damage), ..log })
}

/// A recording of one sensor: the other's axes become zeros, and a unit that nobody named is told from the numbers.
fn of_one(
    recording: StoredRecording,
    sensor: Sensor,
    understood: &mut Understood,
) -> std::io::Result<StoredRecording> {
    let only = |s: ImuSample| {
        Some(match sensor {
            Sensor::Gyro => ImuSample { accel: [0.0; 3], ..s },
            Sensor::Accel => ImuSample { gyro: [0.0; 3], ..s },
        })
    };
    let samples = recording.into_store().changed(only)?;
    // What was named is converted already.
    let named = |origin| if origin == Origin::Assumed { origin } else { Origin::Header };
    let gyro = Settled { value: GyroUnit::RadPerSecond, origin: named(understood.gyro.origin) };
    let accel = Settled { value: AccelUnit::MetrePerSecond2, origin: named(understood.accel.origin) };
    let (samples, gyro, accel) = settle_units(samples, gyro, accel)?;
    if gyro.origin == Origin::Guessed {
        understood.gyro = gyro;
    }
    if accel.origin == Origin::Guessed {
        understood.accel = accel;
    }
    Ok(samples.recording()?.expect("as many samples as before"))
}

/// A text log: `file` names its rows, `path` the whole.
fn text(
    source: impl Read,
    file: &Path,
    path: &Path,
    kind: Kind,
    options: &LogOptions,
) -> Result<Log, LogError> {
    without_topic(path, kind, options)?;
    let mut head = Vec::new();
    let mut source = source;
    source.by_ref().take(LOOKED_AT).read_to_end(&mut head).map_err(|e| IoError::reading(file, e))?;
    if let Some(coding) = Coding::of(&head) {
        let plain = coding.plain(std::io::Cursor::new(head).chain(source));
        return text(plain, file, path, kind, options);
    }
    let mut whole = |mut bytes: Vec<u8>| {
        source.read_to_end(&mut bytes).map_err(|e| IoError::reading(file, e))?;
        let text = String::from_utf8(bytes);
        Ok::<_, IoError>(text.unwrap_or_else(|e| String::from_utf8_lossy(e.as_bytes()).into_owned()))
    };
    if serial_monitor::is(&head) {
        return text(serial_monitor::table(&whole(head)?).as_bytes(), file, path, kind, options);
    }
    if let Some(long) = Long::of(&head) {
        let text = whole(head)?;
        let of = |name: &str| Source::Text(name.to_owned(), long.rows_of(&text, name), file.to_path_buf());
        let log = TwoFiles::of(of(&long.gyro), of(&long.accel)).read(path, options)?;
        return Ok(Log { kind, ..log });
    }
    let is_told = options.csv.columns.is_some() || options.csv.rate.is_some();
    if !is_told && let Some(table) = OneEach::of(&head) {
        let text = whole(head)?;
        let [gyro, accel] = [Sensor::Gyro, Sensor::Accel].map(|sensor| {
            let name = format!("the {sensor}'s rows");
            Source::Text(name, table.rows_of(&text, sensor), file.to_path_buf())
        });
        let log = TwoFiles::of(gyro, accel).read(path, options)?;
        return Ok(Log { kind, ..log });
    }
    if oxiod::is(&head) {
        let mut log = text(oxiod::table(&whole(head)?).as_bytes(), file, path, kind, options)?;
        log.guesses.insert(0, oxiod::WORDS.to_owned());
        return Ok(log);
    }
    let preamble = gcsv::scaled(&head, options);
    let options = preamble.as_ref().map_or(options, |(scaled, _)| scaled);
    // A scale is instead of a unit.
    let mut csv = options.csv.clone();
    csv.gyro = options.scales.gyro.map_or(csv.gyro, |_| Some(GyroUnit::RadPerSecond));
    csv.accel = options.scales.accel.map_or(csv.accel, |_| Some(AccelUnit::MetrePerSecond2));
    let alone = only_sensor(&head, csv.rate.is_some()).filter(|_| csv.columns.is_none());
    let source = std::io::Cursor::new(head).chain(source);
    let mut loose = match alone {
        Some(sensor) => parse_one_sensor_loosely(source, file, &csv, sensor)?,
        None => parse_imu_csv_loosely(source, file, &csv)?,
    };
    if let Some(sensor) = alone {
        loose.recording =
            of_one(loose.recording, sensor, &mut loose.understood).map_err(|e| IoError::reading(file, e))?;
        loose.others.clear();
    }
    let LooseImuLog { recording, places, others, understood, sieved, unreadable, wraps, said_hz } = loose;
    let Understood { columns, time, gyro, accel, passed, .. } = understood;
    let recording = match options.scales == Scales::default() {
        true => recording,
        false => scaled(recording.into_store(), path, options)?,
    };
    let others = other_parts(others, places, |samples| options.scales.apply(samples));
    let others = others.map_err(|e| IoError::reading(file, e))?;
    let mut log = Log { alone, sieved, places, others, said_hz, ..Log::sound(kind, recording) };
    log.guesses.extend(preamble.as_ref().map(|(_, words)| words.clone()));
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
        alone.is_none() && guess(columns.origin),
        match columns.value {
            ImuColumns::ROS2_ECHO => {
                "columns as `ros2 topic echo --csv` prints an IMU's message (--columns)".to_owned()
            }
            _ if options.csv.rate.is_some() => format!("columns as {order} (--columns)"),
            ImuColumns { time: 1, .. } if columns.origin == Origin::Assumed => {
                format!("columns as row number, stamp, {order} (--columns)")
            }
            ImuColumns { time: 6, .. } => format!("columns as {order}, stamp (--columns)"),
            _ => format!("columns as stamp, {order} (--columns)"),
        },
    );
    for passed in passed {
        let flag = if passed.contains(" from `") { " (--columns)" } else { "" };
        guessed(true, format!("{passed}{flag}"));
    }
    if wraps > 0 {
        guessed(true, format!("stamps a counter of 32 bits that began anew {wraps} time(s)"));
    }
    if columns.value.intervals != [None; 2] {
        guessed(true, "increments divided by their intervals".to_owned());
    }
    guessed(guess(time.origin), format!("stamps in {} (--time-unit)", time.value));
    guessed(
        alone != Some(Sensor::Accel) && guess(gyro.origin),
        format!("gyroscope in {} (--gyro-unit)", gyro.value.name()),
    );
    guessed(
        alone != Some(Sensor::Gyro) && guess(accel.origin),
        format!("accelerometer in {} (--accel-unit)", accel.value.name()),
    );
    Ok(log)
}
