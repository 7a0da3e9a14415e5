//! A phone's log: a folder with a file for the gyroscope and one for the accelerometer (Sensor Logger, phyphox), joined; or one file with rows of each.

use crate::join::join;
use crate::long::gyro_and_accel;
use crate::{Kind, Log, LogError, LogOptions, json};
use dpn_core::signal::ranks::{Column, Level, levels};
use dpn_core::{ImuSample, Recorded, Samples, Sensor};
use dpn_io::{
    AccelUnit, GyroUnit, IoError, Origin, SampleStore, Settled, StoredRecording, has_stamps,
    parse_one_sensor_loosely, printable, settle_units,
};
use std::fs::File;
use std::io::{self, Read};
use std::path::{Path, PathBuf};

/// An accelerometer whose vectors are by their median shorter than this share of gravity's has no gravity in it.
const WEIGHTLESS: f64 = 0.5;

/// What a sensor's table is read from.
#[derive(Debug)]
pub(crate) enum Source {
    /// A file, and where messages say that it lies.
    File(PathBuf, PathBuf),
    /// A part of one: its name and text, and the file.
    Text(String, String, PathBuf),
}

impl Source {
    fn name(&self) -> String {
        match self {
            Self::File(path, _) => name(path),
            Self::Text(name, ..) => printable(name),
        }
    }

    fn shown(&self) -> &Path {
        match self {
            Self::File(_, shown) | Self::Text(.., shown) => shown,
        }
    }

    fn open(&self) -> Result<Box<dyn Read + '_>, LogError> {
        Ok(match self {
            Self::File(path, shown) => Box::new(File::open(path).map_err(|e| IoError::reading(shown, e))?),
            Self::Text(_, text, _) => Box::new(text.as_bytes()),
        })
    }

    /// A JSON file's table of `sensor`; all else as it is.
    fn of_json(self, sensor: Sensor) -> Result<Self, LogError> {
        let mut head = Vec::new();
        self.open()?.take(16).read_to_end(&mut head).map_err(|e| IoError::reading(self.shown(), e))?;
        if !json::is(&head) {
            return Ok(self);
        }
        let mut bytes = Vec::new();
        self.open()?.read_to_end(&mut bytes).map_err(|e| IoError::reading(self.shown(), e))?;
        let (tables, _) = json::tables(&bytes);
        let found = gyro_and_accel(&tables.iter().map(|table| table.sensor.as_str()));
        let wanted = found[usize::from(sensor == Sensor::Accel)];
        let at = tables.iter().position(|table| Some(table.sensor.as_str()) == wanted);
        let mut tables = tables;
        Ok(match at.or((tables.len() == 1).then_some(0)) {
            Some(at) => {
                let table = tables.swap_remove(at);
                Self::Text(self.name(), table.text, self.shown().to_path_buf())
            }
            None => self,
        })
    }
}

/// The tables of a log.
#[derive(Debug)]
pub(crate) struct TwoFiles {
    gyro: Source,
    accel: Source,
    /// What Sensor Logger takes from the accelerometer.
    gravity: Option<Source>,
    /// The stamps of tables that have none.
    time: Option<PathBuf>,
}

/// Whether a file is a table by its name.
pub(crate) fn is_table(path: &Path) -> bool {
    let ends = ["csv", "txt", "tsv", "json"];
    path.extension().is_some_and(|e| ends.iter().any(|end| e.eq_ignore_ascii_case(end)))
}

impl TwoFiles {
    /// Looks for a file of each sensor by its name.
    pub(crate) fn find(dir: &Path) -> Result<Option<Self>, IoError> {
        let reading = |e| IoError::reading(dir, e);
        let mut files = Vec::new();
        for entry in std::fs::read_dir(dir).map_err(reading)? {
            let path = entry.map_err(reading)?.path();
            let stem = path.file_stem().unwrap_or_default().to_string_lossy().to_lowercase();
            // A file of both sensors is a log by itself.
            let is_both = stem.contains("gyr") && stem.contains("acc");
            if is_table(&path) && path.is_file() && !is_both {
                files.push((stem, path));
            }
        }
        files.sort();
        // The whole before the calibrated before the raw; the one that lacks gravity last.
        let rank = |stem: &str| match stem {
            _ if stem.contains("lin") => 3,
            _ if stem.contains("uncalibrated") => 2,
            _ if stem.contains("total") => 0,
            _ => 1,
        };
        let of = |path: &PathBuf| Source::File(path.clone(), path.clone());
        let best = |words: &[&str]| {
            files
                .iter()
                .filter(|(stem, _)| words.iter().any(|word| stem.contains(word)))
                .min_by_key(|(stem, _)| rank(stem))
                .map(|(_, path)| of(path))
        };
        let (Some(gyro), Some(accel)) = (best(&["gyr", "rotations"]), best(&["acc"])) else {
            return Ok(None);
        };
        let gravity = files.iter().find(|(stem, _)| stem == "gravity").map(|(_, path)| of(path));
        let is_time = |stem: &str| ["t", "time", "times", "timestamp", "timestamps"].contains(&stem);
        let time = files.iter().find(|(stem, _)| is_time(stem)).map(|(_, path)| path.clone());
        Ok(Some(Self { gyro, accel, gravity, time }))
    }

    /// The files.
    #[cfg(feature = "images")]
    pub(crate) fn files(&self) -> Vec<PathBuf> {
        let of = |source: &Source| source.shown().to_path_buf();
        [&self.gyro, &self.accel].into_iter().chain(&self.gravity).map(of).chain(self.time.clone()).collect()
    }

    /// Tables of both sensors.
    pub(crate) fn of(gyro: Source, accel: Source) -> Self {
        Self { gyro, accel, gravity: None, time: None }
    }

    /// The same, lying in `place` as far as messages go.
    #[cfg(feature = "zip")]
    pub(crate) fn shown_in(self, place: &Path) -> Self {
        let shown = |source| match source {
            Source::File(path, _) => {
                let shown = place.join(name(&path));
                Source::File(path, shown)
            }
            text @ Source::Text(..) => text,
        };
        Self { gyro: shown(self.gyro), accel: shown(self.accel), gravity: self.gravity.map(shown), ..self }
    }

    /// One table of tables without stamps, a row of each beside the other, with the stamps that lie beside them or are to be counted.
    ///
    /// # Errors
    /// A file that cannot be read; tables of other lengths.
    pub(crate) fn pasted(&self, dir: &Path, options: &LogOptions) -> Result<Option<String>, LogError> {
        let mut texts = Vec::new();
        for (source, sensor) in [(&self.gyro, Sensor::Gyro), (&self.accel, Sensor::Accel)] {
            let mut text = Vec::new();
            let reading = |e| IoError::reading(source.shown(), e);
            source.open()?.take(1 << 16).read_to_end(&mut text).map_err(reading)?;
            if has_stamps(&text, sensor) {
                return Ok(None);
            }
            text.clear();
            source.open()?.read_to_end(&mut text).map_err(reading)?;
            let word = if sensor == Sensor::Gyro { "gyro" } else { "accel" };
            texts.push((source.name(), columns(&String::from_utf8_lossy(&text), &["x", "y", "z"], word)));
        }
        if let Some(path) = self.time.as_ref().filter(|_| options.csv.rate.is_none()) {
            let text = std::fs::read(path).map_err(|e| IoError::reading(path, e))?;
            texts.insert(0, (name(path), columns(&String::from_utf8_lossy(&text), &["time"], "")));
        } else if options.csv.rate.is_none() {
            return Ok(None);
        }
        let rows = texts[0].1.len();
        if texts.iter().any(|(_, lines)| lines.len() != rows) {
            let of =
                |(name, lines): &(String, Vec<String>)| format!("{name} ({})", lines.len().saturating_sub(1));
            let files = texts.iter().map(of).collect::<Vec<_>>().join(", ");
            return Err(LogError::RowsDiffer { dir: dir.to_path_buf(), files });
        }
        let row = |i: usize| texts.iter().map(|(_, lines)| lines[i].as_str()).collect::<Vec<_>>().join(",");
        Ok(Some((0..rows).map(row).collect::<Vec<_>>().join("\n")))
    }

    /// Reads and joins them.
    ///
    /// # Errors
    /// A file that cannot be read; two that have no time in common.
    pub(crate) fn read(self, dir: &Path, options: &LogOptions) -> Result<Log, LogError> {
        let (gyro, accel) = (self.gyro.of_json(Sensor::Gyro)?, self.accel.of_json(Sensor::Accel)?);
        Self { gyro, accel, ..self }.join(dir, options)
    }

    fn join(&self, dir: &Path, options: &LogOptions) -> Result<Log, LogError> {
        let scales = options.scales;
        let storing = |e| IoError::reading(dir, e);
        options.without_rate(dir)?;
        let one = |source: &Source, sensor| {
            parse_one_sensor_loosely(source.open()?, source.shown(), &options.csv, sensor)
                .map_err(LogError::from)
        };
        let gyro = one(&self.gyro, Sensor::Gyro)?;
        let accel = one(&self.accel, Sensor::Accel)?;
        let (gyro_name, mut accel_name) = (self.gyro.name(), self.accel.name());
        let (mut guesses, mut remarks) = (Vec::new(), Vec::new());
        let gravity =
            self.gravity.as_ref().map(|source| one(source, Sensor::Accel).map(|read| (source, read)));
        let mut with_gravity = None;
        if let Some((source, gravity)) = gravity.transpose()?
            && weightless(&accel.recording, &gravity.recording).map_err(storing)?
        {
            // The sum on the accelerometer's stamps: its values stand where a gyroscope's would.
            let sum = |s: ImuSample| {
                Some(ImuSample { accel: std::array::from_fn(|i| s.gyro[i] + s.accel[i]), ..s })
            };
            let both = join(&accel.recording, &gravity.recording);
            with_gravity = Some(both.and_then(|both| both.samples.changed(sum)).map_err(storing)?);
            accel_name = format!("{accel_name} + {}", source.name());
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
        let ([from, to], [other_from, other_to]) = (gyro.recording.span(), accel.recording.span());
        let spans = format!("; stamps are from {from} to {to}, and from {other_from} to {other_to}");
        let (dir, accel) = (dir.to_path_buf(), accel_name);
        let recording =
            recording.map_err(|found| LogError::Apart { dir, gyro: gyro_name, accel, found, spans })?;
        Ok(Log { guesses, remarks, ..Log::sound(Kind::TwoFiles, recording) })
    }
}

/// The lines of a table whose fields stand between commas, the first one a header; `names` where there is none. Bare axes are called `word`'s.
fn columns(text: &str, names: &[&str], word: &str) -> Vec<String> {
    // As the rows have it: a header may have blanks in its names.
    let row =
        text.lines().find(|line| line.trim_start().starts_with(|c: char| c.is_ascii_digit() || c == '-'));
    let between = [',', ';', '\t', ' '].into_iter().find(|c| row.is_some_and(|row| row.trim().contains(*c)));
    let fields = |line: &str| {
        let parts: Vec<&str> = between.map_or_else(|| vec![line], |c| line.split(c).collect());
        parts.into_iter().map(|f| f.trim().to_owned()).filter(|f| !f.is_empty()).collect::<Vec<_>>()
    };
    let mut lines: Vec<Vec<String>> = text.lines().map(fields).filter(|line| !line.is_empty()).collect();
    let has_numbers = |line: &Vec<String>| line.iter().any(|field| field.parse::<f64>().is_ok());
    if lines.first().is_none_or(has_numbers) {
        lines.insert(0, names.iter().map(|name| (*name).to_owned()).collect());
    }
    for name in lines[0].iter_mut().filter(|name| name.len() == 1) {
        *name = format!("{word} {name}");
    }
    lines.into_iter().map(|line| line.join(",")).collect()
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
