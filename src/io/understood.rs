//! How the rows of an IMU's log are understood: which column is what, in which unit, and a row as a sample.
//!
//! Columns are found by the header's names (`names`), else by a list, else in ASL's order. Units come from the caller, else
//! from the header; what neither says is SI for the sensors, and for time told from the stamps' size:
//!
//! * the median step of the first thousand rows gives the unit away, as IMUs run at 10 to 10,000 Hz: [1e-4, 1e-1) in s, [1e-1, 1e2) in ms,
//!   [1e2, 1e5) in us, [1e5, 1e8) in ns; what would be 2 kHz or more is 2 to 10 Hz in the next unit, and is asked about, as is a column that counts rows;
//! * a first stamp of the years 1973 to 2286 does where the step is of no IMU, and where a log of at least 1 Hz would be of this century.

use super::choice::ColumnChoice;
use super::columns::{AccelUnit, GyroUnit, ImuColumns, SLOTS};
use super::decimal::{DAYS_UNTIL_1970, TICKS_UNTIL_1970};
use super::names::{self, Named, Told};
use super::row_fault::RowFault;
use super::rows::Rows;
use super::{IoError, TimeUnit, guess};
use dpn_core::imu::ImuSample;
use dpn_core::signal::stats::{median_of, upper_median};
use dpn_core::{SampleRate, Sensor, Stamp};
use std::ops::Range;
use std::path::Path;

/// A step between stamps since 1970 is shorter than this \[s\].
const SLOWEST_S: f64 = 1e3;
/// Stamps between 2000 and 2096 are of a clock, not of a sensor's start, as long as their steps are no longer than a second \[s\].
const CENTURY_S: [f64; 2] = [9.4e8, 4e9];
/// A step that is shorter in one unit is as likely a thousand times as long in the next: tables of more than 2 kHz are as rare as of less than 10 Hz \[s\].
const SURE_S: f64 = 5e-4;
/// No stamp of any IMU follows another as soon \[s\].
const FASTEST_S: f64 = 1e-5;
/// Columns from which on a table without a header could mean several things: a stamp and three triples.
const SEVERAL: usize = 10;

/// What the caller knows about a log; `None` is left to the header or to a guess.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct CsvOptions {
    /// Which column is what; wins over the header.
    pub columns: Option<ColumnChoice>,
    /// Unit of the stamps.
    pub time: Option<TimeUnit>,
    /// Unit of the gyroscope.
    pub gyro: Option<GyroUnit>,
    /// Unit of the accelerometer.
    pub accel: Option<AccelUnit>,
    /// Stamps are counted at this rate; those of the log are passed over.
    pub rate: Option<SampleRate>,
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

/// How a log was understood.
#[derive(Debug, Clone, PartialEq)]
pub struct Understood {
    /// Which column was what.
    pub columns: Settled<ImuColumns>,
    /// Unit of the stamps.
    pub time: Settled<TimeUnit>,
    /// Unit of the gyroscope's columns.
    pub gyro: Settled<GyroUnit>,
    /// Unit of the accelerometer's columns.
    pub accel: Settled<AccelUnit>,
    /// Columns that could have been meant too, each with what was taken instead.
    pub passed: Vec<String>,
    /// The stamps are dates or times of day.
    pub(super) are_dates: bool,
    /// Seconds in one of the intervals' unit.
    interval_s: f64,
    /// The rate at which stamps are counted.
    counted: Option<SampleRate>,
}

impl Understood {
    /// From the header and the first rows of a table, which `rows` stands before; units of sensors that nobody named are [`Origin::Assumed`] to be SI. `time` is
    /// the unit of stamps that neither caller nor header name, instead of a guess; `loose` passes over first rows that cannot be read.
    ///
    /// # Errors
    /// A column that is missing; a unit of time that cannot be told; first rows that cannot be read.
    pub(super) fn of(
        rows: &Rows<'_>,
        path: &Path,
        options: &CsvOptions,
        only: Option<Sensor>,
        time: Option<TimeUnit>,
        loose: bool,
    ) -> Result<Self, IoError> {
        let (columns, said) = columns(rows, path, options, only)?;
        let counted = options.rate;
        let first = || first_rows(rows.clone(), &columns.value, loose, counted.is_none());
        let seconds = columns.value.fraction.map(|_| TimeUnit::Seconds);
        // What is said is not to be, where nothing is sampled as fast.
        let likely = |value: &TimeUnit| {
            first().is_ok_and(|first| first.step().is_none_or(|step| step * value.seconds() > FASTEST_S))
        };
        let are_dates = first().is_ok_and(|first| first.are_dates);
        let time = match (first_said(options.time, said.time.or(seconds)), time.filter(likely)) {
            _ if counted.is_some() || are_dates => Settled { value: TimeUnit::Nanos, origin: Origin::Given },
            (Some(said), _) => said,
            (None, Some(value)) => Settled { value, origin: Origin::Assumed },
            (None, None) => {
                Settled { value: guess_time_unit(&first()?, &said, path)?, origin: Origin::Guessed }
            }
        };
        let interval_s = match columns.value.intervals {
            [None, None] => 1.0,
            _ => {
                let first = first()?;
                let step_s = first.step().map_or(0.0, |step| step * time.value.seconds());
                guess_interval(&first, counted.map_or(step_s, SampleRate::period))
            }
        };
        let mut passed = said.passed;
        if are_dates {
            passed
                .push("stamps are dates or times of day, of UTC where no zone stands beside them".to_owned());
        }
        let differs = |sensor: &str, told: Option<&'static str>, said: Option<&'static str>| {
            let (told, said) = told.zip(said).filter(|(told, said)| told != said)?;
            Some(format!("{sensor} in {told} as told, though the header says {said}"))
        };
        passed.extend(differs("gyroscope", options.gyro.map(GyroUnit::name), said.gyro.map(GyroUnit::name)));
        passed.extend(differs(
            "accelerometer",
            options.accel.map(AccelUnit::name),
            said.accel.map(AccelUnit::name),
        ));
        let gyro = first_said(options.gyro, said.gyro);
        let accel = first_said(options.accel, said.accel);
        Ok(Self {
            columns,
            time,
            gyro: gyro.unwrap_or(Settled { value: GyroUnit::RadPerSecond, origin: Origin::Assumed }),
            accel: accel.unwrap_or(Settled { value: AccelUnit::MetrePerSecond2, origin: Origin::Assumed }),
            passed,
            are_dates,
            interval_s,
            counted,
        })
    }

    /// The next row as a sample, its axes in the file's units; an increment is divided by its interval. `None` at the end.
    ///
    /// # Errors
    /// A row with another number of fields; a field that is no finite number, or no stamp.
    #[inline]
    pub(super) fn next(&self, rows: &mut Rows<'_>) -> Result<Option<ImuSample>, IoError> {
        if !rows.advance()? {
            return Ok(None);
        }
        let columns = &self.columns.value;
        let [_, gx, gy, gz, ax, ay, az] = SLOTS;
        let mut t = match self.counted {
            Some(rate) => counted_stamp(rows.number_of_row(), rate),
            None => rows.stamp(columns.time, self.time.value)?,
        };
        if let Some((column, unit)) = columns.fraction {
            t = Stamp::from_ns(t.ns().saturating_add(rows.stamp(column, unit)?.ns()));
        }
        let mut gyro = rows.numbers(columns.gyro, [gx, gy, gz])?;
        let mut accel = rows.numbers(columns.accel, [ax, ay, az])?;
        for (values, interval) in [&mut gyro, &mut accel].into_iter().zip(columns.intervals) {
            if let Some(interval) = interval {
                let seconds = rows.number(interval, "interval")? * self.interval_s;
                *values = values.map(|v| v / seconds);
            }
        }
        if let Some(axes) = columns.gravity {
            let gravity = rows.numbers(axes, ["gravity_x", "gravity_y", "gravity_z"])?;
            accel.iter_mut().zip(gravity).for_each(|(accel, gravity)| *accel += gravity);
        }
        Ok(Some(ImuSample { t, gyro, accel }))
    }

    /// A sample in rad/s and m/s^2.
    #[inline]
    pub(super) fn in_si(&self, ImuSample { t, gyro, accel }: ImuSample) -> ImuSample {
        let (turn, force) = (self.gyro.value.factor(), self.accel.value.factor());
        ImuSample { t, gyro: gyro.map(|v| v * turn), accel: accel.map(|v| v * force) }
    }
}

/// The stamp of the sample `index`, from 0, of a log without stamps.
pub fn counted_stamp(index: usize, rate: SampleRate) -> Stamp {
    Stamp::from_ns((index as f64 * 1e9 / rate.hz()).round() as i64)
}

fn first_said<T>(given: Option<T>, header: Option<T>) -> Option<Settled<T>> {
    given
        .map(|value| Settled { value, origin: Origin::Given })
        .or_else(|| header.map(|value| Settled { value, origin: Origin::Header }))
}

/// What a header says of the units, and what of its columns was passed over.
#[derive(Debug, Default)]
struct Said {
    time: Option<TimeUnit>,
    fine: bool,
    gyro: Option<GyroUnit>,
    accel: Option<AccelUnit>,
    passed: Vec<String>,
}

/// Which column is what: as the caller lists them, by the header, by ASL's order.
fn columns(
    rows: &Rows<'_>,
    path: &Path,
    options: &CsvOptions,
    only: Option<Sensor>,
) -> Result<(Settled<ImuColumns>, Said), IoError> {
    let header = rows.header();
    let counted = options.rate.is_some();
    if let Some(choice) = &options.columns {
        let columns = choice.resolve(header, path, counted)?;
        let (time, gyro, accel) =
            header.map_or((None, None, None), |header| names::units_at(header, &columns));
        let said = Said { time, gyro, accel, ..Said::default() };
        return Ok((Settled { value: columns, origin: Origin::Given }, said));
    }
    if let Some(header) = header {
        let units = [options.time.is_some(), options.gyro.is_some(), options.accel.is_some()];
        let named = names::from_header(header, path, only, Told { counted, units })?;
        let Named { mut columns, time, fine, gyro, accel, gravity_may_be_in, mut passed } = named;
        columns.fraction = columns.fraction.filter(|fraction| is_fraction(rows.clone(), *fraction));
        if let Some((column, _)) = columns.fraction {
            // It is read, so it is not passed over.
            passed.retain(|words| !words.ends_with(&format!("not `{}`", header.names[column])));
        }
        columns.gravity =
            columns.gravity.filter(|axes| !gravity_may_be_in || lacks_gravity(rows, columns.accel, *axes));
        if let Some(axes) = columns.gravity {
            passed.push(format!("`{}` added to `{}`", header.names[axes[0]], header.names[columns.accel[0]]));
        }
        return Ok((
            Settled { value: columns, origin: Origin::Header },
            Said { time, fine, gyro, accel, passed },
        ));
    }
    // A row's number may go before the stamp.
    let first = usize::from(only.is_none() && rows.width() > 7 && is_numbered(rows.clone()));
    let last = rows.width() - 1;
    let is_last = only.is_none() && !counted && last >= 6 && !increases(rows.clone(), 0);
    let value = match only {
        _ if rows.first_is_ros2_echo() => ImuColumns::ROS2_ECHO,
        Some(_) if counted && rows.width() == 3 => ImuColumns::new(0, [0, 1, 2], [0, 1, 2]),
        Some(_) if rows.width() >= 4 => ImuColumns::new(0, [1, 2, 3], [1, 2, 3]),
        None if counted && rows.width() == 6 => ImuColumns::new(0, [0, 1, 2], [3, 4, 5]),
        None if ends_with_quaternion(rows.clone()) => return Err(rows.below(RowFault::Poses)),
        None if is_last && increases(rows.clone(), last) => match last {
            6 => ImuColumns::new(6, [0, 1, 2], [3, 4, 5]),
            _ => return Err(several(rows, last, 0..last)),
        },
        None if rows.width() >= SEVERAL + first => return Err(several(rows, first, first + 1..rows.width())),
        None if first == 1 => ImuColumns::new(1, [2, 3, 4], [5, 6, 7]),
        None if rows.width() >= 7 => ImuColumns::ASL,
        _ => {
            return Err(rows.unknown_layout("at least 7 (stamp, gyroscope x y z, accelerometer x y z)"));
        }
    };
    let origin = if value == ImuColumns::ROS2_ECHO { Origin::Guessed } else { Origin::Assumed };
    Ok((Settled { value, origin }, Said::default()))
}

/// Whether an acceleration is what is left of one from which that gravity was taken: much shorter, by the medians of the first rows.
fn lacks_gravity(rows: &Rows<'_>, accel: [usize; 3], gravity: [usize; 3]) -> bool {
    const ROWS: usize = 1000;
    let mut rows = rows.clone();
    let mut lengths = [Vec::new(), Vec::new()];
    while lengths[1].len() < ROWS && matches!(rows.advance(), Ok(true)) {
        let both = [accel, gravity].map(|axes| rows.numbers(axes, ["a number"; 3]));
        for (lengths, axes) in lengths.iter_mut().zip(both) {
            lengths.extend(axes.map(|v| v.into_iter().map(|v| v * v).sum::<f64>().sqrt()));
        }
    }
    let [accel, gravity] = lengths.map(|lengths| median_of(lengths).unwrap_or(0.0));
    accel < 0.5 * gravity
}

/// Whether the last four columns of a table as wide as a trajectory's are unit quaternions.
fn ends_with_quaternion(mut rows: Rows<'_>) -> bool {
    const ROWS: usize = 50;
    let width = rows.width();
    let mut norms = (0..ROWS).map_while(|_| match rows.advance() {
        Ok(true) => Some(rows.numbers([width - 4, width - 3, width - 2, width - 1], [SLOTS[0]; 4])),
        _ => None,
    });
    let is_unit = |row: Result<[f64; 4], IoError>| {
        row.is_ok_and(|q| (q.iter().map(|v| v * v).sum::<f64>().sqrt() - 1.0).abs() < 1e-3)
    };
    (8..=9).contains(&width) && norms.next().is_some_and(is_unit) && norms.all(is_unit)
}

/// Whether a column of the first rows stays below a second of its unit, as what goes on a stamp of whole seconds does.
fn is_fraction(mut rows: Rows<'_>, (column, unit): (usize, TimeUnit)) -> bool {
    const ROWS: usize = 1000;
    for _ in 0..ROWS {
        let Ok(true) = rows.advance() else { break };
        if rows.number(column, SLOTS[0]).is_ok_and(|value| !(0.0..1.0).contains(&(value * unit.seconds()))) {
            return false;
        }
    }
    true
}

/// Whether a column of the first rows increases as stamps do.
fn increases(mut rows: Rows<'_>, column: usize) -> bool {
    const ROWS: usize = 50;
    let mut before = None;
    for _ in 0..ROWS {
        let Ok(true) = rows.advance() else { break };
        let stamp = rows.date(column).map(|date| date.ns() as f64);
        let Some(stamp) = stamp.or_else(|| rows.number(column, SLOTS[0]).ok()) else { return false };
        if before.replace(stamp).is_some_and(|before| stamp <= before) {
            return false;
        }
    }
    before.is_some()
}

/// Whether the first column counts the rows of a table without a header, and the second increases as stamps do.
fn is_numbered(mut rows: Rows<'_>) -> bool {
    const ROWS: usize = 10;
    let mut before: Option<[f64; 2]> = None;
    for _ in 0..ROWS {
        let Ok(true) = rows.advance() else { break };
        let Ok([number, stamp]) = rows.numbers([0, 1], [SLOTS[0]; 2]) else { return false };
        let first = number == 0.0 || number == 1.0;
        if !before.map_or(first, |[last, t]| number == last + 1.0 && stamp > t) {
            return false;
        }
        before = Some([number, stamp]);
    }
    before.is_some_and(|[last, _]| last > 1.0)
}

/// The error for a table without a header in which several triples of columns could be a sensor's: which they are, and how long.
fn several(table: &Rows<'_>, stamp: usize, among: Range<usize>) -> IoError {
    const ROWS: usize = 1000;
    let mut rows = table.clone();
    let (triples, begin) = (among.len() / 3, among.start);
    let mut lengths = vec![Vec::new(); triples];
    let names = ["a number"; 3];
    while lengths[0].len() < ROWS && matches!(rows.advance(), Ok(true)) {
        for (triple, lengths) in lengths.iter_mut().enumerate().map(|(k, lengths)| (begin + 3 * k, lengths)) {
            let numbers = rows.numbers([triple, triple + 1, triple + 2], names);
            lengths.extend(numbers.map(|v| v.into_iter().map(|v| v * v).sum::<f64>().sqrt()));
        }
    }
    let medians: Vec<Option<f64>> = lengths.into_iter().map(median_of).collect();
    let shown = |(k, median): (usize, &Option<f64>)| {
        let length = median.map_or("no numbers".to_owned(), |median| format!("{median:.4}"));
        format!("{} to {}: {length}", begin + 3 * k + 1, begin + 3 * k + 3)
    };
    let found = medians.iter().enumerate().map(shown).collect::<Vec<_>>().join(", ");
    let gravity = medians.iter().position(|median| median.is_some_and(guess::is_gravity));
    let choice = |gyro: usize| {
        let of = |k: usize| [1, 2, 3].map(|at| (begin + 3 * k + at).to_string()).join(",");
        format!("--columns {},{},{}", stamp + 1, of(gyro), gravity.map_or_else(|| "AX,AY,AZ".to_owned(), of))
    };
    let others = (0..triples.min(4)).filter(|k| Some(*k) != gravity && medians[*k].is_some());
    let choices = others.map(choice).collect::<Vec<_>>().join(" or ");
    table.below(RowFault::SeveralTriples { columns: rows.width(), found, choices })
}

/// Stamps and intervals of the first thousand rows, as numbers.
#[derive(Debug)]
struct FirstRows {
    stamps: Vec<f64>,
    /// The stamps are dates or times of day, here in nanoseconds.
    are_dates: bool,
    intervals: Vec<f64>,
}

impl FirstRows {
    /// The usual step; rows that stand there twice have none.
    fn step(&self) -> Option<f64> {
        upper_median(self.stamps.windows(2).map(|w| w[1] - w[0]).filter(|step| *step != 0.0))
    }

    /// Whether the stamps are 0, 1, 2, ..., or begin at 1.
    fn count_rows(&self) -> bool {
        matches!(self.stamps.first(), Some(0.0 | 1.0)) && self.stamps.windows(2).all(|w| w[1] - w[0] == 1.0)
    }
}

/// Reads them; `loose` passes over rows that cannot be read, as long as one can.
fn first_rows(
    mut rows: Rows<'_>,
    columns: &ImuColumns,
    loose: bool,
    stamped: bool,
) -> Result<FirstRows, IoError> {
    const ROWS: usize = 1000;
    let mut first = FirstRows { stamps: Vec::with_capacity(ROWS), are_dates: false, intervals: Vec::new() };
    let mut passed = None;
    while first.stamps.len() < ROWS {
        let mut stamp = |rows: &Rows<'_>| match rows.date(columns.time).filter(|_| stamped) {
            Some(date) => {
                first.are_dates = true;
                Ok(date.ns() as f64)
            }
            None if stamped => rows.number(columns.time, SLOTS[0]),
            None => Ok(0.0),
        };
        match rows.advance().and_then(|more| more.then(|| stamp(&rows)).transpose()) {
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
fn guess_interval(first: &FirstRows, step_s: f64) -> f64 {
    let interval = upper_median(first.intervals.iter().copied()).unwrap_or(0.0);
    let far = |unit: &TimeUnit| (interval * unit.seconds() / step_s).ln().abs();
    let near = TimeUnit::USUAL.into_iter().min_by(|a, b| far(a).total_cmp(&far(b)));
    near.map_or(1.0, TimeUnit::seconds)
}

/// Tells the unit of time from the first stamps.
fn guess_time_unit(first: &FirstRows, said: &Said, path: &Path) -> Result<TimeUnit, IoError> {
    let (Some(step), Some(&start)) = (first.step(), first.stamps.first()) else {
        let (path, found) = (path.to_path_buf(), first.stamps.len());
        return Err(if found > 1 {
            IoError::OneStamp { path, found }
        } else {
            IoError::TooShort { path, found }
        });
    };
    if said.fine {
        // Xsens' MTi count in 100 us, their Dots in 1 us; the former give 10 Hz or more, the latter 120 Hz or less.
        return Ok(if step > 1000.5 { TimeUnit::Micros } else { TimeUnit::HundredMicros });
    }
    // Half a per cent of slack, so that a 10 Hz log with jitter is not taken for one of 10 kHz.
    let within = move |value: f64, least: f64, most: f64| (least * 0.995..most * 0.995).contains(&value);
    // A sensor's clock of ns that has run for a week reads as us of 1991, but for its steps.
    let [century, since_1970] =
        [(CENTURY_S, 1.0), ([1e8, 1e10], SLOWEST_S)].map(|([least, most], slowest)| {
            move |unit: &TimeUnit| {
                within(start * unit.seconds(), least, most) && step * unit.seconds() <= slowest * 1.005
            }
        });
    // Newest first is a fault of its own.
    let step_s = |unit: &TimeUnit| step.abs() * unit.seconds();
    let between = |unit: &TimeUnit| within(step_s(unit), 1e-4, 1e-1);
    let find = |is: &dyn Fn(&TimeUnit) -> bool| TimeUnit::USUAL.into_iter().find(|unit| is(unit));
    if let Some(unit) = find(&century) {
        return Ok(unit);
    }
    let days = CENTURY_S.map(|seconds| seconds / TimeUnit::Days.seconds());
    if DAYS_UNTIL_1970.into_iter().any(|epoch| within(start - epoch as f64, days[0], days[1]))
        && within(step.abs() * TimeUnit::Days.seconds(), 1e-4, 1e-1)
    {
        return Ok(TimeUnit::Days);
    }
    let in_century = |epoch: i64| within(start - epoch as f64, CENTURY_S[0] * 1e7, CENTURY_S[1] * 1e7);
    if TICKS_UNTIL_1970.into_iter().any(in_century) && within(step, 1e3, 1e7) {
        return Ok(TimeUnit::HundredNanos);
    }
    let several =
        |readings| IoError::SeveralTimeUnits { path: path.to_path_buf(), first: start, step, readings };
    let Some(unit) = find(&between) else {
        return find(&since_1970).ok_or_else(|| IoError::UnknownTimeUnit {
            path: path.to_path_buf(),
            first: start,
            step,
        });
    };
    let shown = |unit: TimeUnit| format!("{unit} ({:.1} Hz)", step_s(&unit).recip());
    if first.count_rows() {
        return Err(several(format!("{}, or the rows' numbers", shown(unit))));
    }
    let longer =
        TimeUnit::USUAL.into_iter().find(|longer| (longer.seconds() / unit.seconds() - 1e3).abs() < 1.0);
    match longer {
        Some(longer) if step_s(&unit) < SURE_S * 0.995 => {
            Err(several(format!("{} or {}", shown(unit), shown(longer))))
        }
        _ => Ok(unit),
    }
}
