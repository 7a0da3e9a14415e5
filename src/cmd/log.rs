//! Somebody's log: a folder or a file to a recording.

use crate::args::LogArgs;
use anyhow::Result;
use dpn_core::ImuRecording;
use dpn_core::io::asl::Sequence;
use dpn_core::io::{CsvOptions, Origin, read_imu_csv};

/// Reads the log and says on stderr what was guessed.
pub(crate) fn read(args: &LogArgs) -> Result<ImuRecording> {
    if args.path.is_dir() {
        return Ok(Sequence::open(&args.path)?.imu()?);
    }
    let options = CsvOptions {
        columns: args.columns,
        time: args.time_unit,
        gyro: args.gyro_unit,
        accel: args.accel_unit,
    };
    let log = read_imu_csv(&args.path, &options)?;
    let guess = |origin| matches!(origin, Origin::Guessed | Origin::Assumed);
    let mut taken = Vec::new();
    if guess(log.columns.origin) {
        taken.push("columns as stamp, gyroscope, accelerometer (--columns)".to_owned());
    }
    if guess(log.time.origin) {
        taken.push(format!("stamps in {} (--time-unit)", log.time.value));
    }
    if guess(log.gyro.origin) {
        taken.push(format!("gyroscope in {} (--gyro-unit)", log.gyro.value.name()));
    }
    if guess(log.accel.origin) {
        taken.push(format!("accelerometer in {} (--accel-unit)", log.accel.value.name()));
    }
    if !taken.is_empty() {
        eprintln!("note: taken for granted: {}", taken.join(", "));
    }
    Ok(log.recording)
}
