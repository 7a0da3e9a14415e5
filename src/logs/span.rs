//! The part of a log that is wanted.

use crate::{Log, LogError};
use dpn_core::{Recorded, Samples, Stamp};
use dpn_io::{IoError, StoredRecording};
use std::io;
use std::ops::Range;
use std::path::Path;
use std::str::FromStr;

/// Seconds from which on a number is a stamp's and not counted from the log's begin: 1973.
const STAMP_S: f64 = 1e8;
/// Digits of a whole number from which on it counts nanoseconds.
const NANOS_DIGITS: usize = 14;

/// An instant of a log.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum LogTime {
    /// Seconds after its first sample.
    Seconds(f64),
    /// A stamp.
    Stamp(Stamp),
}

/// Seconds after the first sample, seconds since 1970, or nanoseconds as the log has them.
impl FromStr for LogTime {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let text = text.trim_end_matches("ns");
        if text.len() >= NANOS_DIGITS && text.bytes().all(|c| c.is_ascii_digit()) {
            return text.parse().map(|ns| Self::Stamp(Stamp::from_ns(ns))).map_err(|_| too_long(text));
        }
        match text.parse::<f64>() {
            Ok(seconds) if (STAMP_S..9.2e9).contains(&seconds) => {
                let whole = Stamp::from_ns(seconds.trunc() as i64 * 1_000_000_000);
                Ok(Self::Stamp(whole.plus_seconds(seconds.fract())))
            }
            Ok(seconds) if (0.0..STAMP_S).contains(&seconds) => Ok(Self::Seconds(seconds)),
            _ => Err(too_long(text)),
        }
    }
}

fn too_long(text: &str) -> String {
    format!("`{text}` is neither seconds from the log's begin nor a stamp in seconds or nanoseconds")
}

/// The part of a log that is wanted; of stamps in parts ([`Log::others`]) that of each.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct LogSpan {
    /// Where it begins; without it at the first sample.
    pub from: Option<LogTime>,
    /// Where it ends; without it at the last.
    pub to: Option<LogTime>,
}

impl LogSpan {
    /// That part of `log`.
    ///
    /// # Errors
    /// Fewer than two samples within; a temporary file that cannot be read.
    pub(crate) fn of(self, log: Log, path: &Path) -> Result<Log, LogError> {
        if self == Self::default() {
            return Ok(log);
        }
        let reading = |e| IoError::reading(path, e);
        let [first, last] = log.recording.span();
        let recording = self.cut(log.recording, first).map_err(reading)?;
        let recording =
            recording.ok_or_else(|| LogError::NothingWithin { path: path.to_path_buf(), first, last })?;
        let mut others = Vec::new();
        for part in log.others {
            if let Some(recording) = self.cut(part.recording, first).map_err(reading)? {
                others.push(crate::OtherPart { recording, ..part });
            }
        }
        Ok(Log { recording, others, ..log })
    }

    fn cut(self, recording: StoredRecording, first: Stamp) -> io::Result<Option<StoredRecording>> {
        let at = |time: LogTime| match time {
            LogTime::Seconds(seconds) => first.plus_seconds(seconds),
            LogTime::Stamp(stamp) => stamp,
        };
        let (from, to) = (self.from.map(at), self.to.map(at));
        let mut within: Option<Range<usize>> = None;
        let mut index = 0;
        recording.each(0..recording.len(), &mut |s| {
            if from.is_none_or(|from| s.t >= from) && to.is_none_or(|to| s.t <= to) {
                within = Some(within.as_ref().map_or(index, |within| within.start)..index + 1);
            }
            index += 1;
        })?;
        let within = within.unwrap_or(0..0);
        if within.len() == recording.len() {
            return Ok(Some(recording));
        }
        let mut index = 0;
        let kept = recording.into_store().changed(|s| {
            index += 1;
            within.contains(&(index - 1)).then_some(s)
        })?;
        Ok(kept.recording()?.ok())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Kind;
    use dpn_core::{ImuRecording, ImuSample};

    #[test]
    fn seconds_and_stamps_cut_the_same_and_what_is_neither_is_refused() {
        let start = 1_403_636_579_758_555_392;
        let log = || {
            let at = |i: i64| ImuSample {
                t: Stamp::from_ns(start + i * 5_000_000),
                gyro: [0.0; 3],
                accel: [i as f64; 3],
            };
            Log::sound(Kind::Csv, ImuRecording::new((0..400).map(at).collect()).unwrap())
        };
        let cut = |from: &str, to: &str| {
            let span = LogSpan { from: Some(from.parse().unwrap()), to: Some(to.parse().unwrap()) };
            span.of(log(), Path::new("log.csv")).map(|log| log.recording.all().unwrap().into_owned())
        };
        let seconds = cut("0.5", "1").unwrap();
        assert_eq!((seconds.len(), seconds[0].accel[0]), (101, 100.0));
        assert_eq!(cut("1403636580258555392", "1403636580758555392").unwrap(), seconds);
        assert_eq!(cut("1403636580.258", "1403636580.759").unwrap(), seconds);
        let error = cut("5", "6").unwrap_err().to_string();
        assert!(error.starts_with("log.csv: fewer than two samples between --from and --to; the log is from 1403636579758555392 ns"), "{error}");
        for bad in ["", "-1", "nan", "1e12", "99999999999999999999", "soon"] {
            assert!(bad.parse::<LogTime>().is_err(), "{bad}");
        }
    }
}
