//! A small fast tokenizer for tables of numbers in text: one pass over bytes, no allocation a row.
//!
//! What it takes: fields between commas, semicolons, tabs or blanks (told from the first line that has fields); LF and CRLF;
//! blank lines anywhere; comment lines that start with `#`, `%`, `!`, `//` or `; `; a header, commented or not; a byte order mark; fields in
//! double quotes, with decimal commas in them. Every row has as many fields as the header or the first row; one empty
//! field after a delimiter at the end of a row is dropped.

use super::IoError;
use super::date;
use super::decimal::{TimeUnit, parse_stamp};
use super::fields::{self, Delimiter, MOST_FIELDS, comment, is_number, names_time, shown, take_line};
use super::printable;
use super::row_fault::RowFault;
use dpn_core::time::Stamp;
use std::path::Path;

/// The names over the columns.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Header {
    /// Where it stands, from 1.
    pub line: usize,
    /// As written, without blanks around them and without the comment sign.
    pub names: Vec<String>,
}

/// What of a table its later blocks need.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Layout {
    line: usize,
    count: usize,
    delimiter: Delimiter,
    width: usize,
}

impl Layout {
    /// Line of the last row read, from 1.
    pub(crate) fn line(&self) -> usize {
        self.line
    }
}

/// A cursor over the rows of a table.
#[derive(Clone)]
pub(crate) struct Rows<'a> {
    path: &'a Path,
    rest: &'a [u8],
    /// Line of the current row, from 1.
    line: usize,
    /// Rows that were gone to.
    count: usize,
    delimiter: Delimiter,
    /// Fields every row has.
    width: usize,
    fields: Vec<&'a [u8]>,
    /// Where no header was, the fields of the first row, for those who know layouts.
    first: Vec<&'a [u8]>,
    header: Option<Header>,
}

impl<'a> Rows<'a> {
    /// Reads up to the first row of data.
    ///
    /// # Errors
    /// No row of data at all; a header that is not UTF-8; thousands of columns.
    pub(crate) fn open(bytes: &'a [u8], path: &'a Path) -> Result<Self, IoError> {
        let mut rest = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
        let mut header: Option<(usize, Delimiter, &[u8])> = None;
        let mut plain_header = false;
        let mut line = 0;
        let mut fields = Vec::new();
        loop {
            let before = rest;
            let Some(text) = take_line(&mut rest) else {
                return Err(IoError::Empty { path: path.to_path_buf() });
            };
            line += 1;
            if text.is_empty() {
                continue;
            }
            if let Some(comment) = comment(text) {
                // The last comment with a time among its fields names the columns, unless a plain header did.
                let delimiter = Delimiter::of(comment);
                delimiter.split(comment, &mut fields);
                if !plain_header && fields.len() > 1 && names_time(fields[0]) {
                    header = Some((line, delimiter, comment));
                }
                continue;
            }
            let delimiter = Delimiter::of(text);
            delimiter.split(text, &mut fields);
            let numeric = fields.first().is_some_and(|f| is_number(f));
            if !numeric && !plain_header && fields.len() > 1 && !fields.iter().any(|f| is_number(f)) {
                header = Some((line, delimiter, text));
                plain_header = true;
                continue;
            }
            // Here data begins. Without a header, the first row's width is everybody's.
            let header = match header {
                Some((line, delimiter, text)) => {
                    delimiter.split(text, &mut fields);
                    let names = fields
                        .iter()
                        .map(|name| std::str::from_utf8(name).map(printable))
                        .collect::<Result<Vec<_>, _>>()
                        .map_err(|_| IoError::row(path, line, RowFault::NotUtf8))?;
                    Some(Header { line, names })
                }
                None => None,
            };
            let width = header.as_ref().map_or(fields.len(), |h| h.names.len());
            if width > MOST_FIELDS {
                let expected = "at most 4096";
                return Err(IoError::row(path, line, RowFault::UnknownLayout { found: width, expected }));
            }
            let first = if header.is_none() { fields.clone() } else { Vec::new() };
            let line = line - 1;
            return Ok(Self { path, rest: before, line, count: 0, delimiter, width, fields, first, header });
        }
    }

    /// The same where so many lines stand above what was opened.
    pub(crate) fn further(mut self, above: usize) -> Self {
        self.line += above;
        self
    }

    /// Takes columns by their places, whatever a header above them names.
    pub(crate) fn by_place(mut self) -> Self {
        self.header = None;
        let mut rest = self.rest;
        if let Some(text) = take_line(&mut rest) {
            self.delimiter.split(text, &mut self.fields);
            self.width = self.fields.len();
        }
        self
    }

    /// Begins behind a header that was found, at line `line` from 1.
    pub(crate) fn behind(
        rest: &'a [u8],
        line: usize,
        delimiter: Delimiter,
        header: Header,
        path: &'a Path,
    ) -> Self {
        let width = header.names.len();
        Self {
            path,
            rest,
            line,
            count: 0,
            delimiter,
            width,
            fields: Vec::new(),
            first: Vec::new(),
            header: Some(header),
        }
    }

    /// Goes on with the block of bytes behind another of the same table.
    pub(crate) fn go_on(bytes: &'a [u8], path: &'a Path, layout: Layout) -> Self {
        let Layout { line, count, delimiter, width } = layout;
        Self {
            path,
            rest: bytes,
            line,
            count,
            delimiter,
            width,
            fields: Vec::new(),
            first: Vec::new(),
            header: None,
        }
    }

    /// What the next block of this table needs, at this block's end.
    pub(crate) fn layout(&self) -> Layout {
        Layout { line: self.line, count: self.count, delimiter: self.delimiter, width: self.width }
    }

    /// The names over the columns, where the file has them.
    pub(crate) fn header(&self) -> Option<&Header> {
        self.header.as_ref()
    }

    /// Fields a row has.
    pub(crate) fn width(&self) -> usize {
        self.width
    }

    /// Line of the current row, from 1; before the first row, the line above it.
    pub(crate) fn line(&self) -> usize {
        self.line
    }

    /// The current row's number, from 0; one that cannot be read counts.
    pub(crate) fn number_of_row(&self) -> usize {
        self.count.saturating_sub(1)
    }

    /// A guess at the rows left, good enough to reserve room.
    pub(crate) fn rows_left(&self) -> usize {
        let first = memchr::memchr(b'\n', self.rest).unwrap_or(self.rest.len()) + 1;
        // A row has at least a character and a delimiter a field, so that a cut first row reserves no absurd amount.
        self.rest.len() / first.max(2 * self.width) + 1
    }

    /// Goes to the next row; `false` at the end.
    ///
    /// # Errors
    /// A row with another number of fields.
    pub(crate) fn advance(&mut self) -> Result<bool, IoError> {
        while let Some(text) = take_line(&mut self.rest) {
            self.line += 1;
            if text.is_empty() || comment(text).is_some() {
                continue;
            }
            self.count += 1;
            self.delimiter.split(text, &mut self.fields);
            if self.fields.len() != self.width {
                self.delimiter.split_quoted(text, &mut self.fields);
            }
            // A row's last field may be empty, a table's last column too.
            let ends = matches!(self.delimiter, Delimiter::Byte(byte) if text.ends_with(&[byte]));
            if ends && self.fields.len() + 1 == self.width {
                self.fields.push(b"");
            }
            if self.fields.len() != self.width {
                return Err(self.field_count(self.width));
            }
            return Ok(true);
        }
        Ok(false)
    }

    /// The current row's field `column` as a finite number; `name` is for the message.
    ///
    /// # Errors
    /// No number; NaN or an infinity; a column past the end.
    pub(crate) fn number(&self, column: usize, name: &str) -> Result<f64, IoError> {
        let field = self.field(column)?;
        match fields::number(field) {
            Some(value) if value.is_finite() => Ok(value),
            Some(_) => Err(self.not_finite(name, &shown(field))),
            None if std::str::from_utf8(field).is_err() => Err(self.fault(RowFault::NotUtf8)),
            None => Err(self.fault(RowFault::BadNumber { column: name.to_owned(), text: shown(field) })),
        }
    }

    /// The current row's fields from `first` on as numbers.
    ///
    /// # Errors
    /// As [`Rows::number`].
    pub(crate) fn numbers<const N: usize>(
        &self,
        columns: [usize; N],
        names: [&str; N],
    ) -> Result<[f64; N], IoError> {
        let mut values = [0.0; N];
        for ((value, column), name) in values.iter_mut().zip(columns).zip(names) {
            *value = self.number(column, name)?;
        }
        Ok(values)
    }

    /// The current row's field `column` as a stamp.
    ///
    /// # Errors
    /// No decimal number and no date, or a time out of range.
    pub(crate) fn stamp(&self, column: usize, unit: TimeUnit) -> Result<Stamp, IoError> {
        let field = self.field(column)?;
        let comma = || parse_stamp(&fields::with_point(field)?, unit);
        parse_stamp(field, unit).or_else(comma).or_else(|| date::parse(field)).ok_or_else(|| {
            self.fault(match std::str::from_utf8(field) {
                Err(_) => RowFault::NotUtf8,
                Ok(_) => RowFault::BadStamp { text: shown(field), unit: unit.name() },
            })
        })
    }

    /// The current row's field `column`, where it is a date or a time of day.
    pub(crate) fn date(&self, column: usize) -> Option<Stamp> {
        date::parse(self.fields.get(column)?)
    }

    /// The same, later than `prev`.
    ///
    /// # Errors
    /// As [`Rows::stamp`]; a stamp that does not come after `prev`.
    pub(crate) fn stamp_after(
        &self,
        prev: Option<Stamp>,
        column: usize,
        unit: TimeUnit,
    ) -> Result<Stamp, IoError> {
        let t = self.stamp(column, unit)?;
        self.must_follow(prev, t)?;
        Ok(t)
    }

    /// Holds the current row's stamp `t` against the one before.
    ///
    /// # Errors
    /// A stamp that does not come after `prev`.
    pub(crate) fn must_follow(&self, prev: Option<Stamp>, t: Stamp) -> Result<(), IoError> {
        match prev {
            Some(prev) if prev >= t => {
                Err(self.fault(RowFault::TimeNotIncreasing { prev_ns: prev.ns(), t_ns: t.ns() }))
            }
            _ => Ok(()),
        }
    }

    /// Whether the first row reads as ROS 2 prints an IMU's message: seconds, nanoseconds, frame, then numbers, forty fields in all.
    pub(crate) fn first_is_ros2_echo(&self) -> bool {
        let whole = |field: &[u8]| !field.is_empty() && field.iter().all(u8::is_ascii_digit);
        match &self.first[..] {
            [seconds, nanos, frame, numbers @ ..] if numbers.len() == 37 => {
                whole(seconds) && whole(nanos) && !is_number(frame) && numbers.iter().all(|f| is_number(f))
            }
            _ => false,
        }
    }

    /// The current row's field `column` as text.
    ///
    /// # Errors
    /// Not UTF-8.
    pub(crate) fn text(&self, column: usize) -> Result<&'a str, IoError> {
        std::str::from_utf8(self.field(column)?).map_err(|_| self.fault(RowFault::NotUtf8))
    }

    fn field(&self, column: usize) -> Result<&'a [u8], IoError> {
        self.fields.get(column).copied().ok_or_else(|| self.field_count(column + 1))
    }

    /// The error for a value of the current row that is NaN or infinite.
    pub(crate) fn not_finite(&self, name: &str, text: &str) -> IoError {
        self.fault(RowFault::NotFinite { column: name.to_owned(), text: text.to_owned() })
    }

    /// The error for rows, of which this stands before the first, of a width that is none of `expected`.
    pub(crate) fn unknown_layout(&self, expected: &'static str) -> IoError {
        self.below(RowFault::UnknownLayout { found: self.width, expected })
    }

    /// The error for the row below this.
    pub(crate) fn below(&self, fault: RowFault) -> IoError {
        IoError::row(self.path, self.line + 1, fault)
    }

    fn field_count(&self, expected: usize) -> IoError {
        self.fault(RowFault::FieldCount { found: self.fields.len(), expected })
    }

    /// The error for the current row.
    pub(crate) fn fault(&self, fault: RowFault) -> IoError {
        IoError::row(self.path, self.line, fault)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn all(text: &[u8]) -> Result<Vec<Vec<f64>>, IoError> {
        let mut rows = Rows::open(text, Path::new("f.csv"))?;
        let mut out = Vec::new();
        while rows.advance()? {
            out.push((0..rows.width()).map(|c| rows.number(c, "v")).collect::<Result<_, _>>()?);
        }
        Ok(out)
    }

    #[test]
    fn line_ends_blanks_quotes_and_comments_do_not_change_the_numbers() {
        let plain = all(b"time,x\n1,2.5\n3,-4e-3\n").unwrap();
        assert_eq!(plain, vec![vec![1.0, 2.5], vec![3.0, -4e-3]]);
        for same in [
            &b"#time [ns],x\r\n1,2.5\r\n3,-4e-3\r\n\r\n"[..],
            b"\xef\xbb\xbf# made by hand, yesterday\n\n\"time\", \"x\"\n 1 , 2.5 ,\n# a note, here\n\"3\",-4e-3",
            b"1;2.5\n3;-4e-3",
            b"1\t2.5\n3\t-4e-3\t\n",
            b"# t x\n1   2.5\n 3 -4e-3 \n",
        ] {
            assert_eq!(all(same).unwrap(), plain, "{}", String::from_utf8_lossy(same));
        }
    }

    #[test]
    fn errors_carry_the_line_an_editor_shows() {
        let case = |text: &[u8]| all(text).unwrap_err().to_string();
        assert_eq!(case(b"#time,x\n1,2\n\n2,oops\n"), "f.csv:4: v is \"oops\", not a number");
        assert_eq!(case(b"time,x\n1,2\n2\n"), "f.csv:3: 1 fields, expected 2");
        assert_eq!(case(b"1,2\n2,3,4\n"), "f.csv:2: 3 fields, expected 2");
        assert_eq!(case(b"1,2\n2,NaN\n"), "f.csv:2: v is \"NaN\"; every value must be finite");
        assert_eq!(case(b"1,2\n2,1e999\n"), "f.csv:2: v is \"1e999\"; every value must be finite");
        assert_eq!(case(b"1,2\n2,\xff\xfe\n"), "f.csv:2: not UTF-8 text");
        assert_eq!(case(b"1,2\n2,\n"), "f.csv:2: v is \"\", not a number");
        assert_eq!(case(b"1,2\n,2\n"), "f.csv:2: v is \"\", not a number");
        assert_eq!(case(b"#time,x\n"), "f.csv: no row of data");
        assert_eq!(case(b""), "f.csv: no row of data");
    }

    #[test]
    fn a_line_of_millions_of_fields_is_no_row_and_takes_no_room() {
        let case = |text: String| all(text.as_bytes()).unwrap_err().to_string();
        assert_eq!(case("1,".repeat(1_000_000)), "f.csv:1: 4097 columns; at most 4096 are known");
        assert_eq!(case("1 ".repeat(1_000_000)), "f.csv:1: 4097 columns; at most 4096 are known");
        assert_eq!(case(format!("1,2\n{}", "1,".repeat(1_000_000))), "f.csv:2: 4097 fields, expected 2");
        assert_eq!(
            case(format!("t,{}\n1,2\n", "a\u{1b}[2J,".repeat(5000))),
            "f.csv:2: 4097 columns; at most 4096 are known"
        );
    }

    #[test]
    fn a_long_field_is_shortened_and_made_printable() {
        let text = format!("1,2\n2,\u{7}{}\n", "y".repeat(500));
        let error = all(text.as_bytes()).unwrap_err().to_string();
        assert!(error.len() < 100 && error.contains("\\u{7}yyy"), "{error}");
    }
}
