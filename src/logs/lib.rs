//! Logs as people have them, read into one recording: [`read_log`].
//!
//! | what | how it is told | of it is used |
//! |---|---|---|
//! | ASL folder (EuRoC, TUM-VI) | holds `mav0/imu0/data.csv` or `imu0/data.csv` | all six axes |
//! | rosbag2 folder | holds `*.mcap` or `*.db3` | one `sensor_msgs/msg/Imu` topic, over all its files |
//! | rosbag1 | `#ROSBAG V2.0` | one `sensor_msgs/Imu` topic; chunks plain, lz4 or bz2 |
//! | MCAP | its magic | one IMU topic in CDR or ROS 1 encoding; chunks plain, lz4 or zstd |
//! | rosbag2's SQLite file | `SQLite format 3` | one IMU topic in CDR |
//! | ULog | its magic | `sensor_combined`, `vehicle_imu`, or `sensor_gyro` and `sensor_accel` |
//! | ArduPilot | the `FMT` of `FMT`, in binary or text | `IMU` records of one instance |
//! | Betaflight, INAV | their first line (feature `blackbox`) | gyroscope and accelerometer of the main frames |
//! | folder of a phone | a `*gyro*` and an `*accel*` file | both, joined; beside a `time` file a row of each |
//! | JSON | begins with a bracket | objects of a sensor, joined, or of both |
//! | table with a row a sensor | its rows begin with sensors' names | both, joined |
//! | CSV | all else | columns by header, list or order; units by flag, header or guess |
//!
//! Any of them may be packed by gzip, zstd, xz or bzip2, and lie alone in a zip archive; so may a phone's folder. Sensors on two topics or in two files are joined on the gyroscope's stamps.
//!
//! With the feature `images`, [`ImageLog`] reads the images beside the samples, of bags and of folders with `times.txt`, and [`read_sensors`] hands both on as they come.
//!
//! With the feature `write`, logs are written too, MCAP all of them: [`write_with_covariances`] copies one with its IMU's covariances filled in, and [`McapLog`] takes what anybody
//! has to log.
//!
//! A reader here goes on where it can: a bag that is cut off or damaged gives everything before the damage, samples that no recording may
//! hold are left out, and [`Log::warnings`] says all of it. Files are read as a stream: beside the samples there is one chunk in memory.
//!
//! Why the bag formats are parsed here: the part that concerns an IMU is a page each. `rosbag` 0.6 maps the file with `unsafe`, trusts its
//! strings to be UTF-8, needs a bag's index, which one that was cut off has not, and panics on an odd one; `mcap` 0.26 (whose writer is used) subtracts the length
//! of a record from that of its chunk unchecked, and brings two C libraries for decompression. Decompression and SQLite are crates'.
#![cfg_attr(test, allow(clippy::unwrap_used))]

mod ardupilot;
mod bag;
#[cfg(feature = "blackbox")]
mod blackbox;
mod budget;
mod bytes;
#[cfg(feature = "images")]
mod cameras;
mod chosen;
mod decompress;
mod detect;
mod error;
mod fields;
mod folder;
#[cfg(all(test, feature = "images"))]
mod fuzz;
mod gcsv;
#[cfg(test)]
mod golden;
#[cfg(test)]
mod golden_logs;
#[cfg(all(test, feature = "images"))]
mod golden_rigs;
#[cfg(feature = "images")]
mod image_log;
#[cfg(feature = "images")]
mod image_message;
#[cfg(feature = "images")]
mod image_options;
mod imu_file;
mod imu_message;
mod join;
mod json;
mod kind;
#[cfg(feature = "images")]
mod live_imus;
#[cfg(feature = "images")]
mod live_join;
mod log;
mod long;
mod mcap;
mod messages;
mod options;
mod oxiod;
mod packed;
mod plain;
#[cfg(feature = "images")]
mod poses;
mod read;
mod records;
mod rosbag1;
mod rosbag2;
mod scale;
#[cfg(feature = "images")]
mod sensors;
mod serial_monitor;
mod span;
#[cfg(feature = "sqlite")]
mod sqlite;
#[cfg(not(feature = "sqlite"))]
#[path = "no_sqlite.rs"]
mod sqlite;
mod topics;
mod two_clocks;
mod two_files;
mod ulog;
#[cfg(feature = "write")]
mod write;
#[cfg(feature = "zip")]
mod zipped;

pub use error::LogError;
pub use folder::logs_in;
/// Messages of ROS by their bytes, for who has them from elsewhere than a bag.
pub mod ros {
    pub use crate::fields::{Encoding, Fields, Header, Undecodable};
    #[cfg(feature = "images")]
    pub use crate::image_message::{ImageKind, ImageMessage, decode as decode_image};
}
#[cfg(feature = "images")]
pub use image_log::{ImageLog, Images};
#[cfg(feature = "images")]
pub use image_options::{ImageLogOptions, ImageSpan};
pub use kind::Kind;
pub use log::{Log, OtherPart};
pub use options::LogOptions;
#[cfg(feature = "images")]
pub use poses::{BagPoses, is_bag, read_bag_poses};
pub use read::{read_bag, read_log, read_stream};
pub use scale::Scales;
#[cfg(feature = "images")]
pub use sensors::{SensorEvent, read_sensors, read_sensors_from};
pub use span::{LogSpan, LogTime};

#[cfg(feature = "write")]
pub use write::{CovarianceCopy, McapLog, is_copied, write_imu_log, write_with_covariances};

/// The README's code is a test.
#[cfg(doctest)]
#[doc = include_str!("README.md")]
struct Readme;
