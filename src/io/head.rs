//! The header of somebody's IMU log: of its first lines the one that names the columns.
//!
//! Above it may stand what a program or a person wrote: a preamble with numbers in it, comments of any style. It may take two lines: names
//! above units (`t,gx,gy` over `s,deg/s,deg/s`), or sensors above axes (`,Gyro,,` over `t,x,y`). The line that names the most of the seven
//! columns is it, as long as the next row has as many fields.

use super::fields::{Delimiter, MOST_FIELDS, comment, is_number, take_line};
use super::names::slots;
use super::printable;
use super::rows::{Header, Rows};
use super::{IoError, guess};
use dpn_core::Sensor;
use dpn_core::signal::stats::median_of;
use std::path::Path;

/// Lines among which the header is looked for.
const LINES: usize = 2000;
/// Columns that a line must name to be a header: a stamp and one sensor.
const NAMES: usize = 4;

/// One of the first lines.
struct Line<'a> {
    /// From 1.
    number: usize,
    text: &'a [u8],
    /// What follows.
    rest: &'a [u8],
}

/// Reads up to the first row of data of an IMU log, or of one of its sensors.
///
/// # Errors
/// As [`Rows::open`].
pub(crate) fn open<'a>(bytes: &'a [u8], path: &'a Path, only: Option<Sensor>) -> Result<Rows<'a>, IoError> {
    let lines = first_lines(bytes);
    let mut best: Option<(usize, usize, Vec<String>)> = None;
    for (i, line) in lines.iter().enumerate() {
        let Some(names) = names(line.text) else { continue };
        let above = i.checked_sub(1).and_then(|above| grouped(&lines[above], &names));
        for names in [Some(names), above].into_iter().flatten() {
            let count = slots(&names, only).into_iter().filter(|found| *found).count();
            if count >= NAMES && best.as_ref().is_none_or(|(most, ..)| count > *most) {
                best = Some((count, i, names));
            }
        }
    }
    let Some((_, at, names)) = best else {
        return below_talk(&lines, path, only).unwrap_or_else(|| Rows::open(bytes, path));
    };
    let units = lines.get(at + 1).and_then(|below| with_units(below, &names));
    let (last, names) = match units {
        Some(names) => (at + 1, names),
        None => (at, names),
    };
    let is_row = |line: &&Line<'_>| comment(line.text).is_none() && !line.text.is_empty();
    match lines[last + 1..].iter().find(is_row) {
        Some(row) if fields(row.text).len() == names.len() => {
            let header = Header { line: lines[at].number, names };
            let Line { number, rest, .. } = lines[last];
            Ok(Rows::behind(rest, number, Delimiter::of(row.text), header, path))
        }
        // A row cut off, or no table: the plain way says what is wrong.
        _ => Rows::open(bytes, path),
    }
}

/// A table whose names mean nothing, or that has none, below lines that are none of it: what a board says when it starts. It begins where so many
/// rows have as many fields, the same of them numbers; the lines of as many fields above are its header. `None` where there is no such talk.
fn below_talk<'a>(
    lines: &[Line<'a>],
    path: &'a Path,
    only: Option<Sensor>,
) -> Option<Result<Rows<'a>, IoError>> {
    const ROWS: usize = 8;
    let least = if only.is_some() { 3 } else { 6 };
    let is_row = |line: &Line<'_>| comment(line.text).is_none();
    let shape = |line: &Line<'_>| fields(line.text).iter().map(|f| is_number(f)).collect::<Vec<_>>();
    let shapes: Vec<Option<Vec<bool>>> = lines.iter().map(|line| is_row(line).then(|| shape(line))).collect();
    let begins = |rows: &[Option<Vec<bool>>]| {
        let numbers = |shape: &Vec<bool>| shape.iter().filter(|is| **is).count();
        rows[0].as_ref().is_some_and(|first| numbers(first) >= least)
            && rows.iter().all(|row| *row == rows[0])
    };
    let first = shapes.windows(ROWS).position(begins)?;
    let width = shapes[first].as_ref()?.len();
    let is_header = |shape: &Option<Vec<bool>>| {
        shape.as_ref().is_some_and(|shape| shape.len() == width && !shape.contains(&true))
    };
    let header = first - shapes[..first].iter().rev().take_while(|shape| is_header(shape)).count();
    // Rows above that are alike are no talk: the table is damaged, and the plain way says where.
    if shapes[..header].contains(&shapes[first]) {
        return None;
    }
    let above = lines[..header].iter().rev().find(|line| is_row(line))?;
    if header == first {
        return Some(Rows::open(above.rest, path).map(|rows| rows.further(above.number)));
    }
    let names = self::names(lines[header].text)?;
    let names = lines[..first].get(header + 1).and_then(|below| with_units(below, &names)).unwrap_or(names);
    let named = Header { line: lines[header].number, names };
    let Line { number, rest, .. } = lines[first - 1];
    Some(Ok(Rows::behind(rest, number, Delimiter::of(lines[first].text), named, path)))
}

/// Whether a table of one sensor, by its first lines, has a column of stamps.
pub fn has_stamps(head: &[u8], sensor: Sensor) -> bool {
    let Ok(rows) = open(head, Path::new(""), Some(sensor)) else { return true };
    rows.header().map_or(rows.width() > 3, |header| slots(&header.names, Some(sensor))[0])
}

/// The only sensor of a table, by its first lines: the one that its header names, or whose three columns behind the stamp have gravity's length or not. None
/// where it has both, or no stamp; of bare axes under a header the accelerometer's alone are told.
pub fn only_sensor(head: &[u8], counted: bool) -> Option<Sensor> {
    let is_only = |sensor: Sensor| {
        let rows = open(head, Path::new(""), Some(sensor)).ok()?;
        let names = &rows.header()?.names;
        let [both, own] = [None, Some(sensor)].map(|only| slots(names, only));
        // Bare axes are nobody's: a word for the sensor must be there.
        let named = if sensor == Sensor::Gyro { &both[1..4] } else { &both[4..7] };
        let other = if sensor == Sensor::Gyro { &both[4..7] } else { &both[1..4] };
        let is_it = (own[0] || counted) && named.iter().all(|n| *n) && !other.iter().any(|n| *n);
        is_it.then_some(sensor)
    };
    if let Some(sensor) = Sensor::ALL.into_iter().find_map(is_only) {
        return Some(sensor);
    }
    // A stamp and bare axes are either's.
    let is_bare = |rows: &Rows<'_>| {
        rows.header().is_none_or(|header| {
            slots(&header.names, Some(Sensor::Gyro)) == [true; 7] && slots(&header.names[..1], None)[0]
        })
    };
    let mut rows = open(head, Path::new(""), Some(Sensor::Gyro))
        .ok()
        .filter(|rows| rows.width() == 4 && is_bare(rows))?;
    let mut lengths = Vec::new();
    while matches!(rows.advance(), Ok(true)) {
        let axes = rows.numbers([1, 2, 3], ["axis"; 3]);
        lengths.extend(axes.map(|v| v.into_iter().map(|v| v * v).sum::<f64>().sqrt()));
    }
    // What has a header and not gravity's length may be a path.
    match guess::is_gravity(median_of(lengths)?) {
        true => Some(Sensor::Accel),
        false => rows.header().is_none().then_some(Sensor::Gyro),
    }
}

/// Whether the names of a table mean a stamp and all axes of both sensors.
pub fn names_all(names: &[String]) -> bool {
    slots(names, None) == [true; 7]
}

/// A rate that one of the comments and the preamble names: `Update Rate: 100.0Hz`, `sample_rate_hz,200`.
pub(crate) fn said_rate(bytes: &[u8]) -> Option<f64> {
    first_lines(bytes).iter().find_map(|line| {
        let text = line.text.to_ascii_lowercase();
        let at = memchr::memmem::find(&text, b"rate")?;
        // Of the rows themselves none has the word.
        let behind = text.get(at..at + 40).unwrap_or(&text[at..]);
        let start = behind.iter().position(u8::is_ascii_digit)?;
        let is_part = |byte: &u8| byte.is_ascii_digit() || *byte == b'.';
        let end = behind[start..].iter().position(|b| !is_part(b)).map_or(behind.len(), |end| start + end);
        let number: f64 = std::str::from_utf8(&behind[start..end]).ok()?.parse().ok()?;
        let unit = behind[end..].trim_ascii_start();
        let hertz = unit.starts_with(b"hz") || memchr::memmem::find(&behind[..start], b"hz").is_some();
        (number > 0.0 && (hertz || memchr::memmem::find(&text[..at], b"sampl").is_some())).then_some(number)
    })
}

/// The first lines that are not empty.
fn first_lines(bytes: &[u8]) -> Vec<Line<'_>> {
    let mut rest = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    let mut lines = Vec::new();
    for number in 1..=LINES {
        let Some(text) = take_line(&mut rest) else { break };
        if !text.is_empty() {
            lines.push(Line { number, text, rest });
        }
    }
    lines
}

fn fields(text: &[u8]) -> Vec<&[u8]> {
    let mut fields = Vec::new();
    Delimiter::of(text).split(text, &mut fields);
    fields
}

/// The fields of a line that could be a header, a comment's too.
fn names(text: &[u8]) -> Option<Vec<String>> {
    let fields = fields(comment(text).unwrap_or(text));
    let numbers = fields.iter().filter(|f| is_number(f)).count();
    let fits = (NAMES..=MOST_FIELDS).contains(&fields.len()) && numbers == 0;
    fits.then(|| fields.into_iter().map(text_of).collect())
}

/// A field as text; a spreadsheet's Latin-1 has degree signs and squares.
fn text_of(field: &[u8]) -> String {
    match std::str::from_utf8(field) {
        Ok(text) => printable(text),
        Err(_) => printable(&field.iter().map(|byte| char::from(*byte)).collect::<String>()),
    }
}

/// Each name behind the group that stands above it or to the left of that.
fn grouped(above: &Line<'_>, names: &[String]) -> Option<Vec<String>> {
    let groups = self::names(above.text)?;
    if groups.len() > names.len() {
        return None;
    }
    let mut group = "";
    let with = |(i, name): (usize, &String)| {
        if let Some(next) = groups.get(i).filter(|next| !next.is_empty()) {
            group = next;
        }
        format!("{group} {name}").trim().to_owned()
    };
    Some(names.iter().enumerate().map(with).collect())
}

/// Each name with the unit that stands below it; `None` where the line below is none of units.
fn with_units(below: &Line<'_>, names: &[String]) -> Option<Vec<String>> {
    let units = self::names(below.text)?;
    let is_long = |unit: &String| unit.chars().count() > 12;
    if units.len() > names.len() || units.iter().any(is_long) || units.iter().all(String::is_empty) {
        return None;
    }
    let unit =
        |i: usize| units.get(i).map(|unit| unit.trim_matches(['[', ']', '(', ')', ' '])).unwrap_or_default();
    let with = |(i, name): (usize, &String)| match unit(i) {
        "" => name.clone(),
        unit => format!("{name} [{unit}]"),
    };
    Some(names.iter().enumerate().map(with).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn opened(text: &[u8]) -> (Vec<String>, f64) {
        let mut rows = open(text, Path::new("f.csv"), None).unwrap();
        let names = rows.header().unwrap().names.clone();
        assert!(rows.advance().unwrap());
        (names, rows.number(1, "v").unwrap())
    }

    #[test]
    fn the_header_is_found_under_preambles_and_comments_of_every_style() {
        let names = "t gx gy gz ax ay az".split(' ').collect::<Vec<_>>();
        for text in [
            &b"Logger,7\nSample rate,200\n\nt,gx,gy,gz,ax,ay,az\n0,2.5,3,4,5,6,7\n"[..],
            b"// Update Rate: 100.0Hz\n// x;y\nt;gx;gy;gz;ax;ay;az\n0;2,5;3;4;5;6;7;\n",
            b"! note\n; note\n# t,gx,gy,gz,ax,ay,az\n0,2.5,3,4,5,6,7\n",
            b"\xef\xbb\xbft\tgx\tgy\tgz\tax\tay\taz\r\n\r\n0\t2,5\t3\t4\t5\t6\t7\r\n",
            b"t,\tgx,\tgy,\tgz,\tax,\tay,\taz\n0,\t2.5,\t3,\t4,\t5,\t6,\t7\n",
        ] {
            let (found, value) = opened(text);
            assert_eq!(
                (&found[..], value),
                (&names.iter().map(|n| (*n).to_owned()).collect::<Vec<_>>()[..], 2.5)
            );
        }
    }

    #[test]
    fn a_second_line_of_units_or_of_sensors_is_part_of_the_header() {
        let (names, _) = opened(b"t,gx,gy,gz,ax,ay,az\ns,\xb0/s,\xb0/s,\xb0/s,g,g,g\n0,2,3,4,5,6,7\n");
        assert_eq!(
            (names[0].as_str(), names[1].as_str(), names[6].as_str()),
            ("t [s]", "gx [°/s]", "az [g]")
        );
        let (names, _) = opened(b",Accelerometer,,,Gyroscope,,\nTime,X,Y,Z,X,Y,Z\n0,2,3,4,5,6,7\n");
        assert_eq!(
            (names[0].as_str(), names[3].as_str(), names[4].as_str()),
            ("Time", "Accelerometer Z", "Gyroscope X")
        );
    }

    #[test]
    fn rows_below_what_a_board_says_when_it_starts_are_found_by_their_shape() {
        let talk = "Starting I2C ...\nsensor found, calibrating\n";
        let rows = |row: &dyn Fn(usize) -> String| (0..20).map(row).collect::<String>();
        let path = Path::new("f.txt");
        let text = format!("{talk}{}", rows(&|i| format!("{i},2.5,3,4,5,6,7\n")));
        let mut plain = open(text.as_bytes(), path, None).unwrap();
        assert!(plain.header().is_none() && plain.width() == 7 && plain.advance().unwrap());
        assert_eq!((plain.line(), plain.number(1, "v").unwrap()), (3, 2.5));
        // Labels between the numbers are fields of no use; names over units mean nothing to this reader, and places still do.
        let text = format!("{talk}{}", rows(&|i| format!("aX = {i} aY = 2 aZ = 3 gX = 4 gY = 5 gZ = 6\n")));
        let mut labels = open(text.as_bytes(), path, None).unwrap();
        assert!(labels.advance().unwrap());
        assert_eq!((labels.line(), labels.number(17, "v").unwrap()), (3, 6.0));
        let text = format!(
            "\"sep=\t\"\nA\tB\tC\tD\tE\tF\nms\tg\tg\tg\tV\tV\n{}",
            rows(&|i| format!("{i}\t2\t3\t4\t5\t6\n"))
        );
        let mut named = open(text.as_bytes(), path, None).unwrap();
        assert_eq!((named.header().unwrap().line, &named.header().unwrap().names[1][..]), (2, "B [g]"));
        assert!(named.advance().unwrap() && named.line() == 4);
    }
}
