//! Tables whose rows have one sensor each: the other's fields stand empty or hold NaN, as a table joined by stamps has them.

use super::fields::{Delimiter, comment, is_number, take_line};
use super::head;
use super::names::{self, Told};
use dpn_core::Sensor;
use std::path::Path;

/// Rows that are looked at.
const ROWS: usize = 1000;
/// Rows that either sensor must have among them.
const LEAST: usize = 10;
/// Share of the rows with one sensor from which on empty fields are meant.
const EMPTY: f64 = 0.25;
/// The same of NaN, which a failed read leaves too.
const NAN: f64 = 0.9;

/// Which columns of such a table are whose.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct OneEach {
    width: usize,
    /// Accelerometer's and gyroscope's.
    columns: [[usize; 3]; 2],
}

impl OneEach {
    /// Looks at the first lines of a table; none where most rows have both sensors.
    pub fn of(first_lines: &[u8]) -> Option<Self> {
        let path = Path::new("");
        let rows = head::open(first_lines, path, None).ok()?;
        let header = rows.header()?;
        let told = Told { counted: false, units: [true; 3] };
        let found = names::from_header(header, path, None, told).ok()?.columns;
        let table = Self { width: header.names.len(), columns: [found.accel, found.gyro] };
        let (mut of, mut one, mut both, mut nan) = ([0; 2], 0, 0, false);
        let (mut rest, mut fields) = (first_lines, Vec::new());
        while let Some(line) = take_line(&mut rest).filter(|_| one + both < ROWS) {
            let Some(has) = table.has(line, &mut fields) else { continue };
            of.iter_mut().zip(has).for_each(|(of, has)| *of += usize::from(has));
            match has {
                [true, true] => both += 1,
                [false, false] => {}
                _ => {
                    one += 1;
                    nan |= !fields.iter().any(|field| field.is_empty()) && fields.len() == table.width;
                }
            }
        }
        let least = if nan { NAN } else { EMPTY };
        let is_so = of.iter().all(|rows| *rows >= LEAST) && one as f64 > least * (one + both) as f64;
        is_so.then_some(table)
    }

    /// Whether accelerometer and gyroscope stand in a line; none of a comment.
    fn has<'a>(&self, line: &'a [u8], fields: &mut Vec<&'a [u8]>) -> Option<[bool; 2]> {
        if line.is_empty() || comment(line).is_some() {
            return None;
        }
        Delimiter::of(line).split(line, fields);
        let stands = |column: &usize| {
            fields.get(*column).is_some_and(|field| is_number(field) && !field.eq_ignore_ascii_case(b"nan"))
        };
        Some(self.columns.map(|columns| columns.iter().all(stands)))
    }

    /// The table without the rows that have the other sensor alone.
    pub fn rows_of(&self, text: &str, sensor: Sensor) -> String {
        let own = usize::from(sensor == Sensor::Gyro);
        let mut out = String::with_capacity(text.len());
        let mut fields = Vec::new();
        for line in text.lines() {
            let has = self.has(line.trim().as_bytes(), &mut fields).unwrap_or_default();
            if has[1 - own] && !has[own] {
                continue;
            }
            out.push_str(line.trim_end_matches('\r'));
            // An empty field at a row's end counts as none.
            if has[own] && fields.len() + 1 == self.width {
                out.push('0');
            }
            out.push('\n');
        }
        out
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_of_one_sensor_each_are_told_from_rows_that_lack_a_value_now_and_then() {
        let head = "t,gx,gy,gz,ax,ay,az\n";
        let apart = format!("{head}{}", "0,1,2,3,,,\n1,,,,4,5,6\n".repeat(20));
        let table = OneEach::of(apart.as_bytes()).unwrap();
        let gyro = table.rows_of(&apart, Sensor::Gyro);
        assert!(gyro.starts_with(&format!("{head}0,1,2,3,,,0\n0,1,2,3,,,0\n")), "{gyro}");
        assert_eq!(table.rows_of(&apart, Sensor::Accel).lines().nth(1), Some("1,,,,4,5,6"));
        // The slower sensor beside every second row of the quicker one.
        let joined = format!("{head}{}", "0,1,2,3,,,\n1,1,2,3,4,5,6\n".repeat(20));
        assert_eq!(
            OneEach::of(joined.as_bytes()).unwrap().rows_of(&joined, Sensor::Gyro).lines().count(),
            41
        );
        for (rows, is_so) in [
            ("0,1,2,3,nan,NaN,nan\n1,nan,nan,nan,4,5,6\n", true),
            ("0,1,2,3,nan,nan,nan\n1,1,2,3,4,5,6\n", false),
            ("0,1,2,3,4,5,6\n0,1,2,3,4,5,6\n0,1,2,3,4,5,6\n0,1,2,3,,,\n", false),
            ("0,1,2,3,,,\n", false),
        ] {
            assert_eq!(
                OneEach::of(format!("{head}{}", rows.repeat(30)).as_bytes()).is_some(),
                is_so,
                "{rows}"
            );
        }
    }
}
