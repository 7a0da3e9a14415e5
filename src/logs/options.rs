//! What the caller knows about a log.

use crate::Scales;
use dpn_io::CsvOptions;

/// What the caller knows about a log.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct LogOptions {
    /// Columns and units of a CSV file.
    pub csv: CsvOptions,
    /// The bag's topic; without it, its only IMU.
    pub topic: Option<String>,
    /// Bytes that a bag's chunks or a packed file may unpack to, all together; without it, 32 MB and 32 times the packed ones.
    pub max_uncompressed: Option<u64>,
    /// What one of the log's numbers is, of any kind of log; it stands instead of a unit.
    pub scales: Scales,
}
