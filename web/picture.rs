//! A track thinned to what a picture can show: of every so many answers the lowest and the highest of each axis.

use dpn_core::{Sensor, Stamp};
use dpn_probe::log_noise::Along;
use serde_json::{Value, json};
use std::io;

/// Places along the picture; more than any screen is wide.
const PLACES: usize = 4000;

/// Seconds from `start`, and for each of the six axes (accelerometer x y z, gyroscope x y z) the lowest and highest deviation about then.
pub(crate) fn of(along: &Along, start: Stamp) -> io::Result<Value> {
    let together = along.track.len().div_ceil(PLACES).max(1);
    let mut times = Vec::new();
    let mut ranges: [Vec<[f64; 2]>; 6] = Default::default();
    let mut count = 0;
    along.track.each(|answer| {
        let t = answer.t.seconds_since(start);
        // Until there is a full window, the answers are constants.
        if t < along.summary.unknown_s {
            return Ok(());
        }
        let values = Sensor::ALL.into_iter().flat_map(|sensor| answer.noise.of(sensor));
        if count % together == 0 {
            times.push(t);
            ranges.iter_mut().zip(values).for_each(|(range, v)| range.push([v, v]));
        } else {
            for (range, v) in ranges.iter_mut().zip(values) {
                if let Some([low, high]) = range.last_mut() {
                    *low = low.min(v);
                    *high = high.max(v);
                }
            }
        }
        count += 1;
        Ok(())
    })?;
    Ok(json!({ "t_s": times, "ranges": ranges, "answers": along.track.len() }))
}
