//! IMU logs as tables of numbers: ASL's `imu0/data.csv` and plain CSV files with other columns and units ([`Understood`]). One row that no recording may hold,
//! and the log is refused.

use super::rows::Rows;
use super::understood::{CsvOptions, Understood};
use super::{IoError, TimeUnit};
use dpn_core::imu::{ImuRecording, ImuSample};
use std::path::Path;

/// A log that was read, and how it was understood.
#[derive(Debug, Clone, PartialEq)]
pub struct ImuLog {
    /// The samples, in rad/s and m/s^2.
    pub recording: ImuRecording,
    /// Its columns and their units.
    pub understood: Understood,
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
    let understood = Understood::of(&rows, path, options, None, assumed_time, false)?;
    let mut samples: Vec<ImuSample> = Vec::with_capacity(rows.rows_left());
    while let Some(sample) = understood.next(&mut rows)? {
        rows.must_follow(samples.last().map(|s| s.t), sample.t)?;
        let sample = understood.in_si(sample);
        if !sample.is_finite() {
            return Err(rows.not_finite("a value in SI units", "infinite"));
        }
        samples.push(sample);
    }
    match samples.len() {
        found @ 0..2 => Err(IoError::TooShort { path: path.to_path_buf(), found }),
        _ => {
            let recording =
                ImuRecording::new(samples).expect("every row was finite and later than the one before");
            Ok(ImuLog { recording, understood })
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::row_fault::RowFault;
    use crate::{AccelUnit, GyroUnit, ImuColumns, Origin, Settled};
    use dpn_core::Stamp;

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
            (12.5, 0.5, TimeUnit::Millis),
            (12.5, 0.099, TimeUnit::Seconds),
            (0.0, 1250.0, TimeUnit::Micros),
            (0.0, 5e6, TimeUnit::Nanos),
            (1.335e17, 1e5, TimeUnit::HundredNanos),
            (6.385e17, 5e4, TimeUnit::HundredNanos),
        ];
        for (start, step, unit) in cases {
            let log = case(&stamped(start, step), &CsvOptions::default()).unwrap();
            let expected = Settled { value: unit, origin: Origin::Guessed };
            assert_eq!(log.understood.time, expected, "from {start} by {step}");
        }
        let error = case(&stamped(0.0, 1e9), &CsvOptions::default()).unwrap_err();
        assert!(matches!(error, IoError::UnknownTimeUnit { .. }), "{error}");
        assert!(error.hint().unwrap().contains("ns"));
        for (start, step, readings) in [
            (12.5, 0.1, "could be ms (10000.0 Hz) or s (10.0 Hz)"),
            (700.0, 200.0, "could be us (5000.0 Hz) or ms (5.0 Hz)"),
            (1.0, 1.0, "could be ms (1000.0 Hz), or the rows' numbers"),
        ] {
            let error = case(&stamped(start, step), &CsvOptions::default()).unwrap_err().to_string();
            assert!(error.ends_with(readings), "{error}");
        }
    }

    #[test]
    fn degrees_and_g_become_si_and_the_caller_wins_over_the_header() {
        let text = "time_s,ax [g],ay [g],az [g],gx [deg/s],gy [deg/s],gz [deg/s]\n0.5,0,0,1,180,0,-90\n0.505,0,0,1,0,0,0\n";
        let log = case(text, &CsvOptions::default()).unwrap();
        let first = log.recording.samples()[0];
        assert_eq!(first.t, Stamp::from_ns(500_000_000));
        assert_eq!(first.accel, [0.0, 0.0, 9.80665]);
        assert!((first.gyro[0] - std::f64::consts::PI).abs() < 1e-15);
        assert_eq!(log.understood.gyro, Settled { value: GyroUnit::DegPerSecond, origin: Origin::Header });

        let given = CsvOptions {
            time: Some(TimeUnit::Millis),
            accel: Some(AccelUnit::MetrePerSecond2),
            ..CsvOptions::default()
        };
        let log = case(text, &given).unwrap();
        assert_eq!(log.recording.samples()[1].t, Stamp::from_ns(505_000));
        assert_eq!(log.recording.samples()[0].accel[2], 1.0);
        assert_eq!(log.understood.accel.origin, Origin::Given);
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
        assert!(matches!(error, IoError::Row { line: 2, fault: RowFault::NotFinite { .. }, .. }), "{error}");
    }
}
