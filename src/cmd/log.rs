//! Somebody's log: whatever it is, to a recording.

use crate::args::{HowArgs, LogArgs};
use crate::ui::errln;
use anyhow::Result;
use dpn_io::{CsvOptions, printable};
use dpn_logs::{Log, LogOptions, Scales, read_log};
use dpn_probe::doctor::values::meaningless;
use std::path::Path;

/// Reads the log; says on stderr what was guessed and what is wrong with it.
pub(crate) fn read(args: &LogArgs) -> Result<Log> {
    read_from(&args.path, &args.how)
}

/// Reads the log and says nothing: for a command whose page says it all.
pub(crate) fn read_quietly(args: &LogArgs) -> Result<Log> {
    Ok(read_log(&args.path, &options(&args.how))?)
}

/// The same, path and manner apart.
pub(crate) fn read_from(path: &Path, how: &HowArgs) -> Result<Log> {
    let log = read_log(path, &options(how))?;
    if !log.guesses.is_empty() {
        errln!("note: taken for granted: {}", log.guesses.join(", "));
    }
    for warning in log.warnings() {
        errln!("warning: {}", printable(&warning));
    }
    for fault in meaningless(&log.recording)? {
        let remedy = fault.remedy.map(|remedy| format!(" -> {remedy}")).unwrap_or_default();
        errln!("warning: {}: {}{remedy}", fault.about, fault.text);
    }
    Ok(log)
}

/// What was typed about columns, units and topic.
pub(crate) fn options(how: &HowArgs) -> LogOptions {
    let csv = CsvOptions {
        columns: how.columns.clone(),
        time: how.time_unit,
        gyro: how.gyro_unit,
        accel: how.accel_unit,
    };
    let scales = how.sensor_scale.unwrap_or(Scales { accel: how.accel_scale, gyro: how.gyro_scale });
    LogOptions { csv, topic: how.topic.clone(), max_uncompressed: how.max_uncompressed, scales }
}
