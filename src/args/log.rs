//! A log that somebody recorded, and how it is to be read.

use super::cache::size;
use super::word::word;
use clap::Args;
use dpn_core::SampleRate;
use dpn_io::{AccelUnit, ColumnChoice, GyroUnit, TimeUnit};
use dpn_logs::{LogTime, Scales};
use std::path::PathBuf;

/// The log, its columns and units.
#[derive(Debug, Args)]
pub(crate) struct LogArgs {
    /// CSV file, rosbag1, MCAP, rosbag2, ULog or ArduPilot log, packed or not; folder of an ASL sequence (EuRoC, TUM-VI), of a rosbag2 or of a
    /// phone's two files, or its zip; a pipe, or - for stdin.
    #[arg(value_name = "LOG")]
    pub(crate) path: PathBuf,
    /// Which part of it.
    #[command(flatten)]
    pub(crate) span: SpanArgs,
    /// How it is read.
    #[command(flatten)]
    pub(crate) how: HowArgs,
}

/// A part of a log.
#[derive(Debug, Clone, Copy, Args)]
pub(crate) struct SpanArgs {
    /// Where the part of the log begins that is looked at: seconds after its first sample, or a stamp in seconds or nanoseconds.
    #[arg(long, value_name = "SECONDS|STAMP")]
    pub(crate) from: Option<LogTime>,
    /// Where it ends.
    #[arg(long, value_name = "SECONDS|STAMP")]
    pub(crate) to: Option<LogTime>,
}

/// Topic, columns and units.
#[derive(Debug, Args)]
pub(crate) struct HowArgs {
    /// The IMU's topic in a bag; without it, the only one of type sensor_msgs/Imu, or the two of its sensors. Of a ULog a topic, of an ArduPilot
    /// log IMU/1 for the second.
    #[arg(long, value_name = "NAME")]
    pub(crate) topic: Option<String>,
    /// Bytes that a bag's chunks or a packed file may unpack to, all together, for example 4GB; without it, 32 MB and 32 times the packed bytes.
    #[arg(long, value_name = "SIZE", value_parser = size)]
    pub(crate) max_uncompressed: Option<u64>,
    /// CSV columns, by number from 1 or by the header's names: stamp, gyroscope x y z, accelerometer x y z; without it, by what the names mean.
    #[arg(long, value_name = "T,GX,GY,GZ,AX,AY,AZ")]
    pub(crate) columns: Option<ColumnChoice>,
    /// Unit of the CSV's stamps: days, s, ms, 100us, us, 100ns, ns; without it, by the header or their steps.
    #[arg(long, value_name = "UNIT", value_parser = word::<TimeUnit>)]
    pub(crate) time_unit: Option<TimeUnit>,
    /// Rate of a log without stamps: its samples are counted, those of a log whose stamps are not to be believed too. With --follow, rate of the samples.
    #[arg(long, value_name = "HZ", value_parser = rate)]
    pub(crate) rate: Option<SampleRate>,
    /// Unit of the gyroscope's numbers: rad/s, deg/s, mdeg/s, deg/h or rpm; without it, of a table by the header or told from its turns and noise, else rad/s.
    #[arg(long, value_name = "UNIT", value_parser = word::<GyroUnit>)]
    pub(crate) gyro_unit: Option<GyroUnit>,
    /// Unit of the accelerometer's numbers: m/s^2, g, mg, cm/s^2 or ft/s^2; without it, of a table by the header or told from gravity, else m/s^2.
    #[arg(long, value_name = "UNIT", value_parser = word::<AccelUnit>)]
    pub(crate) accel_unit: Option<AccelUnit>,
    /// What one of the gyroscope's numbers is, in rad/s, of a log of any kind.
    #[arg(long, value_name = "RAD/S", allow_negative_numbers = true, value_parser = scale, conflicts_with_all = ["gyro_unit", "sensor_scale"])]
    pub(crate) gyro_scale: Option<f64>,
    /// What one of the accelerometer's numbers is, in m/s^2, of a log of any kind.
    #[arg(long, value_name = "M/S^2", allow_negative_numbers = true, value_parser = scale, conflicts_with_all = ["accel_unit", "sensor_scale"])]
    pub(crate) accel_scale: Option<f64>,
    /// Both by sensor and ranges, where the log has raw counts: mpu6050-2g-250dps, bmi088-6g-2000dps, icm20948-4g-500dps, adis16448.
    #[arg(long, value_name = "NAME-RANGES", conflicts_with_all = ["gyro_unit", "accel_unit"])]
    pub(crate) sensor_scale: Option<Scales>,
}

/// A rate in Hz.
pub(crate) fn rate(text: &str) -> Result<SampleRate, String> {
    let hz = text.parse::<f64>().ok().and_then(SampleRate::from_hz);
    hz.ok_or_else(|| "a rate is a number of Hz above zero".to_owned())
}

fn scale(text: &str) -> Result<f64, String> {
    let number = text.parse::<f64>().ok().filter(|v| v.is_finite() && *v != 0.0);
    number.ok_or_else(|| "a number other than zero; a negative one turns the axes round".to_owned())
}
