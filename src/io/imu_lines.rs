//! IMU samples from lines of text as they come, for what runs beside a sensor.

use super::IoError;
use super::fields::comment;
use super::head;
use super::rows::{Layout, Rows};
use super::understood::{CsvOptions, Understood};
use dpn_core::imu::ImuSample;
use std::path::{Path, PathBuf};

/// Lines that may stand before the first row.
const HEAD: usize = 1 << 20;

/// Reads lines one by one. Columns and units are settled by the header and the first two rows: the first row waits for the second.
#[derive(Debug)]
pub struct ImuLines {
    options: CsvOptions,
    path: PathBuf,
    /// All lines until the layout is known.
    head: Vec<u8>,
    known: Option<(Understood, Layout)>,
}

impl ImuLines {
    /// A reader; `path` is for messages. Units of the sensors that neither `options` nor the header name are SI.
    pub fn new(path: &Path, options: CsvOptions) -> Self {
        Self { options, path: path.to_path_buf(), head: Vec::new(), known: None }
    }

    /// Takes the next line, with or without its end. Returns the samples it completes: none, one, or at the second row two.
    ///
    /// # Errors
    /// A header without the columns; a row that cannot be read: the next line is read as if it had not been.
    pub fn push(&mut self, line: &[u8]) -> Result<Vec<ImuSample>, IoError> {
        if let Some((understood, layout)) = &mut self.known {
            let mut rows = Rows::go_on(line, &self.path, *layout);
            let samples = samples(&mut rows, understood);
            *layout = rows.layout();
            return samples;
        }
        self.head.extend_from_slice(line);
        if !line.ends_with(b"\n") {
            self.head.push(b'\n');
        }
        // A comment settles nothing: a head of nothing else would be read again with each of its lines.
        if (line.trim_ascii().is_empty() || comment(line.trim_ascii()).is_some()) && self.head.len() <= HEAD {
            return Ok(Vec::new());
        }
        let result = self.settle();
        if result.is_err() || self.head.len() > HEAD {
            self.head.clear();
        }
        result
    }

    /// Tries to understand what has come so far.
    fn settle(&mut self) -> Result<Vec<ImuSample>, IoError> {
        let mut rows = match head::open(&self.head, &self.path, None) {
            Ok(rows) => rows,
            // Header and comments only, so far.
            Err(IoError::Empty { .. }) => return Ok(Vec::new()),
            Err(error) => return Err(error),
        };
        let understood = match Understood::of(&rows, &self.path, &self.options, None, None, true) {
            Ok(understood) => understood,
            // One row does not tell a step.
            Err(IoError::TooShort { .. }) => return Ok(Vec::new()),
            Err(error) => return Err(error),
        };
        let found = samples(&mut rows, &understood);
        let layout = rows.layout();
        self.known = Some((understood, layout));
        found
    }
}

fn samples(rows: &mut Rows<'_>, understood: &Understood) -> Result<Vec<ImuSample>, IoError> {
    let mut found = Vec::new();
    while let Some(sample) = understood.next(rows)? {
        found.push(understood.in_si(sample));
    }
    Ok(found)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_give_the_samples_of_the_whole_text_and_a_bad_one_is_passed_over() {
        let mut lines = ImuLines::new(Path::new("stdin"), CsvOptions::default());
        let mut push = |line: &str| lines.push(line.as_bytes());
        assert_eq!(push("t,gx [deg/s],gy,gz,ax [g],ay,az\n").unwrap(), []);
        assert_eq!(push("0.000,180,0,0,0,0,1\n").unwrap(), []);
        let two = push("0.005,0,0,0,0,0,1\n").unwrap();
        assert_eq!(two.len(), 2);
        assert!((two[0].gyro[0] - std::f64::consts::PI).abs() < 1e-12 && two[1].t.ns() == 5_000_000);
        let error = push("0.010,0,0\n").unwrap_err().to_string();
        assert_eq!(error, "stdin:4: 3 fields, expected 7");
        assert_eq!(push("\n").unwrap(), []);
        assert_eq!(push("0.015,0,0,0,0,0,1").unwrap()[0].t.ns(), 15_000_000);
    }

    #[test]
    fn stamps_since_1970_need_no_second_row_and_a_bad_header_is_named() {
        let mut lines = ImuLines::new(
            Path::new("stdin"),
            CsvOptions { time: Some(crate::TimeUnit::Nanos), ..CsvOptions::default() },
        );
        assert_eq!(lines.push(b"5,0,0,0,0,0,1").unwrap().len(), 1);
        let mut lines = ImuLines::new(Path::new("stdin"), CsvOptions::default());
        lines.push(b"t,gx,gy,gz,ax,ay\n").unwrap();
        let error = lines.push(b"1,2,3,4,5,6\n").unwrap_err().to_string();
        assert!(error.contains("no column `accel_z`"), "{error}");
    }
}
