//! Readers and writers of the formats at the border.
//!
//! * [`asl`]: EuRoC and TUM-VI folders; [`asl::discover`] lists the sequences under a folder.
//! * [`read_imu_csv`]: plain CSV logs, columns by header or by list.
//!
//! A reader checks every row and skips none: what it returns is finite, in SI units and in increasing time, and what is wrong is an
//! [`IoError`] with file, line and a [hint](IoError::hint). No reader panics, whatever the bytes.

pub mod asl;
mod columns;
mod decimal;
mod error;
mod imu_csv;
mod pose;
mod rows;

pub use columns::{AccelUnit, GyroUnit, ImuColumns};
pub use decimal::TimeUnit;
pub use error::IoError;
pub use imu_csv::{CsvOptions, ImuLog, Origin, Settled, parse_imu_csv, read_imu_csv};
