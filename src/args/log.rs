//! A log that somebody recorded, and how it is to be read.

use clap::Args;
use dpn_core::SampleRate;
use dpn_io::{AccelUnit, GyroUnit, ImuColumns, TimeUnit};
use std::path::PathBuf;

/// The log, its columns and units.
#[derive(Debug, Args)]
pub(crate) struct LogArgs {
    /// CSV file, rosbag1, MCAP or rosbag2 (file or folder), or folder of an ASL sequence (EuRoC, TUM-VI); a pipe, or - for stdin.
    #[arg(value_name = "LOG")]
    pub(crate) path: PathBuf,
    /// How it is read.
    #[command(flatten)]
    pub(crate) how: HowArgs,
}

/// Topic, columns and units.
#[derive(Debug, Args)]
pub(crate) struct HowArgs {
    /// The IMU's topic in a bag; without it, the only one of type sensor_msgs/Imu.
    #[arg(long, value_name = "NAME")]
    pub(crate) topic: Option<String>,
    /// Bytes that a bag's chunks may unpack to, all together, for example 4GB; without it, 32 MB and 32 times the packed bytes.
    #[arg(long, value_name = "SIZE", value_parser = bytes)]
    pub(crate) max_uncompressed: Option<u64>,
    /// CSV columns, counted from 1: stamp, gyroscope x y z, accelerometer x y z; without it, by the header's names.
    #[arg(long, value_name = "T,GX,GY,GZ,AX,AY,AZ", value_parser = columns)]
    pub(crate) columns: Option<ImuColumns>,
    /// Unit of the CSV's stamps: s, ms, us, ns; without it, by the header or their size.
    #[arg(long, value_name = "UNIT", value_parser = time_unit)]
    pub(crate) time_unit: Option<TimeUnit>,
    /// Unit of the CSV's gyroscope: rad/s or deg/s; without it, by the header or told from its turns and noise.
    #[arg(long, value_name = "UNIT", value_parser = gyro_unit)]
    pub(crate) gyro_unit: Option<GyroUnit>,
    /// Unit of the CSV's accelerometer: m/s^2, g or mg; without it, by the header or told from gravity.
    #[arg(long, value_name = "UNIT", value_parser = accel_unit)]
    pub(crate) accel_unit: Option<AccelUnit>,
}

/// A rate in Hz.
pub(crate) fn rate(text: &str) -> Result<SampleRate, String> {
    let hz = text.parse::<f64>().ok().and_then(SampleRate::from_hz);
    hz.ok_or_else(|| "a rate is a number of Hz above zero".to_owned())
}

/// `4GB`, `500 MB`, `1000000`.
fn bytes(text: &str) -> Result<u64, String> {
    let upper = text.trim().to_ascii_uppercase();
    let (digits, power) = [("GB", 3), ("MB", 2), ("KB", 1), ("B", 0), ("", 0)]
        .into_iter()
        .find_map(|(unit, power)| Some((upper.strip_suffix(unit)?, power)))
        .expect("every text ends with nothing");
    let number = digits.trim().parse::<u64>().ok().and_then(|n| n.checked_mul(1000u64.pow(power)));
    number.ok_or_else(|| "a number of bytes, for example 4GB or 500MB".to_owned())
}

fn columns(text: &str) -> Result<ImuColumns, String> {
    let wrong = || "seven column numbers from 1, for example 1,2,3,4,5,6,7".to_owned();
    let numbers: Option<Vec<usize>> =
        text.split(',').map(|n| n.trim().parse::<usize>().ok().filter(|n| *n > 0)).collect();
    match numbers.as_deref() {
        Some([t, gx, gy, gz, ax, ay, az]) => {
            Ok(ImuColumns { time: t - 1, gyro: [gx - 1, gy - 1, gz - 1], accel: [ax - 1, ay - 1, az - 1] })
        }
        _ => Err(wrong()),
    }
}

fn time_unit(text: &str) -> Result<TimeUnit, String> {
    TimeUnit::ALL
        .into_iter()
        .find(|unit| unit.name() == text)
        .ok_or_else(|| "known are s, ms, us, ns".to_owned())
}

fn gyro_unit(text: &str) -> Result<GyroUnit, String> {
    let known = GyroUnit::ALL.into_iter().find(|unit| unit.name() == text);
    known.ok_or_else(|| "known are rad/s, deg/s".to_owned())
}

fn accel_unit(text: &str) -> Result<AccelUnit, String> {
    let known = AccelUnit::ALL.into_iter().find(|unit| unit.name() == text);
    known.ok_or_else(|| "known are m/s^2, g, mg".to_owned())
}
