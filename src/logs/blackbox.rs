//! Betaflight's and INAV's blackbox (`.bbl`, `.bfl`), by the crate `blackbox-log`: `gyroADC`, `accSmooth` and the motors of the main frames.
//!
//! A file holds a log an arming, each behind a header of its own that says what a count is: `gyro_scale` (the bits of a float, deg/s) and `acc_1G`. The crate
//! passes over damaged frames by itself. Axes stay as the board has them. Betaflight from 4.4 on counts tenths where its header says `blackbox_high_resolution:1`; the
//! scale beside it stays that of whole counts.

use crate::detect::BLACKBOX;
use crate::records::{Holds, Records};
use blackbox_log::frame::{Frame, FrameDef};
use blackbox_log::{File, Headers, ParserEvent};
use dpn_core::{ImuSample, Stamp};
use dpn_io::AccelUnit;

/// Reads all logs of a file; returns what is wrong where one of them cannot be read.
pub(crate) fn read(bytes: &[u8], records: &mut Records) -> Option<String> {
    let file = File::new(bytes);
    let mut damage = (file.log_count() == 0).then(|| "its first line is cut off".to_owned());
    let mut behind = bytes;
    for number in 0..file.log_count() {
        // The scales are read where the crate finds the header too.
        let at = behind.windows(BLACKBOX.len()).position(|line| line == BLACKBOX);
        let log = at.map_or(&[][..], |at| &behind[at..]);
        behind = log.get(1..).unwrap_or(log);
        match file.parse(number) {
            Some(Ok(headers)) => frames(&headers, log, records),
            Some(Err(error)) => damage = damage.or_else(|| Some(format!("log {}: {error}", number + 1))),
            None => {}
        }
    }
    damage
}

/// A header's value, by its name: the crate keeps both scales to itself, and a log without them ends its own conversion in a panic.
fn said<'a>(log: &'a [u8], name: &str) -> Option<&'a str> {
    let head = &log[..log.len().min(1 << 15)];
    let line = head
        .split(|byte| *byte == b'\n')
        .find_map(|line| line.strip_prefix(b"H ")?.strip_prefix(name.as_bytes()))?;
    std::str::from_utf8(line.strip_prefix(b":")?).ok().map(str::trim)
}

fn frames(headers: &Headers<'_>, log: &[u8], records: &mut Records) {
    let mut parser = headers.data_parser();
    let names: Vec<&str> = headers.main_frame_def().iter().map(|field| field.name).collect();
    let at = |name: &str| {
        (0..3)
            .map(|axis| names.iter().position(|n| *n == format!("{name}[{axis}]")))
            .collect::<Option<Vec<usize>>>()
    };
    let bits =
        said(log, "gyro_scale").and_then(|hex| u32::from_str_radix(hex.trim_start_matches("0x"), 16).ok());
    let finer = if said(log, "blackbox_high_resolution").is_some_and(|on| on != "0") { 10.0 } else { 1.0 };
    let turn = bits.map(|bits| f64::from(f32::from_bits(bits)).to_radians() / finer);
    let force = said(log, "acc_1G")
        .and_then(|count| count.parse::<f64>().ok())
        .map(|count| AccelUnit::StandardGravity.factor() / count);
    let [gyro, accel] = [(at("gyroADC"), turn), (at("accSmooth"), force)].map(|(at, scale)| at.zip(scale));
    let holds = match (&gyro, &accel) {
        (Some(_), Some(_)) => Holds::Both,
        (Some(_), None) => Holds::Gyro,
        _ => Holds::Accel,
    };
    let motors: Vec<usize> = (0..names.len()).filter(|i| names[*i].starts_with("motor[")).collect();
    let Some(source) = records.source("blackbox", 0, holds, 0) else { return };
    while let Some(event) = parser.next() {
        let ParserEvent::Main(frame) = event else { continue };
        let Some(t) =
            frame.time_raw().checked_mul(1000).and_then(|ns| i64::try_from(ns).ok()).map(Stamp::from_ns)
        else {
            continue;
        };
        let raw = |at: usize| frame.get_raw(at).map_or(f64::NAN, |raw| f64::from(raw.cast_signed()));
        let axes = |of: &Option<(Vec<usize>, f64)>| {
            of.as_ref().map_or([0.0; 3], |(at, scale)| [0, 1, 2].map(|k| raw(at[k]) * scale))
        };
        records.push(source, ImuSample { t, gyro: axes(&gyro), accel: axes(&accel) });
        records.motors(0, t, motors.iter().map(|at| raw(*at)));
    }
}
