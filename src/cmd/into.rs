//! `dpn noise --into`: the log again, its IMU's messages with the covariances that the track says.

use crate::args::HowArgs;
use crate::ui::{errln, refuse};
use anyhow::Result;
use dpn_core::{ImuNoise, Samples, Stamp};
use dpn_io::atomic_write;
use dpn_logs::{Log, is_copied, write_imu_log, write_with_covariances};
use dpn_probe::log_noise::Track;
use std::path::Path;

/// Refuses what would only fail once the track is there.
pub(super) fn check(path: &Path, log: &Log, how: &HowArgs) -> Result<()> {
    let unit = how.gyro_unit.is_some_and(|unit| unit.factor() != 1.0)
        || how.accel_unit.is_some_and(|unit| unit.factor() != 1.0);
    let scaled = unit || how.gyro_scale.is_some() || how.accel_scale.is_some() || how.sensor_scale.is_some();
    if scaled && is_copied(path, log.kind)? {
        let text = "--into copies messages as they are, and their numbers are said not to be SI units";
        return refuse(text, "convert the log first, or leave the scales away");
    }
    Ok(())
}

/// Writes the log at `path` to `into`; messages before `unknown_s` have no noise yet. Returns what to say of it.
pub(super) fn write(
    into: &Path,
    path: &Path,
    log: &Log,
    how: &HowArgs,
    (track, unknown_s): (&Track, f64),
) -> Result<String> {
    let mut known: Vec<(Stamp, ImuNoise)> = Vec::new();
    let mut first = None;
    track.each(|answer| {
        let first = *first.get_or_insert(answer.t);
        if answer.t.seconds_since(first) >= unknown_s {
            known.push((answer.t, answer.noise));
        }
        Ok(())
    })?;
    let noise = |t: Stamp| {
        let after = known.partition_point(|(at, _)| *at <= t);
        after.checked_sub(1).map(|at| known[at].1)
    };
    match &log.topic {
        Some(topic) if is_copied(path, log.kind)? => {
            let copied = write_with_covariances(path, log.kind, topic, how.max_uncompressed, into, noise)?;
            if copied.undecodable > 0 {
                errln!(
                    "warning: {} messages on {topic} are no sensor_msgs/Imu: copied as they are",
                    copied.undecodable
                );
            }
            Ok(format!(
                "{} messages of {topic} with covariances, {} before the first window as they were, {} of other topics",
                copied.filled, copied.before, copied.others
            ))
        }
        _ => {
            let samples = &log.recording;
            atomic_write(into, |out| write_imu_log(out, |take| samples.each(0..samples.len(), take), noise))?;
            errln!(
                "note: {} is copied by its samples alone, as sensor_msgs/msg/Imu on /imu",
                log.kind.name()
            );
            Ok(format!("{} messages of /imu", samples.len()))
        }
    }
}
