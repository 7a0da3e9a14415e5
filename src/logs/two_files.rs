//! A phone's log: a folder with a file for the gyroscope and one for the accelerometer (Sensor Logger, phyphox), joined.

use crate::join::join;
use crate::{Kind, Log, LogError, LogOptions};
use dpn_core::signal::ranks::{Column, Level, levels};
use dpn_core::{ImuSample, Samples, Sensor};
use dpn_io::{
    AccelUnit, GyroUnit, IoError, LooseImuLog, Origin, SampleStore, Settled, StoredRecording,
    parse_one_sensor_loosely, printable, settle_units,
};
use std::fs::File;
use std::io;
use std::path::{Path, PathBuf};

/// An accelerometer whose vectors are by their median shorter than this share of gravity's has no gravity in it.
const WEIGHTLESS: f64 = 0.5;

/// The files of a folder.
#[derive(Debug)]
pub(crate) struct TwoFiles {
    gyro: PathBuf,
    accel: PathBuf,
    /// What Sensor Logger takes from the accelerometer.
    gravity: Option<PathBuf>,
    /// Where messages say that they lie, if elsewhere.
    shown_in: Option<PathBuf>,
}

/// Whether a file is a table by its name.
pub(crate) fn is_table(path: &Path) -> bool {
    path.extension().is_some_and(|e| ["csv", "txt", "tsv"].iter().any(|end| e.eq_ignore_ascii_case(end)))
}

impl TwoFiles {
    /// Looks for a file of each sensor by its name.
    pub(crate) fn find(dir: &Path) -> Result<Option<Self>, IoError> {
        let reading = |e| IoError::reading(dir, e);
        let mut files = Vec::new();
        for entry in std::fs::read_dir(dir).map_err(reading)? {
            let path = entry.map_err(reading)?.path();
            if is_table(&path) && path.is_file() {
                let stem = path.file_stem().unwrap_or_default().to_string_lossy().to_lowercase();
                files.push((stem, path));
            }
        }
        files.sort();
        // The whole before the calibrated before the raw; the one that lacks gravity last.
        let rank = |stem: &str| match stem {
            _ if stem.contains("linear") => 3,
            _ if stem.contains("uncalibrated") => 2,
            _ if stem.contains("total") => 0,
            _ => 1,
        };
        let best = |word: &str| {
            files
                .iter()
                .filter(|(stem, _)| stem.contains(word))
                .min_by_key(|(stem, _)| rank(stem))
                .map(|(_, path)| path.clone())
        };
        let (Some(gyro), Some(accel)) = (best("gyro"), best("accel")) else { return Ok(None) };
        let gravity = files.iter().find(|(stem, _)| stem == "gravity").map(|(_, path)| path.clone());
        Ok(Some(Self { gyro, accel, gravity, shown_in: None }))
    }

    /// The same, lying in `place` as far as messages go.
    #[cfg(feature = "zip")]
    pub(crate) fn shown_in(self, place: &Path) -> Self {
        Self { shown_in: Some(place.to_owned()), ..self }
    }

    /// Reads and joins them.
    ///
    /// # Errors
    /// A file that cannot be read; two that have no time in common.
    pub(crate) fn read(&self, dir: &Path, options: &LogOptions) -> Result<Log, LogError> {
        let scales = options.scales;
        let storing = |e| IoError::reading(dir, e);
        let one = |path, sensor| one(path, sensor, options, self.shown_in.as_deref());
        let gyro = one(&self.gyro, Sensor::Gyro)?;
        let accel = one(&self.accel, Sensor::Accel)?;
        let (gyro_name, mut accel_name) = (name(&self.gyro), name(&self.accel));
        let (mut guesses, mut remarks) = (Vec::new(), Vec::new());
        let gravity = self.gravity.as_ref().map(|path| one(path, Sensor::Accel).map(|read| (path, read)));
        let mut with_gravity = None;
        if let Some((path, gravity)) = gravity.transpose()?
            && weightless(&accel.recording, &gravity.recording).map_err(storing)?
        {
            // The sum on the accelerometer's stamps: its values stand where a gyroscope's would.
            let sum = |s: ImuSample| {
                Some(ImuSample { accel: std::array::from_fn(|i| s.gyro[i] + s.accel[i]), ..s })
            };
            let both = join(&accel.recording, &gravity.recording);
            with_gravity = Some(both.and_then(|both| both.samples.changed(sum)).map_err(storing)?);
            accel_name = format!("{accel_name} + {}", name(path));
        }
        let joined = match &with_gravity {
            Some(forces) => join(&gyro.recording, forces),
            None => join(&gyro.recording, &accel.recording),
        };
        let joined = joined.map_err(storing)?;
        guesses.push(joined.remark(&gyro_name, &accel_name));
        remarks.extend(joined.left_out());
        for (file, read) in [(&gyro_name, &gyro), (&accel_name, &accel)] {
            guesses.extend(read.understood.passed.iter().map(|passed| format!("{file}: {passed}")));
            if read.understood.time.origin == Origin::Guessed {
                guesses.push(format!("{file}: stamps in {}", read.understood.time.value));
            }
            let left = read.sieved.count() + read.unreadable.count;
            if left > 0 {
                remarks.push(format!("left out: {left} row(s) of {file} that cannot be used"));
            }
        }
        // What was named is converted already.
        let named = |origin, is_scaled: bool| if is_scaled { Origin::Header } else { origin };
        let turn = Settled {
            value: GyroUnit::RadPerSecond,
            origin: named(gyro.understood.gyro.origin, scales.gyro.is_some()),
        };
        let force = Settled {
            value: AccelUnit::MetrePerSecond2,
            origin: named(accel.understood.accel.origin, scales.accel.is_some()),
        };
        let (samples, turn, force) = settle_units(joined.samples, turn, force).map_err(storing)?;
        if turn.origin == Origin::Guessed {
            guesses.push(format!("gyroscope in {} (--gyro-unit)", turn.value.name()));
        }
        if force.origin == Origin::Guessed {
            guesses.push(format!("accelerometer in {} (--accel-unit)", force.value.name()));
        }
        let recording = scales.apply(samples).and_then(SampleStore::recording).map_err(storing)?;
        let (dir, accel) = (dir.to_path_buf(), accel_name);
        let recording = recording.map_err(|found| LogError::Apart { dir, gyro: gyro_name, accel, found })?;
        Ok(Log { guesses, remarks, ..Log::sound(Kind::TwoFiles, recording) })
    }
}

fn one(
    path: &Path,
    sensor: Sensor,
    options: &LogOptions,
    shown_in: Option<&Path>,
) -> Result<LooseImuLog, LogError> {
    let shown = shown_in.map_or_else(|| path.to_owned(), |dir| dir.join(name(path)));
    let file = File::open(path).map_err(|e| IoError::reading(&shown, e))?;
    Ok(parse_one_sensor_loosely(file, &shown, &options.csv, sensor)?)
}

fn name(path: &Path) -> String {
    printable(&path.file_name().unwrap_or_default().to_string_lossy())
}

/// Whether gravity is missing in `accel`, by the median lengths of the vectors.
fn weightless(accel: &StoredRecording, gravity: &StoredRecording) -> io::Result<bool> {
    let both = [accel, gravity];
    let columns = both.map(|r| Column { count: r.len(), levels: &[Level::UpperMedian] });
    let lengths = levels(&columns, |take| {
        both.iter().enumerate().try_for_each(|(at, recording)| {
            recording.each(0..recording.len(), &mut |s| {
                take(at, s.accel.iter().map(|v| v * v).sum::<f64>().sqrt());
            })
        })
    })?;
    Ok(lengths[0][0] < WEIGHTLESS * lengths[1][0])
}
