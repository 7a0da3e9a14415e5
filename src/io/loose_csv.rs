//! Somebody's IMU log as text, faults and all: what can be used is, and what cannot is counted.
//!
//! Where [`read_imu_csv`](super::read_imu_csv) refuses, this goes on: rows that cannot be read, and samples that a [`Sieve`] leaves out,
//! are counted with the first one's place. A file whose rows are mostly of that kind is refused all the same, with the first row's
//! error: it is no log of this layout.
//!
//! What neither caller nor header says of the units is guessed from the numbers (`guess`), and so are columns without a header. The file is
//! read in blocks: beside the samples no more than one of them is in memory.

use super::columns::{AccelUnit, GyroUnit, ImuColumns};
use super::row_fault::RowFault;
use super::rows::{Layout, Rows};
use super::sample_store::{SampleStore, StoredRecording};
use super::sieve::{Part, Sieve, Sieved, Sifted};
use super::understood::{CsvOptions, Origin, Settled, Understood};
use super::{IoError, TimeUnit, guess, head};
use dpn_core::imu::ImuSample;
use dpn_core::{Samples, Sensor, Stamp};
use std::io::{self, Read};
use std::path::Path;

/// Bytes read at a time; the first block tells columns and units of time.
const BLOCK: usize = 1 << 22;
/// Share of rows that may be unreadable, and of samples that may be left out.
const TOLERATED: f64 = 0.1;

/// Rows that could not be read.
#[derive(Debug, Default)]
pub struct Unreadable {
    /// How many.
    pub count: usize,
    /// What is wrong with the first.
    pub first: Option<IoError>,
    /// Whether the only one is the last line, cut off.
    pub cut: bool,
}

/// A log read loosely, and how it was understood.
#[derive(Debug)]
pub struct LooseImuLog {
    /// The samples that could be used, in rad/s and m/s^2.
    pub recording: StoredRecording,
    /// Its columns and their units.
    pub understood: Understood,
    /// Where in the file they stand: the first and the last one's lines.
    pub places: [u64; 2],
    /// Where stamps begin anew or two write at once, the other parts, in the same units.
    pub others: Vec<Part>,
    /// Samples left out; places are lines.
    pub sieved: Sieved,
    /// Rows that could not be read.
    pub unreadable: Unreadable,
    /// How often the stamps' counter of 32 bits began anew.
    pub wraps: usize,
    /// A rate that the lines above the header name \[Hz\].
    pub said_hz: Option<f64>,
}

/// Reads a log of all six axes, with its faults, from any source of bytes; `path` is for messages.
///
/// # Errors
/// A source that cannot be read or holds no row; a column that is missing; a unit of time that cannot be told; fewer than two samples of
/// use; a log in which more than a tenth of the rows cannot be used.
pub fn parse_imu_csv_loosely(
    source: impl Read,
    path: &Path,
    options: &CsvOptions,
) -> Result<LooseImuLog, IoError> {
    parse(source, path, options, None)
}

/// The same from a file that holds one sensor alone, stamps and three axes: both triples of a sample are its axes. A unit that neither caller
/// nor file names is [`Origin::Assumed`] to be SI, to be told by [`settle_units`] once the other sensor is beside it.
///
/// # Errors
/// As [`parse_imu_csv_loosely`].
pub fn parse_one_sensor_loosely(
    source: impl Read,
    path: &Path,
    options: &CsvOptions,
    sensor: Sensor,
) -> Result<LooseImuLog, IoError> {
    parse(source, path, options, Some(sensor))
}

fn parse(
    source: impl Read,
    path: &Path,
    options: &CsvOptions,
    only: Option<Sensor>,
) -> Result<LooseImuLog, IoError> {
    let mut blocks = Blocks::new(source, path);
    let mut sieve = Sieve::default();
    let mut unreadable = Unreadable::default();
    let mut counter = Counter::default();
    let mut said_hz = None;
    let mut known: Option<(Understood, Layout)> = None;
    while blocks.advance()? {
        let bytes = blocks.block();
        let (understood, mut rows) = match known.take() {
            None => {
                said_hz = head::said_rate(bytes);
                let rows = head::open(bytes, path, only)?;
                (Understood::of(&rows, path, options, only, None, true)?, rows)
            }
            Some((understood, layout)) => (understood, Rows::go_on(bytes, path, layout)),
        };
        take(&mut rows, &understood, &mut counter, &mut sieve, &mut unreadable)?;
        known = Some((understood, rows.layout()));
    }
    let Some((understood, layout)) = known else {
        return Err(IoError::Empty { path: path.to_path_buf() });
    };
    let last_line = layout.line() as u64;
    unreadable.cut = unreadable.count == 1
        && !blocks.ended_with_newline
        && {
            let at = |e: &IoError| matches!(e, IoError::Row { line, fault: RowFault::FieldCount { .. } | RowFault::BadNumber { .. }, .. } if *line as u64 == last_line);
            unreadable.first.as_ref().is_some_and(at)
        };
    let log = finish(path, understood, sieve, unreadable, only)?;
    // A midnight is none of a counter.
    let wraps = if log.understood.are_dates { 0 } else { counter.wraps };
    Ok(LooseImuLog { wraps, said_hz, ..log })
}

fn finish(
    path: &Path,
    mut understood: Understood,
    sieve: Sieve,
    mut unreadable: Unreadable,
    only: Option<Sensor>,
) -> Result<LooseImuLog, IoError> {
    let storing = |e| IoError::reading(path, e);
    let Sifted { part: Part { mut samples, places }, mut others, sieved } = sieve.done().map_err(storing)?;
    let others_len: usize = others.iter().map(|part| part.samples.len()).sum();
    let all = (samples.len() + others_len + sieved.count() + unreadable.count) as f64;
    if unreadable.count as f64 > TOLERATED * all
        && !unreadable.cut
        && let Some(first) = unreadable.first.take()
    {
        return Err(first);
    }
    if let Some(line) = sieved.backward.first
        && sieved.backward.count as f64 > TOLERATED * all
    {
        let (path, count) = (path.to_path_buf(), sieved.backward.count);
        return Err(IoError::GoesBack { path, count, of: all as usize, line });
    }
    let columns = &mut understood.columns;
    if columns.origin == Origin::Assumed && guess::swapped(&samples).map_err(storing)? {
        let ImuColumns { time, gyro, accel, .. } = columns.value;
        *columns = Settled { value: ImuColumns::new(time, accel, gyro), origin: Origin::Guessed };
        let swap = |s: ImuSample| Some(ImuSample { gyro: s.accel, accel: s.gyro, ..s });
        samples = samples.changed(swap).map_err(storing)?;
        for part in &mut others {
            part.samples = std::mem::take(&mut part.samples).changed(swap).map_err(storing)?;
        }
    }
    let (gyro, accel) = (understood.gyro, understood.accel);
    let settled = match only {
        None => settle_units(samples, gyro, accel),
        Some(_) => in_si(samples, gyro.value, accel.value).map(|samples| (samples, gyro, accel)),
    };
    let samples;
    (samples, understood.gyro, understood.accel) = settled.map_err(storing)?;
    for part in &mut others {
        let as_read = std::mem::take(&mut part.samples);
        part.samples = in_si(as_read, understood.gyro.value, understood.accel.value).map_err(storing)?;
    }
    let short = |found| {
        let path = path.to_path_buf();
        match (sieved.repeated.count, sieved.not_finite.count + sieved.absurd.count) {
            (0, 0) => IoError::TooShort { path, found },
            (0, left) => IoError::NoValues { path, left, found },
            (repeated, _) => IoError::OneStamp { path, found: found + repeated },
        }
    };
    let recording = samples.recording().map_err(storing)?.map_err(short)?;
    Ok(LooseImuLog { recording, places, others, understood, sieved, unreadable, wraps: 0, said_hz: None })
}

/// Brings samples to rad/s and m/s^2; units that are [`Origin::Assumed`] are told from the numbers.
///
/// # Errors
/// A temporary file that cannot be read or written.
pub fn settle_units(
    samples: SampleStore,
    mut gyro: Settled<GyroUnit>,
    mut accel: Settled<AccelUnit>,
) -> io::Result<(SampleStore, Settled<GyroUnit>, Settled<AccelUnit>)> {
    if gyro.origin == Origin::Assumed {
        gyro = Settled { value: guess::gyro_unit(&samples)?, origin: Origin::Guessed };
    }
    if accel.origin == Origin::Assumed {
        accel = Settled { value: guess::accel_unit(&samples)?, origin: Origin::Guessed };
    }
    Ok((in_si(samples, gyro.value, accel.value)?, gyro, accel))
}

fn in_si(samples: SampleStore, gyro: GyroUnit, accel: AccelUnit) -> io::Result<SampleStore> {
    match (gyro.factor(), accel.factor()) {
        (1.0, 1.0) => Ok(samples),
        // A unit can make a number too large of one that was finite.
        (turn, force) => samples.changed(|s| {
            let (gyro, accel) = (s.gyro.map(|v| v * turn), s.accel.map(|v| v * force));
            Some(ImuSample { gyro, accel, ..s }).filter(ImuSample::is_finite)
        }),
    }
}

/// Takes the rows of one block.
fn take(
    rows: &mut Rows<'_>,
    understood: &Understood,
    counter: &mut Counter,
    sieve: &mut Sieve,
    unreadable: &mut Unreadable,
) -> Result<(), IoError> {
    let round = Round::of(understood);
    loop {
        let row = understood.next(rows);
        let line = rows.line() as u64;
        match row {
            Ok(None) => return Ok(()),
            Ok(Some(sample)) => {
                let t = round.map_or(sample.t, |round| counter.unwrapped(sample.t, round));
                sieve.push(ImuSample { t, ..sample }, line);
            }
            Err(IoError::Row { fault: RowFault::NotFinite { .. }, .. }) => sieve.not_finite(line),
            Err(error) => {
                unreadable.count += 1;
                unreadable.first.get_or_insert(error);
                // Of a binary file every row is bad: enough of it.
                if unreadable.count > 1000
                    && sieve.is_empty()
                    && let Some(first) = unreadable.first.take()
                {
                    return Err(first);
                }
            }
        }
    }
}

/// Stamps that may begin anew: a counter of 32 bits, one of microseconds after 71.6 minutes, or times of day at midnight.
#[derive(Debug, Default)]
struct Counter {
    last: Option<Stamp>,
    wraps: usize,
}

/// After what stamps begin anew, and how near to the ends of it they must be before and behind \[ns\].
#[derive(Debug, Clone, Copy)]
struct Round {
    round_ns: i64,
    near_ns: i64,
}

impl Round {
    /// None of days: nobody counts them in 32 bits. Dates are of another size than times of day and stay as they are.
    fn of(understood: &Understood) -> Option<Self> {
        const HOUR_NS: i64 = 3_600_000_000_000;
        let step_ns = match understood.time.value {
            _ if understood.are_dates => return Some(Self { round_ns: 24 * HOUR_NS, near_ns: HOUR_NS }),
            TimeUnit::Days => return None,
            unit => (unit.seconds() * 1e9) as i64,
        };
        Some(Self { round_ns: step_ns << 32, near_ns: step_ns << 24 })
    }
}

impl Counter {
    /// `t` behind all wraps so far.
    fn unwrapped(&mut self, t: Stamp, Round { round_ns, near_ns }: Round) -> Stamp {
        let is_wrap = |last: Stamp| {
            (0..near_ns).contains(&t.ns()) && (round_ns - near_ns..round_ns).contains(&last.ns())
        };
        self.wraps += usize::from(self.last.replace(t).is_some_and(is_wrap));
        Stamp::from_ns(t.ns().saturating_add(round_ns.saturating_mul(self.wraps as i64)))
    }
}

/// A source of bytes in blocks that end with a line.
struct Blocks<'a, R> {
    source: R,
    path: &'a Path,
    buffer: Vec<u8>,
    /// Bytes of the block handed out, and those of the next one behind it.
    block: usize,
    filled: usize,
    at_end: bool,
    ended_with_newline: bool,
}

impl<'a, R: Read> Blocks<'a, R> {
    fn new(source: R, path: &'a Path) -> Self {
        Self {
            source,
            path,
            buffer: vec![0; BLOCK],
            block: 0,
            filled: 0,
            at_end: false,
            ended_with_newline: true,
        }
    }

    /// Goes to the next block; `false` at the end.
    fn advance(&mut self) -> Result<bool, IoError> {
        self.buffer.copy_within(self.block..self.filled, 0);
        self.filled -= self.block;
        self.block = 0;
        while !self.at_end && self.filled < self.buffer.len() {
            match self.source.read(&mut self.buffer[self.filled..]) {
                Ok(0) => self.at_end = true,
                Ok(read) => self.filled += read,
                Err(e) if e.kind() == std::io::ErrorKind::Interrupted => {}
                Err(e) => return Err(IoError::reading(self.path, e)),
            }
        }
        let held = &self.buffer[..self.filled];
        self.block = match memchr::memrchr(b'\n', held) {
            _ if self.at_end => self.filled,
            Some(at) => at + 1,
            // A line longer than a block is no row; it is handed out in parts.
            None => self.filled,
        };
        if let Some(last) = held.get(self.block.wrapping_sub(1)) {
            self.ended_with_newline = *last == b'\n';
        }
        Ok(self.block > 0)
    }

    fn block(&self) -> &[u8] {
        &self.buffer[..self.block]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::read_imu_csv;
    use crate::sieve::LeftOut;
    use dpn_core::time::Stamp;

    fn read(text: &str) -> Result<LooseImuLog, IoError> {
        parse_imu_csv_loosely(text.as_bytes(), Path::new("log.csv"), &CsvOptions::default())
    }

    /// Ten rows a sensor at rest could have written.
    fn lines() -> Vec<String> {
        (0..30)
            .map(|i| format!("{},0.01,0,0,0.1,0,{}", 1.4e9 + f64::from(i) * 0.01, 9.81 + f64::from(i % 3)))
            .collect()
    }

    #[test]
    fn a_spreadsheets_quotes_keep_decimal_commas_together() {
        let quoted = |line: &String| {
            let fields = line.split(',').map(|field| format!("\"{}\"", field.replace('.', ",")));
            fields.collect::<Vec<_>>().join(",")
        };
        let plain = read(&lines().join("\n")).unwrap();
        let text = lines().iter().map(quoted).collect::<Vec<_>>().join("\n");
        let header = "\"t\",\"gx\",\"gy\",\"gz\",\"ax\",\"ay\",\"az\"\n";
        let log = read(&format!("{header}{text}")).unwrap();
        let samples = |log: &LooseImuLog| log.recording.piece(0..30).unwrap().into_owned();
        assert_eq!(samples(&log), samples(&plain));
    }

    #[test]
    fn stamps_that_are_dates_or_times_of_day_are_read_and_others_are_named() {
        let header = "time [s],gx,gy,gz,ax,ay,az\n";
        let of = |date: &str| {
            let row = |i: usize| format!("{date}10:11:{:02}.{:02},0,0,0,0,0,9.81\n", i / 100, i % 100);
            read(&format!("{header}{}", (0..300).map(row).collect::<String>()))
        };
        for (date, first) in [("", 36_660_000_000_000), ("2023-10-29 ", 1_698_574_260_000_000_000)] {
            let log = of(date).unwrap();
            let samples = log.recording.piece(0..300).unwrap().into_owned();
            assert_eq!((samples[0].t.ns(), samples[299].t.ns() - first), (first, 2_990_000_000));
        }
        let error = of("29.10.2023 ").unwrap_err();
        assert!(error.to_string().starts_with("log.csv:2: "), "{error}");
        assert!(error.hint().unwrap().contains("year first"), "{:?}", error.hint());
    }

    #[test]
    fn a_counter_of_32_bits_goes_on_where_it_begins_anew() {
        let header = "SampleTimeFine,Gyr_X,Gyr_Y,Gyr_Z,Acc_X,Acc_Y,Acc_Z\n";
        let rows: String = (0..200_u32)
            .map(|i| format!("{},0.01,0,0,0,0,9.81\n", 4_294_500_000_u32.wrapping_add(8333 * i)))
            .collect();
        let log = read(&format!("{header}{rows}")).unwrap();
        let samples = log.recording.piece(0..200).unwrap().into_owned();
        assert!(samples.windows(2).all(|pair| pair[1].t.ns() - pair[0].t.ns() == 8_333_000));
        assert_eq!((log.wraps, log.sieved.count()), (1, 0));
    }

    #[test]
    fn faults_are_counted_with_their_lines_and_the_rest_is_used() {
        let mut lines = lines();
        lines[4] = lines[3].clone();
        lines[9] = lines[9].replace("0.01", "nan");
        let log = read(&lines.join("\n")).unwrap();
        assert_eq!(log.recording.len(), 28);
        assert_eq!(log.sieved.repeated, LeftOut { count: 1, first: Some(5) });
        assert_eq!(log.sieved.not_finite, LeftOut { count: 1, first: Some(10) });
        assert_eq!(log.unreadable.count, 0);
        lines[20] = "what is this".into();
        let log = read(&lines.join("\n")).unwrap();
        assert_eq!(log.unreadable.count, 1);
        assert!(log.unreadable.first.unwrap().to_string().starts_with("log.csv:21: "));
        assert!(!log.unreadable.cut);
    }

    #[test]
    fn a_last_line_cut_off_is_told_from_a_damaged_one() {
        let text = lines().join("\n") + "\n1400000000.3,0.01,0,";
        let log = read(&text).unwrap();
        assert!(log.unreadable.cut && log.unreadable.count == 1);
        assert_eq!(log.recording.len(), 30);
    }

    #[test]
    fn what_is_mostly_unreadable_is_refused_with_its_first_line() {
        let mut lines = lines();
        for line in &mut lines[5..10] {
            *line = "1,2".into();
        }
        let error = read(&lines.join("\n")).unwrap_err().to_string();
        assert!(error.starts_with("log.csv:6: 2 fields, expected 7"), "{error}");
        assert!(matches!(read(""), Err(IoError::Empty { .. })));
    }

    #[test]
    fn columns_and_units_that_nobody_named_are_guessed() {
        let text: String = (0..800)
            .map(|i| {
                format!(
                    "{},0,0,{},{},0,0\n",
                    i * 5000,
                    1.0 + 0.002 * f64::from(i % 2),
                    0.1 * f64::from(i % 3)
                )
            })
            .collect();
        let log = read(&text).unwrap();
        assert_eq!(log.understood.time, Settled { value: TimeUnit::Micros, origin: Origin::Guessed });
        assert_eq!(log.understood.columns.value, ImuColumns::new(0, [4, 5, 6], [1, 2, 3]));
        assert_eq!(log.understood.columns.origin, Origin::Guessed);
        assert_eq!(
            (log.understood.accel.value, log.understood.gyro.value),
            (AccelUnit::StandardGravity, GyroUnit::DegPerSecond)
        );
        assert!((log.recording.at(0).unwrap().accel[2] - 9.80665).abs() < 1e-12);
    }

    #[test]
    fn a_sound_log_reads_as_the_strict_reader_reads_it_across_blocks() {
        let mut text = String::from("t_ns,gx [rad/s],gy,gz,ax [m/s^2],ay,az\n");
        for i in 0..120_000i64 {
            text.push_str(&format!("{},0.0{},-0.02,0.3,1.25,-3.{},9.81\n", i * 5_000_000, i % 977, i % 613));
        }
        assert!(text.len() > BLOCK);
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("log.csv");
        std::fs::write(&path, text).unwrap();
        let loose = parse_imu_csv_loosely(std::fs::File::open(&path).unwrap(), &path, &CsvOptions::default())
            .unwrap();
        let strict = read_imu_csv(&path, &CsvOptions::default()).unwrap();
        let recording = loose.recording.held().unwrap();
        assert_eq!(recording, strict.recording);
        assert_eq!(recording.samples()[119_999].t, Stamp::from_ns(119_999 * 5_000_000));
        assert_eq!(loose.sieved, Sieved::default());
    }

    #[test]
    fn times_of_day_go_on_over_midnight() {
        let row = |i: usize| {
            let s = (86_370 + i / 10) % 86_400;
            format!("{:02}:{:02}:{:02}.{}00,0.01,0,0,0,0,9.81\n", s / 3600, s / 60 % 60, s % 60, i % 10)
        };
        let rows: String = (0..600).map(row).collect();
        let log = read(&format!("time,gx,gy,gz,ax,ay,az\n{rows}")).unwrap();
        let samples = log.recording.piece(0..600).unwrap().into_owned();
        assert!(samples.windows(2).all(|pair| pair[1].t.ns() - pair[0].t.ns() == 100_000_000));
        assert!(log.others.is_empty() && log.sieved.count() == 0);
    }

    #[test]
    fn rows_that_share_one_stamp_are_not_too_few_but_to_be_counted() {
        let rows = "1.700000e9,0.01,0,0,0,0,9.81\n".repeat(50);
        for time in ["time [s]", "time"] {
            let error = read(&format!("{time},gx,gy,gz,ax,ay,az\n{rows}")).unwrap_err();
            assert_eq!(error.to_string(), "log.csv: 50 samples have one stamp");
            assert!(error.hint().unwrap().contains("--rate HZ"));
        }
        let rows = rows.replace("9.81", "nan");
        let error = read(&format!("time [s],gx,gy,gz,ax,ay,az\n{rows}")).unwrap_err().to_string();
        assert!(
            error.starts_with("log.csv: 50 samples have NaN") && error.ends_with("and 0 is left"),
            "{error}"
        );
        // Every row twice: its steps tell the unit as before.
        let twice = lines().iter().map(|line| format!("{line}\n{line}\n")).collect::<String>();
        let log = read(&format!("time,gx,gy,gz,ax,ay,az\n{twice}")).unwrap();
        assert_eq!((log.recording.len(), log.sieved.repeated.count), (30, 30));
    }

    #[test]
    fn a_name_before_a_number_is_told_from_a_date() {
        let row = |i: usize| format!("{},gx:{},0,0,0,0,9.81\n", i * 10, 0.1);
        let rows: String = (0..50).map(row).collect();
        let error = read(&format!("time [ms],gx,gy,gz,ax,ay,az\n{rows}")).unwrap_err();
        assert!(error.hint().unwrap().starts_with("a name before each number"), "{:?}", error.hint());
    }
}
