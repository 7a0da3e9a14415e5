//! Readers and writers of the formats at the border.
//!
//! * [`asl`]: EuRoC and TUM-VI folders; [`asl::discover`] lists the sequences under a folder.
//! * [`read_imu_csv`]: plain CSV logs, columns by header or by list.
//! * [`read_tum`], [`write_tum`]: trajectories, as evo reads them.
//! * [`ImageFolder`]: a camera's images, also ahead of time on a second thread.
//! * [`read_tracks`], [`write_tracks`]: camera tracks.
//! * [`read_noise_track`], [`write_noise_track`]: noise tracks.
//! * [`check()`]: the health of what was read.
//! * [`atomic_write`]: files that are there in full or not at all.
//!
//! A reader checks every row and skips none: what it returns is finite, in SI units and in increasing time, and what is wrong is an
//! [`IoError`] with file, line and a [hint](IoError::hint). No reader panics, whatever the bytes.

pub mod asl;
mod atomic;
mod check;
mod columns;
mod decimal;
mod error;
mod fields;
#[cfg(test)]
mod fuzz;
mod images;
mod imu_csv;
mod noise_csv;
mod plateaus;
mod pose;
#[cfg(test)]
mod recordings;
mod rows;
mod tracks;
mod tum;

pub use atomic::atomic_write;
pub use check::{CheckOptions, Findings, Gap, RecordingFault, check};
pub use columns::{AccelUnit, GyroUnit, ImuColumns};
pub use decimal::TimeUnit;
pub use error::IoError;
pub use images::{Coverage, ImageFolder, ImageRun, Prefetch, StampedImage, read_png};
pub use imu_csv::{CsvOptions, ImuLog, Origin, Settled, parse_imu_csv, read_imu_csv};
pub use noise_csv::{read_noise_track, write_noise_track};
pub use tracks::{read_tracks, write_tracks};
pub use tum::{StampedPose, read_tum, write_tum};
