//! Somebody's log: whatever it is, to a recording.

use crate::args::{HowArgs, LogArgs, SpanArgs};
use crate::ui::errln;
use anyhow::Result;
use dpn_io::{CsvOptions, printable};
use dpn_logs::{Log, LogOptions, LogSpan, Scales, read_log};
use dpn_probe::doctor::values::meaningless;
use std::path::Path;

/// Reads the log; says on stderr what was guessed and what is wrong with it.
pub(crate) fn read(args: &LogArgs) -> Result<Log> {
    read_part(&args.path, args.span, &args.how)
}

/// Reads the log and says nothing: for a command whose page says it all.
pub(crate) fn read_quietly(path: &Path, span: SpanArgs, how: &HowArgs) -> Result<Log> {
    Ok(read_log(path, &part_of(options(how), span))?)
}

/// The same, path, part and manner apart.
pub(crate) fn read_part(path: &Path, span: SpanArgs, how: &HowArgs) -> Result<Log> {
    let log = read_log(path, &part_of(options(how), span))?;
    if !log.guesses.is_empty() {
        errln!("note: taken for granted: {}", log.guesses.join(", "));
    }
    for warning in log.warnings() {
        errln!("warning: {}", printable(&warning));
    }
    for fault in meaningless(&log.recording, log.alone)? {
        let remedy = fault.remedy.map(|remedy| format!(" -> {remedy}")).unwrap_or_default();
        errln!("warning: {}: {}{remedy}", fault.about, fault.text);
    }
    Ok(log)
}

/// What was typed about a log.
pub(crate) fn options_of(args: &LogArgs) -> LogOptions {
    part_of(options(&args.how), args.span)
}

fn part_of(options: LogOptions, SpanArgs { from, to }: SpanArgs) -> LogOptions {
    LogOptions { span: LogSpan { from, to }, ..options }
}

/// What was typed about columns, units and topic.
pub(crate) fn options(how: &HowArgs) -> LogOptions {
    let csv = CsvOptions {
        columns: how.columns.clone(),
        time: how.time_unit,
        gyro: how.gyro_unit,
        accel: how.accel_unit,
        rate: how.rate,
    };
    let scales = how.sensor_scale.unwrap_or(Scales { accel: how.accel_scale, gyro: how.gyro_scale });
    let (topic, max_uncompressed) = (how.topic.clone(), how.max_uncompressed);
    LogOptions { csv, topic, max_uncompressed, scales, ..LogOptions::default() }
}
