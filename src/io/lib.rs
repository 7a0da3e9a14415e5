//! Readers and writers of the formats at the border.
//!
//! * [`asl`]: EuRoC and TUM-VI folders; [`asl::discover`] lists the sequences under a folder.
//! * [`read_imu_csv`]: plain CSV logs, columns by header or by list; [`parse_imu_csv_loosely`] uses what it can of anybody's.
//! * [`ImuLines`]: the same line by line, as they come.
//! * [`Sieve`]: keeps of somebody's samples what a recording may hold.
//! * [`SampleStore`], [`StoredRecording`]: samples of a log of any length, partly in a temporary file ([`Store`]).
//! * [`printable`]: names out of other people's files, as they may be shown.
//! * [`read_tum`], [`write_tum`]: trajectories, as evo reads them; [`read_poses`]: these, or ASL's ground truth.
//! * [`ImageFolder`]: a camera's images, also ahead of time on a second thread.
//! * [`parse_image`], [`PixelLayout`]: PNG, JPEG and cameras' raw pixels made grey. [`TimesFolder`]: images as TUM-mono has them.
//! * [`read_tracks`], [`write_tracks`]: camera tracks.
//! * [`read_noise_track`], [`write_noise_track`]: noise tracks.
//! * [`config`]: typed configurations of TOML.
//! * [`noise_formats`]: noise parameters as other programs write them.
//! * [`atomic_write`], [`write_file`], [`write_json`]: files that are there in full or not at all. [`ResultPath`]: where they lie, no links below what somebody named. [`FolderLock`]: a folder for one writer at a time.
//!
//! A reader checks every row, and all but the loose one skip none: what it returns is finite, in SI units and in increasing time, and what is wrong is an
//! [`IoError`] with file, line and a [hint](IoError::hint). No reader panics, whatever the bytes.

#![cfg_attr(test, allow(clippy::unwrap_used))]

pub mod asl;
mod atomic;
mod beneath;
pub mod calibration;
mod choice;
mod columns;
pub mod config;
mod date;
mod decimal;
mod error;
mod fields;
#[cfg(test)]
mod fuzz;
#[cfg(feature = "images")]
mod grey;
mod guess;
mod head;
#[cfg(feature = "images")]
mod image_file;
#[cfg(feature = "images")]
mod images;
mod imu_csv;
mod imu_lines;
mod kalibr_cameras;
mod kitti;
mod leftovers;
mod lock;
mod loose_csv;
mod names;
mod noise_csv;
pub mod noise_formats;
mod one_each;
mod pose;
mod poses;
mod printable;
#[cfg(test)]
mod recordings;
mod result_path;
mod row_fault;
mod rows;
mod sample_store;
mod sieve;
mod small;
mod store;
mod times_folder;
mod tracks;
mod tum;
mod understood;
mod unit;
mod words;
mod yaml;

pub use atomic::{atomic_write, write_file, write_json};
pub use beneath::Kind;
pub use choice::ColumnChoice;
pub use columns::{AccelUnit, GyroUnit, ImuColumns, axis_columns};
pub use decimal::TimeUnit;
pub use error::{IoError, in_full};
#[cfg(feature = "images")]
pub use grey::{ByteOrder, PixelLayout};
pub use head::{has_stamps, names_all, only_sensor};
#[cfg(feature = "images")]
pub use image_file::parse_image;
#[cfg(feature = "images")]
pub use images::{Coverage, ImageFolder, ImageRun, Prefetch, StampedImage};
pub use imu_csv::{ImuLog, parse_imu_csv, read_imu_csv};
pub use imu_lines::ImuLines;
pub use leftovers::scratch_file;
pub use lock::{FolderLock, LockError};
pub use loose_csv::{LooseImuLog, Unreadable, parse_imu_csv_loosely, parse_one_sensor_loosely, settle_units};
pub use noise_csv::{read_noise_track, write_noise_rows, write_noise_track};
pub use one_each::OneEach;
pub use poses::{read_counted_poses, read_poses, stamped_pose};
pub use printable::printable;
pub use result_path::ResultPath;
pub use row_fault::RowFault;
pub use sample_store::{SampleStore, StoredRecording};
pub use sieve::{ABSURD, LeftOut, Part, Sieve, Sieved, Sifted, TINY};
pub use store::{Row, Store};
pub use times_folder::TimesFolder;
pub use tracks::{read_tracks, write_tracks};
pub use tum::{read_tum, tum_line, write_tum};
pub use understood::{CsvOptions, Origin, Settled, Understood, counted_stamp};
pub use yaml::walk_yaml;

/// The README's code is a test.
#[cfg(doctest)]
#[doc = include_str!("README.md")]
struct Readme;
