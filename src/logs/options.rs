//! What the caller knows about a log.

use crate::{LogError, LogSpan, Scales};
use dpn_core::{ImuSample, SampleRate};
use dpn_io::{AccelUnit, CsvOptions, GyroUnit, SampleStore, counted_stamp};
use std::io;
use std::path::Path;

/// What the caller knows about a log.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct LogOptions {
    /// Columns of a CSV file; units and the rate of stamps that are counted, of any kind of log.
    pub csv: CsvOptions,
    /// The bag's topic; without it, its only IMU.
    pub topic: Option<String>,
    /// Bytes that a bag's chunks or a packed file may unpack to, all together; without it, 32 MB and 32 times the packed ones.
    pub max_uncompressed: Option<u64>,
    /// The part that is wanted.
    pub span: LogSpan,
    /// What one of the log's numbers is, of any kind of log; it stands instead of a unit.
    pub scales: Scales,
}

impl LogOptions {
    /// What one number of a log in SI units is: as said, or by the unit that was named.
    pub(crate) fn si_scales(&self) -> Scales {
        Scales {
            accel: self.scales.accel.or(self.csv.accel.map(AccelUnit::factor)),
            gyro: self.scales.gyro.or(self.csv.gyro.map(GyroUnit::factor)),
        }
    }

    /// The samples of a log in SI units as the caller knows them: scaled, their stamps counted.
    ///
    /// # Errors
    /// A temporary file that cannot be read or written.
    pub(crate) fn settled(&self, samples: SampleStore) -> io::Result<SampleStore> {
        recounted(self.si_scales().apply(samples)?, self.csv.rate)
    }

    /// Whether stamps are to be counted, where a log has two tables with stamps of their own.
    ///
    /// # Errors
    /// They are.
    pub(crate) fn without_rate(&self, path: &Path) -> Result<(), LogError> {
        match self.csv.rate {
            Some(_) => Err(LogError::NotHere {
                path: path.to_path_buf(),
                flag: "--rate",
                of: "logs with a row a sample",
                kind: "two tables with stamps of their own",
            }),
            None => Ok(()),
        }
    }

    /// Whether what was asked for is of tables, where `kind` is none.
    ///
    /// # Errors
    /// It is.
    pub(crate) fn without_columns(&self, path: &Path, kind: &'static str) -> Result<(), LogError> {
        let of_tables = [("--columns", self.csv.columns.is_some()), ("--time-unit", self.csv.time.is_some())];
        match of_tables.into_iter().find(|(_, given)| *given) {
            Some((flag, _)) => Err(LogError::NotHere { path: path.to_path_buf(), flag, of: "tables", kind }),
            None => Ok(()),
        }
    }
}

/// The same samples with stamps that are counted at `rate`, where there is one.
///
/// # Errors
/// A temporary file that cannot be read or written.
fn recounted(samples: SampleStore, rate: Option<SampleRate>) -> io::Result<SampleStore> {
    let Some(rate) = rate else { return Ok(samples) };
    let mut index = 0..;
    samples.changed(|s| Some(ImuSample { t: counted_stamp(index.next()?, rate), ..s }))
}
