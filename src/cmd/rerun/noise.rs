//! `dpn noise --rerun`: samples and their deviations over time.

use super::log::RerunLog;
use anyhow::Result;
use dpn_core::{Recorded, Sensor};
use dpn_probe::log_noise::Track;
use std::io;
use std::path::Path;

/// Writes the recording; of the samples one in `every` is shown, as of the answers.
pub(in crate::cmd) fn noise(
    path: &Path,
    name: &str,
    recording: &dyn Recorded,
    (track, every): (&Track, usize),
) -> Result<()> {
    let mut first = None;
    recording.each(0..1, &mut |sample| first = Some(sample.t))?;
    let log = RerunLog::new(name, first.expect("a recording has samples"))?;
    for entity in ["noise/accel", "noise/gyro", "sample/accel", "sample/gyro"] {
        log.axes(entity)?;
    }
    let mut index = 0;
    let mut shown = Ok(());
    recording.each(0..recording.len(), &mut |sample| {
        if index % every == 0 && shown.is_ok() {
            log.at(sample.t);
            shown = Sensor::ALL
                .into_iter()
                .try_for_each(|sensor| log.numbers(&format!("sample/{sensor}"), &sample.of(sensor)));
        }
        index += 1;
    })?;
    shown?;
    track.each(|answer| {
        log.at(answer.t);
        Sensor::ALL
            .into_iter()
            .try_for_each(|sensor| log.numbers(&format!("noise/{sensor}"), &answer.noise.of(sensor)))
            .map_err(io::Error::other)
    })?;
    log.finish(path)
}
