//! Camera tracks as text, one line a frame: `stamp_ns n` and then n times `id u v`, between blanks; comments after `#`.
//!
//! Stamps are integer nanoseconds in the IMU's clock, ids whole numbers from 0, u and v distorted pixels with two decimals. A frame
//! in which nothing is seen is `stamp_ns 0`.

use super::decimal::{TimeUnit, parse_stamp};
use super::fields::{shown, take_line};
use super::row_fault::RowFault;
use super::{IoError, ResultPath, atomic_write};
use dpn_core::time::Stamp;
use dpn_core::tracks::{Track, TrackFrame};
use nalgebra::Vector2;
use std::io;
use std::path::Path;

/// Tracks that a frame may have: trackers follow hundreds, and a window of frames takes time with the square of them.
pub(crate) const MOST_TRACKS: u64 = 5000;

/// Reads the tracks of a recording, frames in increasing time, at least one.
///
/// # Errors
/// A file that cannot be read or holds no frame; a frame of more than 5000 tracks; a line whose count disagrees with what follows it; an id twice in one frame; what is
/// no number or not finite; stamps that do not increase.
pub fn read_tracks(path: &Path) -> Result<Vec<TrackFrame>, IoError> {
    let bytes = std::fs::read(path).map_err(|e| IoError::reading(path, e))?;
    parse(&bytes, path)
}

/// The same from bytes at hand; `path` is for messages.
pub(crate) fn parse(bytes: &[u8], path: &Path) -> Result<Vec<TrackFrame>, IoError> {
    let mut rest = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    let mut frames: Vec<TrackFrame> = Vec::new();
    let mut line = 0;
    let mut fields = Vec::new();
    let mut ids = Vec::new();
    while let Some(text) = take_line(&mut rest) {
        line += 1;
        if text.is_empty() || matches!(text[0], b'#' | b'%') {
            continue;
        }
        fields.clear();
        fields.extend(text.split(u8::is_ascii_whitespace).filter(|f| !f.is_empty()));
        let row = Row { path, line, fields: &fields };
        let t = row.stamp()?;
        if let Some(prev) = frames.last().map(|frame| frame.t).filter(|prev| *prev >= t) {
            return Err(row.fault(RowFault::TimeNotIncreasing { prev_ns: prev.ns(), t_ns: t.ns() }));
        }
        let tracks = row.tracks()?;
        if let Some(id) = repeated(&tracks, &mut ids) {
            return Err(row.fault(RowFault::TrackTwice { id }));
        }
        frames.push(TrackFrame::new(t, tracks));
    }
    if frames.is_empty() {
        return Err(IoError::Empty { path: path.to_path_buf() });
    }
    Ok(frames)
}

/// One line's fields; at least one.
struct Row<'a> {
    path: &'a Path,
    line: usize,
    fields: &'a [&'a [u8]],
}

impl Row<'_> {
    fn fault(&self, fault: RowFault) -> IoError {
        IoError::row(self.path, self.line, fault)
    }

    fn stamp(&self) -> Result<Stamp, IoError> {
        let (text, unit) = (self.fields[0], TimeUnit::Nanos);
        let bad = || self.fault(RowFault::BadStamp { text: shown(text), unit: unit.name() });
        parse_stamp(text, unit).ok_or_else(bad)
    }

    fn tracks(&self) -> Result<Vec<Track>, IoError> {
        let Some(count) = self.fields.get(1) else {
            return Err(self.fault(RowFault::FieldCount { found: self.fields.len(), expected: 2 }));
        };
        let said = self.whole(count, "n")?;
        if said > MOST_TRACKS && said.checked_mul(3) == Some(self.fields.len() as u64 - 2) {
            return Err(self.fault(RowFault::TooManyTracks { found: said, most: MOST_TRACKS }));
        }
        let values = &self.fields[2..];
        // Three fields a track; a cut line may end inside one.
        if said.checked_mul(3) != Some(values.len() as u64) {
            return Err(self.fault(RowFault::TrackCount { said, found: values.len() }));
        }
        values
            .chunks_exact(3)
            .map(|track| {
                let id = self.whole(track[0], "id")?;
                let px = Vector2::new(self.pixel(track[1], "u", id)?, self.pixel(track[2], "v", id)?);
                Ok(Track { id, px })
            })
            .collect()
    }

    fn whole(&self, field: &[u8], name: &str) -> Result<u64, IoError> {
        let digits = !field.is_empty() && field.iter().all(u8::is_ascii_digit);
        let value = digits.then(|| std::str::from_utf8(field).ok()?.parse().ok()).flatten();
        value.ok_or_else(|| self.fault(RowFault::NotWhole { column: name.to_owned(), text: shown(field) }))
    }

    fn pixel(&self, field: &[u8], name: &str, id: u64) -> Result<f64, IoError> {
        let parsed = fast_float2::parse::<f64, _>(field);
        if let Some(value) = parsed.as_ref().ok().filter(|value| value.is_finite()) {
            return Ok(*value);
        }
        let (column, text) = (format!("{name} of track {id}"), shown(field));
        Err(self.fault(match parsed {
            Ok(_) => RowFault::NotFinite { column, text },
            Err(_) => RowFault::BadNumber { column, text },
        }))
    }
}

/// The first id that stands in `tracks` twice; `sorted` is room to work in.
fn repeated(tracks: &[Track], sorted: &mut Vec<u64>) -> Option<u64> {
    if tracks.is_sorted_by(|a, b| a.id < b.id) {
        return None;
    }
    sorted.clear();
    sorted.extend(tracks.iter().map(|track| track.id));
    sorted.sort_unstable();
    sorted.windows(2).find(|pair| pair[0] == pair[1]).map(|pair| pair[0])
}

/// Writes tracks, all of them or nothing, pixels to two decimals: what was already rounded to .01 px comes back the same.
///
/// # Errors
/// As [`atomic_write`]; a pixel that is not finite, an id twice in a frame or stamps that do not increase are
/// [`io::ErrorKind::InvalidData`], since no reader would take them.
pub fn write_tracks(path: impl Into<ResultPath>, frames: &[TrackFrame]) -> Result<(), IoError> {
    let invalid = |what: &str, t: Stamp| {
        io::Error::new(io::ErrorKind::InvalidData, format!("{what} in the frame at {t}"))
    };
    atomic_write(path, |out| {
        let mut ids = Vec::new();
        let mut prev: Option<Stamp> = None;
        for frame in frames {
            if prev.replace(frame.t).is_some_and(|prev| prev >= frame.t) {
                return Err(invalid("a stamp that does not increase", frame.t));
            }
            if repeated(&frame.tracks, &mut ids).is_some() {
                return Err(invalid("an id twice", frame.t));
            }
            write!(out, "{} {}", frame.t.ns(), frame.tracks.len())?;
            for Track { id, px } in &frame.tracks {
                if !(px.x.is_finite() && px.y.is_finite()) {
                    return Err(invalid("a pixel that is not finite", frame.t));
                }
                write!(out, " {id} {:.2} {:.2}", px.x, px.y)?;
            }
            writeln!(out)?;
        }
        Ok(())
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const TWO: &str = "1403715273262142976 2 0 643.97 225.50 7 57.02 -192.6\n1403715273362142976 0\n";

    fn case(text: &str) -> Result<Vec<TrackFrame>, IoError> {
        parse(text.as_bytes(), Path::new("t.txt"))
    }

    #[test]
    fn frames_are_read_with_stamps_to_the_nanosecond() {
        for text in [TWO.to_owned(), format!("# by hand\r\n\r\n{}", TWO.replace('\n', " \r\n"))] {
            let frames = case(&text).unwrap();
            assert_eq!(frames.len(), 2);
            assert_eq!(frames[0].t.ns(), 1_403_715_273_262_142_976);
            assert_eq!(frames[0].tracks[1], Track { id: 7, px: Vector2::new(57.02, -192.6) });
            assert!(frames[1].tracks.is_empty());
        }
    }

    #[test]
    fn every_fault_is_named_with_its_line() {
        let error = |text: &str| case(text).unwrap_err().to_string();
        assert_eq!(error(""), "t.txt: no row of data");
        assert_eq!(error("10 0\n\n20\n"), "t.txt:3: 1 fields, expected 2");
        assert_eq!(
            error("10 2 0 1 2\n"),
            "t.txt:1: the frame says 2 tracks (6 fields: id u v), but 3 fields follow"
        );
        assert_eq!(
            error("10 1 0 1 2 5\n"),
            "t.txt:1: the frame says 1 tracks (3 fields: id u v), but 4 fields follow"
        );
        assert!(error("10 18446744073709551615 0 1 2\n").contains("says 18446744073709551615 tracks"));
        assert_eq!(error("10 0\n20 2 5 1 2 5 3 4\n"), "t.txt:2: track 5 is there twice in one frame");
        assert_eq!(error("10 0\n10 0\n"), "t.txt:2: time goes from 10 to 10 ns; stamps must increase");
        assert_eq!(error("10 1 4 nan 2\n"), "t.txt:1: u of track 4 is \"nan\"; every value must be finite");
        assert_eq!(
            error("10 1 4 1 1e999\n"),
            "t.txt:1: v of track 4 is \"1e999\"; every value must be finite"
        );
        assert_eq!(error("10 1 4 1 x\n"), "t.txt:1: v of track 4 is \"x\", not a number");
        assert_eq!(error("10 1 -4 1 2\n"), "t.txt:1: id is \"-4\", not a whole number from 0");
        assert_eq!(error("10 1.0 4 1 2\n"), "t.txt:1: n is \"1.0\", not a whole number from 0");
        assert!(error("1.5e400 0\n").starts_with("t.txt:1: stamp \"1.5e400\" is not a time in ns"));
    }

    #[test]
    fn a_frame_of_more_tracks_than_anybody_follows_is_refused() {
        let frame = |n: usize| {
            let tracks: String = (0..n).map(|id| format!(" {id} 1 2")).collect();
            case(&format!("10 0\n20 {n}{tracks}\n"))
        };
        assert_eq!(frame(5000).unwrap()[1].tracks.len(), 5000);
        let error = frame(20_000).unwrap_err();
        assert_eq!(error.to_string(), "t.txt:2: 20000 tracks in one frame; at most 5000 are read");
        assert!(error.hint().unwrap().contains("some hundred points"));
    }

    #[test]
    fn a_line_cut_anywhere_but_in_its_last_field_is_an_error_with_its_line() {
        let first = TWO.lines().next().unwrap();
        for cut in 1..=first.rfind(' ').unwrap() {
            let text = format!("5 0\n{}", &first[..cut]);
            // A cut inside the stamp may leave a smaller one, and a cut in a count of two digits a smaller count.
            let error = case(&text).unwrap_err();
            assert!(error.to_string().starts_with("t.txt:2: "), "{cut}: {error}");
        }
    }

    #[test]
    fn what_no_reader_takes_is_not_written() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("t.txt");
        let track = |id, u| Track { id, px: Vector2::new(u, 1.0) };
        let frame = |t, tracks| TrackFrame::new(Stamp::from_ns(t), tracks);
        for bad in [
            vec![frame(1, vec![track(1, f64::NAN)])],
            vec![frame(1, vec![track(1, 0.0), track(0, 0.0), track(1, 0.0)])],
            vec![frame(1, vec![]), frame(1, vec![])],
        ] {
            assert!(matches!(write_tracks(&path, &bad).unwrap_err(), IoError::Write { .. }));
            assert!(!path.exists());
        }
    }

    proptest! {
        #[test]
        fn hundredths_of_a_pixel_are_read_back_bit_by_bit(
            start in any::<i32>(),
            frames in prop::collection::vec(prop::collection::btree_map(any::<u64>(), (-99_999i32..999_999, any::<i16>()), 0..6), 1..5),
        ) {
            let frames: Vec<_> = frames.iter().enumerate().map(|(k, tracks)| TrackFrame {
                readout_s: 0.0,
                clock_s: 0.0,
                t: Stamp::from_ns(i64::from(start) + k as i64),
                // Not in the order of their ids.
                tracks: tracks.iter().rev().map(|(id, (u, v))| Track {
                    id: *id,
                    px: Vector2::new(f64::from(*u) / 100.0, f64::from(*v) / 100.0),
                }).collect(),
            }).collect();
            let dir = tempfile::tempdir().unwrap();
            let path = dir.path().join("t.txt");
            write_tracks(&path, &frames).unwrap();
            prop_assert_eq!(read_tracks(&path).unwrap(), frames);
        }
    }
}
