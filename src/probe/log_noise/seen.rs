//! What the spectrum of a log's seconds in motion says of a low pass.

use dpn_core::estimate::{LowPassSight, Seen};
use dpn_core::signal::{Spectrum, Welch};
use dpn_core::{ImuSample, Recorded, Sensor};
use std::io;
use std::ops::Range;

/// Of a sensor whose converter counts in `steps`, over the seconds that count.
pub(super) fn seen(
    recording: &dyn Recorded,
    sensor: Sensor,
    steps: [Option<f64>; 3],
    range: Range<usize>,
    second: usize,
    counts: &dyn Fn(&[ImuSample]) -> bool,
) -> io::Result<Seen> {
    let rate = recording.rate();
    let (Ok(welch), Some(sight)) = (Welch::new(second), LowPassSight::new(rate, second)) else {
        return Ok(Seen::Untold);
    };
    let mut axes = [(); 3].map(|()| welch.averaging());
    let mut signal = Vec::with_capacity(second);
    let mut seconds = 0;
    recording.pieces(range, second, &mut |second| {
        seconds += usize::from(counts(second));
        for (axis, averaging) in axes.iter_mut().enumerate().filter(|_| counts(second)) {
            signal.clear();
            signal.extend(second.iter().map(|s| s.of(sensor)[axis]));
            averaging.take(&signal);
        }
        Ok(())
    })?;
    let [x, y, z] = axes.map(|averaging| averaging.spectrum(rate));
    let (Some(x), Some(y), Some(z)) = (x, y, z) else { return Ok(Seen::Untold) };
    let rounding = steps.map(|step| step.map_or(0.0, |step| step * step / 6.0 / rate.hz()));
    Ok(sight.seen([&x, &y, &z].map(Spectrum::density), rounding, seconds))
}
