//! Gyroflow's own log (`.gcsv`): a preamble of `key,value` lines says what one of its numbers is: `tscale` in s, `gscale` in rad/s, `ascale` in g.

use crate::LogOptions;
use dpn_io::{AccelUnit, TimeUnit};

/// Its first line.
const FIRST: &[u8] = b"GYROFLOW IMU LOG";

/// The options with what the preamble says where they say nothing, and that in words; none for another log.
pub(crate) fn scaled(head: &[u8], options: &LogOptions) -> Option<(LogOptions, String)> {
    if !head.starts_with(FIRST) {
        return None;
    }
    let said = |key: &str| {
        let line = head.split(|byte| *byte == b'\n').find_map(|line| line.strip_prefix(key.as_bytes()))?;
        let number = std::str::from_utf8(line.strip_prefix(b",")?).ok()?.trim().parse::<f64>().ok()?;
        (number.is_finite() && number != 0.0).then_some(number)
    };
    let mut options = options.clone();
    let mut words = Vec::new();
    if let (Some(scale), None, None) = (said("gscale"), options.scales.gyro, options.csv.gyro) {
        options.scales.gyro = Some(scale);
        words.push("gscale");
    }
    if let (Some(scale), None, None) = (said("ascale"), options.scales.accel, options.csv.accel) {
        options.scales.accel = Some(scale * AccelUnit::StandardGravity.factor());
        words.push("ascale");
    }
    let unit = said("tscale")
        .and_then(|scale| TimeUnit::ALL.into_iter().find(|unit| (unit.seconds() / scale - 1.0).abs() < 1e-6));
    if let (Some(unit), None) = (unit, options.csv.time) {
        options.csv.time = Some(unit);
        words.push("tscale");
    }
    Some((
        options,
        format!("the preamble's {}; axes as they stand, whatever its orientation", words.join(", ")),
    ))
}
