//! ArduPilot's logs, binary and text: their formats and the records `IMU`, `IMU2`, `IMU3` from front to back, and `CTUN`, whose `ThO` is what the motors are told together.
//!
//! A binary record begins with 0xA3 0x95 and its type's number; a record `FMT` (128) gives number, length, name, types and names of the fields.
//! In text a record is a line of its name and its fields, and `FMT` lines name those. Axes are forward, right, down; `T` is a temperature.
//! Source: ardupilot.org/dev, "Adding a new log message"; AP_Logger/LogStructure.h.

use crate::bytes::Bytes;
use crate::records::{Holds, Records};
use crate::rosbag1::CountedReader;
use dpn_core::{ImuSample, Stamp};
use std::collections::HashMap;
use std::io::{self, BufRead, Read};

/// A binary log begins with the `FMT` of `FMT`.
pub(crate) const MAGIC: &[u8] = &[0xa3, 0x95, 0x80];
const FORMAT: u8 = 128;
/// A line is no longer.
const LONGEST_LINE: u64 = 1 << 16;
/// Fields of the records that newer firmware writes, where a text log was cut to its `IMU` lines.
const FIELDS: &str = "TimeUS,I,GyrX,GyrY,GyrZ,AccX,AccY,AccZ";
/// Those of firmware before 4.1, which has less than fifteen.
const OLD_FIELDS: &str = "TimeUS,GyrX,GyrY,GyrZ,AccX,AccY,AccZ";

/// Which field is what.
#[derive(Debug)]
struct Layout {
    time: usize,
    /// Nanoseconds in one of its unit.
    tick_ns: i64,
    instance: Option<usize>,
    /// Of an IMU's record six; of [`MOTORS`] the output alone.
    axes: Vec<usize>,
    /// How many fields a record has.
    count: usize,
}

impl Layout {
    /// `None` where a field is missing.
    fn new<'a>(record: &str, names: &(impl Iterator<Item = &'a str> + Clone)) -> Option<Self> {
        let at = |name: &str| names.clone().position(|one| one.trim() == name);
        let (time, tick_ns) =
            at("TimeUS").map(|at| (at, 1000)).or_else(|| Some((at("TimeMS")?, 1_000_000)))?;
        let wanted =
            if record == MOTORS { &["ThO"][..] } else { &["GyrX", "GyrY", "GyrZ", "AccX", "AccY", "AccZ"] };
        let axes = wanted.iter().map(|name| at(name)).collect::<Option<_>>()?;
        Some(Self { time, tick_ns, instance: at("I"), axes, count: names.clone().count() })
    }

    /// A record by its fields' values.
    fn take(
        &self,
        name: &str,
        value: impl Fn(usize) -> Option<f64>,
        time: i64,
        records: &mut Records,
    ) -> Option<()> {
        let t = Stamp::from_ns(time.checked_mul(self.tick_ns)?);
        let axes = self.axes.iter().map(|at| value(*at)).collect::<Option<Vec<f64>>>()?;
        let [gx, gy, gz, ax, ay, az] = axes[..] else {
            records.motors(0, t, axes.into_iter());
            return Some(());
        };
        let number = name.strip_prefix("IMU")?.parse().unwrap_or(1u32).saturating_sub(1);
        let instance = match self.instance {
            Some(at) => value(at)? as u32,
            None => number,
        };
        // More instances than any autopilot has are left to themselves.
        if let Some(source) = records.source("IMU", instance, Holds::Both, 0) {
            records.push(source, ImuSample { t, gyro: [gx, gy, gz], accel: [ax, ay, az] });
        }
        Some(())
    }
}

fn is_imu(name: &str) -> bool {
    matches!(name, "IMU" | "IMU2" | "IMU3")
}

/// The record of what the motors are told.
const MOTORS: &str = "CTUN";

/// A type of binary record.
#[derive(Debug)]
struct Format {
    name: String,
    length: usize,
    /// Each field's type and where it begins.
    fields: Vec<(u8, usize)>,
    layout: Option<Layout>,
}

impl Format {
    fn new(fmt: &[u8]) -> Option<(u8, Self)> {
        let mut bytes = Bytes::new(fmt);
        let (number, length) = (bytes.u8()?, usize::from(bytes.u8()?));
        let mut text = |count: usize| {
            let text = bytes.take(count)?;
            let end = text.iter().position(|b| *b == 0).unwrap_or(count);
            std::str::from_utf8(&text[..end]).ok().map(str::to_owned)
        };
        let (name, types, names) = (text(4)?, text(16)?, text(64)?);
        let mut at = 0;
        let mut fields = Vec::new();
        for kind in types.bytes() {
            fields.push((kind, at));
            at += size(kind)?;
        }
        let is_read = is_imu(&name) || name == MOTORS;
        let layout = is_read.then(|| Layout::new(&name, &names.split(','))).flatten();
        Some((number, Self { name, length: length.checked_sub(3)?, fields, layout }))
    }
}

/// Bytes of a field's type.
fn size(kind: u8) -> Option<usize> {
    Some(match kind {
        b'b' | b'B' | b'M' => 1,
        b'h' | b'H' | b'c' | b'C' | b'g' => 2,
        b'i' | b'I' | b'f' | b'n' | b'e' | b'E' | b'L' => 4,
        b'q' | b'Q' | b'd' => 8,
        b'N' => 16,
        b'Z' | b'a' => 64,
        _ => return None,
    })
}

/// A field as a number; of hundredths their hundredth.
fn value(data: &[u8], (kind, at): (u8, usize)) -> Option<f64> {
    let mut bytes = Bytes::new(data.get(at..)?);
    Some(match kind {
        b'b' => f64::from(bytes.u8()?.cast_signed()),
        b'B' | b'M' => f64::from(bytes.u8()?),
        b'h' => f64::from(bytes.u16()?.cast_signed()),
        b'H' => f64::from(bytes.u16()?),
        b'c' => f64::from(bytes.u16()?.cast_signed()) / 100.0,
        b'C' => f64::from(bytes.u16()?) / 100.0,
        b'i' | b'L' => f64::from(bytes.u32()?.cast_signed()),
        b'I' => f64::from(bytes.u32()?),
        b'e' => f64::from(bytes.u32()?.cast_signed()) / 100.0,
        b'E' => f64::from(bytes.u32()?) / 100.0,
        b'f' => f64::from(f32::from_le_bytes(bytes.array()?)),
        b'd' => f64::from_le_bytes(bytes.array()?),
        b'q' => bytes.u64()?.cast_signed() as f64,
        b'Q' => bytes.u64()? as f64,
        _ => return None,
    })
}

/// Reads a whole binary log; returns what was wrong where it ended early.
///
/// # Errors
/// The operating system's; a damaged log is none.
pub(crate) fn read(source: impl Read, records: &mut Records) -> io::Result<Option<String>> {
    let mut source = CountedReader { inner: source, at: 0 };
    let mut formats: HashMap<u8, Format> = HashMap::new();
    loop {
        let begin = source.at;
        let head = source.up_to(3)?;
        let kind = match head[..] {
            [0xa3, 0x95, kind] => kind,
            [] => return Ok(None),
            // Pages that were never written.
            [0, ..] | [0xff, ..] if head.iter().all(|b| *b == head[0]) => return Ok(None),
            [_, _, _] => return Ok(Some(format!("no record at byte {begin}"))),
            _ => return Ok(Some(format!("cut off at byte {begin}"))),
        };
        let length = match formats.get(&kind) {
            _ if kind == FORMAT => 86,
            Some(format) => format.length,
            None => {
                return Ok(Some(format!(
                    "the record at byte {begin} is of type {kind}, which no FMT describes"
                )));
            }
        };
        let Some(data) = source.exactly(length as u64)? else {
            return Ok(Some(format!("cut off in the record at byte {begin}")));
        };
        if kind == FORMAT {
            match Format::new(&data) {
                Some((number, format)) => drop(formats.insert(number, format)),
                None => return Ok(Some(format!("the FMT at byte {begin} cannot be read"))),
            }
        } else if let Some(Format { name, fields, layout: Some(layout), .. }) = formats.get(&kind) {
            let value = |at: usize| value(&data, *fields.get(at)?);
            // Stamps below 2^53 us, which is 285 years, are whole in an f64.
            let took = value(layout.time).and_then(|time| layout.take(name, value, time as i64, records));
            if took.is_none() {
                return Ok(Some(format!("the record at byte {begin} does not fit its FMT")));
            }
        }
    }
}

/// Whether a text log begins like this.
pub(crate) fn is_text(head: &[u8]) -> bool {
    [&b"FMT, "[..], b"FMT,1", b"IMU, ", b"IMU2, "].iter().any(|start| head.starts_with(start))
}

/// Reads a text log; returns what was wrong where it ended early or with the first line that could not be read.
///
/// # Errors
/// The operating system's; a damaged log is none.
pub(crate) fn read_text(mut source: impl BufRead, records: &mut Records) -> io::Result<Option<String>> {
    let mut layouts: HashMap<String, Layout> = HashMap::new();
    let (mut line, mut number, mut damage) = (Vec::new(), 0u64, None);
    loop {
        line.clear();
        if source.by_ref().take(LONGEST_LINE).read_until(b'\n', &mut line)? == 0 {
            return Ok(damage);
        }
        number += 1;
        let Ok(text) = std::str::from_utf8(&line) else {
            damage.get_or_insert_with(|| format!("line {number} is no text"));
            continue;
        };
        let mut fields = text.split(',').map(str::trim);
        let name = fields.next().unwrap_or_default();
        if name == "FMT" {
            let names = fields.clone().skip(4);
            if let Some(read) = fields.nth(2).filter(|name| is_imu(name) || *name == MOTORS)
                && let Some(layout) = Layout::new(read, &names)
            {
                layouts.insert(read.to_owned(), layout);
            }
            continue;
        }
        if !is_imu(name) && !layouts.contains_key(name) {
            continue;
        }
        let values: Vec<&str> = fields.collect();
        if !layouts.contains_key(name) {
            let known = if values.len() >= 15 { FIELDS } else { OLD_FIELDS };
            let count = values.len();
            let layout = Layout::new(name, &known.split(',')).map(|layout| Layout { count, ..layout });
            layouts.extend(layout.map(|layout| (name.to_owned(), layout)));
        }
        let value = |at: usize| values.get(at)?.parse::<f64>().ok();
        let took = layouts.get(name).filter(|layout| values.len() >= layout.count).and_then(|layout| {
            let time = values.get(layout.time)?.parse().ok()?;
            layout.take(name, value, time, records)
        });
        if took.is_none() {
            damage.get_or_insert_with(|| format!("line {number} is cut off or no record"));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Kind, LogOptions};
    use dpn_core::Samples;
    use std::path::Path;

    #[test]
    fn lines_of_old_firmware_without_their_format_are_read_and_bad_ones_are_said() {
        let text = "IMU, 1000, 0.1, 0.2, 0.3, 1, 2, -9.8, 0, 0, 40, 1, 1\nIMU2, 1000, 5, 5, 5, 5, 5, 5, 0, 0, 40, 1, 1\n\
                    IMU, 3000, 0.1, 0.2, 0.3, 1, 2, -9.8, 0, 0, 40, 1, 1\nIMU, 5000, 0.1\n";
        let mut records = Records::default();
        let damage = read_text(text.as_bytes(), &mut records).unwrap();
        assert_eq!(damage.as_deref(), Some("line 4 is cut off or no record"));
        let log =
            records.log(Path::new("a.log"), Kind::ArdupilotText, damage, &LogOptions::default()).unwrap();
        assert_eq!(log.recording.at(1).unwrap().t.ns(), 3_000_000);
        assert_eq!(log.recording.at(1).unwrap().accel, [1.0, 2.0, -9.8]);
        assert_eq!(log.guesses, ["IMU of instance 0, of 2 (--topic IMU/1)"]);
        assert_eq!(log.motors, []);
    }

    #[test]
    fn what_the_motors_are_told_stands_beside_the_samples() {
        let mut text = "FMT, 46, 28, CTUN, Qff, TimeUS,ThI,ThO\n".to_owned();
        for ms in 0..200 {
            text += &format!("IMU, {}, 0.1, 0.2, 0.3, 1, 2, -9.8, 0, 0, 40, 1, 1\n", 1000 * ms);
            text += &format!("CTUN, {}, 0.1, {}\n", 1000 * ms, f64::from(ms) / 200.0);
        }
        let mut records = Records::default();
        assert_eq!(read_text(text.as_bytes(), &mut records).unwrap(), None);
        let log = records.log(Path::new("a.log"), Kind::ArdupilotText, None, &LogOptions::default()).unwrap();
        // Fifty a second are kept.
        assert_eq!((log.recording.len(), log.motors.len()), (200, 10));
        assert_eq!(log.motors[3], (Stamp::from_ns(60_000_000), 0.3));
    }
}
