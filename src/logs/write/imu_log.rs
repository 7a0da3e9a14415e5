//! An IMU's samples as `sensor_msgs/msg/Imu` in an MCAP file of their own, covariances filled in.

use super::mcap_log::{McapLog, unwritable};
use dpn_core::{ImuNoise, ImuSample, Sensor, Stamp};
use std::io::{self, Write};

/// The type's text, and those of the types in it, as rosbag2 writes them.
const DEFINITION: &str = include_str!("imu.msg");
/// What bags of one IMU call it.
const TOPIC: &str = "/imu";
const FRAME: &[u8] = b"imu\0";

/// Writes samples as messages on `/imu`: no orientation (its first covariance is -1), and where `noise` knows any, variances per sample.
/// `each` hands every sample over, in time.
///
/// # Errors
/// The writer's and `each`'s; a stamp before 1970 or after 2038.
pub fn write_imu_log(
    out: &mut dyn Write,
    each: impl FnOnce(&mut dyn FnMut(&ImuSample)) -> io::Result<()>,
    mut noise: impl FnMut(Stamp) -> Option<ImuNoise>,
) -> io::Result<()> {
    let mut log = McapLog::new(out, "ros2")?;
    let channel = log.channel(TOPIC, "cdr", ("sensor_msgs/msg/Imu", "ros2msg", DEFINITION))?;
    let mut written = Ok(());
    each(&mut |sample| {
        if written.is_ok() {
            written = message(sample, noise(sample.t)).and_then(|data| log.message(channel, sample.t, &data));
        }
    })?;
    written?;
    log.finish()
}

/// A message in CDR, its lowest bytes first.
fn message(sample: &ImuSample, noise: Option<ImuNoise>) -> io::Result<Vec<u8>> {
    let (seconds, nanos) = (sample.t.ns().div_euclid(1_000_000_000), sample.t.ns().rem_euclid(1_000_000_000));
    let seconds = i32::try_from(seconds).map_err(|_| unwritable(sample.t))?;
    let mut data = vec![0, 1, 0, 0];
    data.extend(seconds.to_le_bytes());
    data.extend((nanos as u32).to_le_bytes());
    data.extend((FRAME.len() as u32).to_le_bytes());
    // Four bytes: the doubles lie at a multiple of eight behind them.
    data.extend(FRAME);
    let mut values = [0.0; 37];
    (values[3], values[4]) = (1.0, -1.0);
    values[13..16].copy_from_slice(&sample.gyro);
    values[25..28].copy_from_slice(&sample.accel);
    for (first, sensor) in [(16, Sensor::Gyro), (28, Sensor::Accel)] {
        let sigmas = noise.map_or([0.0; 3], |noise| noise.of(sensor));
        for (axis, sigma) in sigmas.into_iter().enumerate() {
            values[first + 4 * axis] = sigma * sigma;
        }
    }
    data.extend(values.iter().flat_map(|value: &f64| value.to_le_bytes()));
    Ok(data)
}
