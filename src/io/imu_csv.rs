//! IMU logs as tables of numbers: ASL's `imu0/data.csv` and plain CSV files with other columns and units.
//!
//! Columns are found by the header's names (`names`), else by a list, else in ASL's order. Units come from the caller, else
//! from the header; what neither says is SI for the sensors, and for time told from the stamps' size:
//!
//! * a first stamp between the years 1973 and 2286 gives the unit away: 1e8 to 1e10 in s, 1e11 to 1e13 in ms, and so on;
//! * else the median step of the first thousand rows does, as IMUs run at 10 to 10,000 Hz: [1e-4, 1e-1) in s, [1e-1, 1e2) in ms,
//!   [1e2, 1e5) in us, [1e5, 1e8) in ns.

use super::choice::ColumnChoice;
use super::columns::{AccelUnit, GyroUnit, ImuColumns, SLOTS};
use super::names;
use super::names::Named;
use super::rows::Rows;
use super::{IoError, TimeUnit};
use dpn_core::imu::{ImuRecording, ImuSample};
use dpn_core::signal::stats::upper_median;
use dpn_core::{Sensor, Stamp};
use std::path::Path;

/// A step between stamps since 1970 is shorter than this \[s\].
const SLOWEST_S: f64 = 1e3;

/// What the caller knows about a log; `None` is left to the header or to a guess.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct CsvOptions {
    /// Which column is what; wins over the header.
    pub columns: Option<ColumnChoice>,
    /// Unit of the stamps.
    pub time: Option<TimeUnit>,
    /// Unit of the gyroscope.
    pub gyro: Option<GyroUnit>,
    /// Unit of the accelerometer.
    pub accel: Option<AccelUnit>,
}

/// Where a choice came from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Origin {
    /// The caller gave it.
    Given,
    /// The file's header names it.
    Header,
    /// Told from the numbers.
    Guessed,
    /// Nobody said anything; this is the default.
    Assumed,
}

/// A choice, and where it came from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Settled<T> {
    /// The choice.
    pub value: T,
    /// Where it came from.
    pub origin: Origin,
}

/// A log that was read, and how it was understood.
#[derive(Debug, Clone, PartialEq)]
pub struct ImuLog {
    /// The samples, in rad/s and m/s^2.
    pub recording: ImuRecording,
    /// Which column was what.
    pub columns: Settled<ImuColumns>,
    /// Unit of the stamps.
    pub time: Settled<TimeUnit>,
    /// Unit of the gyroscope's columns.
    pub gyro: Settled<GyroUnit>,
    /// Unit of the accelerometer's columns.
    pub accel: Settled<AccelUnit>,
}

/// Reads a log of all six axes.
///
/// # Errors
/// A file that cannot be read or holds no row; a column that is missing; a row that is cut off or holds what is no finite number;
/// stamps that do not increase; a unit of time that cannot be told; fewer than two samples. Each with its line.
pub fn read_imu_csv(path: &Path, options: &CsvOptions) -> Result<ImuLog, IoError> {
    let bytes = std::fs::read(path).map_err(|e| IoError::reading(path, e))?;
    parse_imu_csv(&bytes, path, options)
}

/// The same from bytes at hand; `path` is for messages.
///
/// # Errors
/// As [`read_imu_csv`].
pub fn parse_imu_csv(bytes: &[u8], path: &Path, options: &CsvOptions) -> Result<ImuLog, IoError> {
    parse_with(bytes, path, options, None)
}

/// The same; `assumed_time` is the unit of stamps that neither caller nor header name, instead of a guess.
pub(crate) fn parse_with(
    bytes: &[u8],
    path: &Path,
    options: &CsvOptions,
    assumed_time: Option<TimeUnit>,
) -> Result<ImuLog, IoError> {
    let mut rows = Rows::open(bytes, path)?;
    let (columns, said) = columns(&rows, path, options, None)?;
    let time = match (first_said(options.time, said.time), assumed_time) {
        (Some(said), _) => said,
        (None, Some(value)) => Settled { value, origin: Origin::Assumed },
        (None, None) => {
            let value =
                guess_time_unit(&first_rows(Rows::open(bytes, path)?, &columns.value, false)?, &said, path)?;
            Settled { value, origin: Origin::Guessed }
        }
    };
    let interval_s = match columns.value.intervals {
        [None, None] => 1.0,
        _ => guess_interval(&first_rows(Rows::open(bytes, path)?, &columns.value, false)?, time.value),
    };
    let gyro = first_said(options.gyro, said.gyro)
        .unwrap_or(Settled { value: GyroUnit::RadPerSecond, origin: Origin::Assumed });
    let accel = first_said(options.accel, said.accel)
        .unwrap_or(Settled { value: AccelUnit::MetrePerSecond2, origin: Origin::Assumed });
    let factors = (gyro.value.factor(), accel.value.factor());
    let samples = samples(&mut rows, &columns.value, time.value, interval_s, factors)?;
    Ok(ImuLog { recording: recording(samples, path)?, columns, time, gyro, accel })
}

/// The error for rows that are too narrow.
pub(super) fn unknown_layout(rows: &Rows<'_>, path: &Path) -> IoError {
    IoError::UnknownLayout {
        path: path.to_path_buf(),
        line: rows.line() + 1,
        found: rows.width(),
        expected: "at least 7 (stamp, gyroscope x y z, accelerometer x y z)",
    }
}

pub(super) fn first_said<T>(given: Option<T>, header: Option<T>) -> Option<Settled<T>> {
    given
        .map(|value| Settled { value, origin: Origin::Given })
        .or_else(|| header.map(|value| Settled { value, origin: Origin::Header }))
}

/// What a header says of the units, and what of its columns was passed over.
#[derive(Debug, Default)]
pub(super) struct Said {
    pub(super) time: Option<TimeUnit>,
    fine: bool,
    pub(super) gyro: Option<GyroUnit>,
    pub(super) accel: Option<AccelUnit>,
    pub(super) passed: Vec<String>,
}

/// Which column is what: as the caller lists them, by the header, by ASL's order.
pub(super) fn columns(
    rows: &Rows<'_>,
    path: &Path,
    options: &CsvOptions,
    only: Option<Sensor>,
) -> Result<(Settled<ImuColumns>, Said), IoError> {
    let header = rows.header();
    if let Some(choice) = &options.columns {
        let columns = choice.resolve(header, path)?;
        let (time, gyro, accel) =
            header.map_or((None, None, None), |header| names::units_at(header, &columns));
        let said = Said { time, gyro, accel, ..Said::default() };
        return Ok((Settled { value: columns, origin: Origin::Given }, said));
    }
    if let Some(header) = header {
        let named = names::from_header(header, path, only)?;
        let Named { columns, time, fine, gyro, accel, passed } = named;
        return Ok((
            Settled { value: columns, origin: Origin::Header },
            Said { time, fine, gyro, accel, passed },
        ));
    }
    let value = match only {
        _ if rows.first_is_ros2_echo() => ImuColumns::ROS2_ECHO,
        Some(_) if rows.width() >= 4 => ImuColumns::new(0, [1, 2, 3], [1, 2, 3]),
        None if rows.width() >= 7 => ImuColumns::ASL,
        _ => return Err(unknown_layout(rows, path)),
    };
    let origin = if value == ImuColumns::ASL { Origin::Assumed } else { Origin::Guessed };
    Ok((Settled { value, origin }, Said::default()))
}

/// The current row as a sample, its axes in the file's units; an increment is divided by its interval.
pub(super) fn sample(
    rows: &Rows<'_>,
    columns: &ImuColumns,
    time: TimeUnit,
    interval_s: f64,
) -> Result<ImuSample, IoError> {
    let [_, gx, gy, gz, ax, ay, az] = SLOTS;
    let mut t = rows.stamp(columns.time, time)?;
    if let Some(nanos) = columns.nanos {
        t = Stamp::from_ns(t.ns().saturating_add(rows.stamp(nanos, TimeUnit::Nanos)?.ns()));
    }
    let mut gyro = rows.numbers(columns.gyro, [gx, gy, gz])?;
    let mut accel = rows.numbers(columns.accel, [ax, ay, az])?;
    for (values, interval) in [&mut gyro, &mut accel].into_iter().zip(columns.intervals) {
        if let Some(interval) = interval {
            let seconds = rows.number(interval, "interval")? * interval_s;
            *values = values.map(|v| v / seconds);
        }
    }
    Ok(ImuSample { t, gyro, accel })
}

fn samples(
    rows: &mut Rows<'_>,
    columns: &ImuColumns,
    time: TimeUnit,
    interval_s: f64,
    (gyro, accel): (f64, f64),
) -> Result<Vec<ImuSample>, IoError> {
    let mut samples: Vec<ImuSample> = Vec::with_capacity(rows.rows_left());
    while rows.advance()? {
        let mut sample = sample(rows, columns, time, interval_s)?;
        rows.must_follow(samples.last().map(|s| s.t), sample.t)?;
        sample.gyro = sample.gyro.map(|v| v * gyro);
        sample.accel = sample.accel.map(|v| v * accel);
        if !sample.is_finite() {
            return Err(rows.not_finite("a value in SI units", "infinite"));
        }
        samples.push(sample);
    }
    Ok(samples)
}

/// Takes samples already checked row by row, so that only their number can be wrong.
pub(super) fn recording(samples: Vec<ImuSample>, path: &Path) -> Result<ImuRecording, IoError> {
    match samples.len() {
        found @ 0..2 => Err(IoError::TooShort { path: path.to_path_buf(), found }),
        _ => Ok(ImuRecording::new(samples).expect("every row was finite and later than the one before")),
    }
}

/// Stamps and intervals of the first thousand rows, as numbers.
#[derive(Debug)]
pub(super) struct FirstRows {
    stamps: Vec<f64>,
    intervals: Vec<f64>,
}

impl FirstRows {
    fn step(&self) -> Option<f64> {
        upper_median(self.stamps.windows(2).map(|w| w[1] - w[0]))
    }
}

/// Reads them; `loose` passes over rows that cannot be read, as long as one can.
pub(super) fn first_rows(
    mut rows: Rows<'_>,
    columns: &ImuColumns,
    loose: bool,
) -> Result<FirstRows, IoError> {
    const ROWS: usize = 1000;
    let mut first = FirstRows { stamps: Vec::with_capacity(ROWS), intervals: Vec::new() };
    let mut passed = None;
    while first.stamps.len() < ROWS {
        match rows.advance().and_then(|more| more.then(|| rows.number(columns.time, SLOTS[0])).transpose()) {
            Ok(None) => break,
            Ok(Some(stamp)) => first.stamps.push(stamp),
            Err(error) if !loose => return Err(error),
            Err(error) => {
                passed.get_or_insert(error);
                continue;
            }
        }
        if let Some(interval) = columns.intervals.into_iter().flatten().next() {
            first.intervals.extend(rows.number(interval, "interval"));
        }
    }
    match passed {
        Some(error) if first.stamps.is_empty() => Err(error),
        _ => Ok(first),
    }
}

/// Seconds in one of the intervals' unit: the power of thousand that brings them nearest to the steps of the stamps.
pub(super) fn guess_interval(first: &FirstRows, time: TimeUnit) -> f64 {
    let step_s = first.step().map_or(0.0, |step| step * time.seconds());
    let interval = upper_median(first.intervals.iter().copied()).unwrap_or(0.0);
    let far = |unit: &TimeUnit| (interval * unit.seconds() / step_s).ln().abs();
    let near = TimeUnit::ALL.into_iter().min_by(|a, b| far(a).total_cmp(&far(b)));
    near.map_or(1.0, TimeUnit::seconds)
}

/// Tells the unit of time from the first stamps.
pub(super) fn guess_time_unit(first: &FirstRows, said: &Said, path: &Path) -> Result<TimeUnit, IoError> {
    let (Some(step), Some(&start)) = (first.step(), first.stamps.first()) else {
        return Err(IoError::TooShort { path: path.to_path_buf(), found: first.stamps.len() });
    };
    if said.fine {
        // Xsens' MTi count in 100 us, their Dots in 1 us; the former give 10 Hz or more, the latter 120 Hz or less.
        return Ok(if step > 1000.5 { TimeUnit::Micros } else { TimeUnit::HundredMicros });
    }
    // Half a per cent of slack, so that a 10 Hz log with jitter is not taken for one of 10 kHz.
    let within = |value: f64, least: f64, most: f64| (least * 0.995..most * 0.995).contains(&value);
    // Seconds since a sensor's start in ns may look like seconds since 1970, but for their steps.
    let since_1970 =
        |unit: &TimeUnit| within(start * unit.seconds(), 1e8, 1e10) && step * unit.seconds() < SLOWEST_S;
    let between = |unit: &TimeUnit| within(step * unit.seconds(), 1e-4, 1e-1);
    TimeUnit::ALL
        .into_iter()
        .find(since_1970)
        .or_else(|| TimeUnit::ALL.into_iter().find(between))
        .ok_or_else(|| IoError::UnknownTimeUnit { path: path.to_path_buf(), first: start, step })
}

#[cfg(test)]
mod tests {
    use super::*;
    use dpn_core::time::Stamp;

    fn case(text: &str, options: &CsvOptions) -> Result<ImuLog, IoError> {
        parse_imu_csv(text.as_bytes(), Path::new("log.csv"), options)
    }

    /// Ten rows of ASL's order with stamps `start + i * step`, to as many digits as `start` and `step` need.
    fn stamped(start: f64, step: f64) -> String {
        (0..10).map(|i| format!("{:.6},1,2,3,4,5,6\n", start + f64::from(i) * step)).collect()
    }

    #[test]
    fn the_unit_of_time_is_told_from_epoch_or_step_and_reported() {
        let cases = [
            (1.4e9, 0.005, TimeUnit::Seconds),
            (1.4e12, 5.0, TimeUnit::Millis),
            (1.4e15, 5000.0, TimeUnit::Micros),
            (1.4e18, 5_000_192.0, TimeUnit::Nanos),
            (0.0, 0.005, TimeUnit::Seconds),
            (0.0, 10.0, TimeUnit::Millis),
            (12.5, 0.1, TimeUnit::Millis),
            (12.5, 0.099, TimeUnit::Seconds),
            (0.0, 1250.0, TimeUnit::Micros),
            (0.0, 5e6, TimeUnit::Nanos),
        ];
        for (start, step, unit) in cases {
            let log = case(&stamped(start, step), &CsvOptions::default()).unwrap();
            let expected = Settled { value: unit, origin: Origin::Guessed };
            assert_eq!(log.time, expected, "from {start} by {step}");
        }
        let error = case(&stamped(0.0, 1e9), &CsvOptions::default()).unwrap_err();
        assert!(matches!(error, IoError::UnknownTimeUnit { .. }), "{error}");
        assert!(error.hint().unwrap().contains("ns"));
    }

    #[test]
    fn degrees_and_g_become_si_and_the_caller_wins_over_the_header() {
        let text = "time_s,ax [g],ay [g],az [g],gx [deg/s],gy [deg/s],gz [deg/s]\n0.5,0,0,1,180,0,-90\n0.505,0,0,1,0,0,0\n";
        let log = case(text, &CsvOptions::default()).unwrap();
        let first = log.recording.samples()[0];
        assert_eq!(first.t, Stamp::from_ns(500_000_000));
        assert_eq!(first.accel, [0.0, 0.0, 9.80665]);
        assert!((first.gyro[0] - std::f64::consts::PI).abs() < 1e-15);
        assert_eq!(log.gyro, Settled { value: GyroUnit::DegPerSecond, origin: Origin::Header });

        let given = CsvOptions {
            time: Some(TimeUnit::Millis),
            accel: Some(AccelUnit::MetrePerSecond2),
            ..CsvOptions::default()
        };
        let log = case(text, &given).unwrap();
        assert_eq!(log.recording.samples()[1].t, Stamp::from_ns(505_000));
        assert_eq!(log.recording.samples()[0].accel[2], 1.0);
        assert_eq!(log.accel.origin, Origin::Given);
    }

    #[test]
    fn columns_can_be_listed_and_are_checked_against_the_rows() {
        let columns = ImuColumns::new(7, [4, 5, 6], [1, 2, 3]);
        let options = CsvOptions { columns: Some(columns.into()), ..CsvOptions::default() };
        let log = case("9,1,2,3,4,5,6,0.000\n9,1,2,3,4,5,6,0.005\n", &options).unwrap();
        assert_eq!(log.recording.samples()[1].gyro, [4.0, 5.0, 6.0]);
        let error = case("1,2,3\n2,2,3\n", &options).unwrap_err().to_string();
        assert_eq!(error, "log.csv:1: 3 fields, expected 8");
        let error = case("1,2,3\n2,2,3\n", &CsvOptions::default()).unwrap_err().to_string();
        assert!(error.starts_with("log.csv:1: 3 columns; at least 7"), "{error}");
    }

    #[test]
    fn stamps_that_do_not_increase_one_sample_and_overflow_are_refused() {
        let error = |text: &str| case(text, &CsvOptions::default()).unwrap_err();
        assert_eq!(
            error("0.010,1,2,3,4,5,6\n0.015,1,2,3,4,5,6\n\n0.012,1,2,3,4,5,6\n0.025,1,2,3,4,5,6\n")
                .to_string(),
            "log.csv:4: time goes from 15000000 to 12000000 ns; stamps must increase"
        );
        assert!(matches!(error("1,1,2,3,4,5,6\n"), IoError::TooShort { found: 1, .. }));
        let g = CsvOptions { accel: Some(AccelUnit::StandardGravity), ..CsvOptions::default() };
        let error = case("0.1,1,2,3,4,5,6\n0.105,1,2,3,4,5,1.7e308\n", &g).unwrap_err();
        assert!(matches!(error, IoError::NotFinite { line: 2, .. }), "{error}");
    }
}
