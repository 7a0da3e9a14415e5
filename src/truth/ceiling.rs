//! The most white noise that a recording allows: its spectrum where it is quietest.
//!
//! A white noise of deviation `sigma` a sample has the density `2 sigma^2 / rate` at every frequency, so that the signal's own density nowhere lies below it. Motion
//! fills the low frequencies and rotors their lines; between them the sensor's floor shows. Without this bound the levels of IMU and slow published
//! error cannot always be told apart, for above its corner the one's spectrum falls as the other's does.

use dpn_core::signal::Welch;
use dpn_core::signal::stats::median;
use dpn_core::{ImuSample, SampleRate, Sensor};

/// Samples of a segment: bins of .2 Hz at 200 Hz would be few means, of 1.6 Hz they are hundreds.
const SEGMENT: usize = 128;
/// The lowest share of the bins is the floor,
const QUIETEST: f64 = 0.1;
/// and this much above it is allowed: the floor is the smallest of many estimates, and rotors shake more than one frequency.
const ROOM: f64 = 2.0;

/// The largest deviation a sample of white noise in one sensor; `None` for a recording shorter than a segment.
pub(crate) fn ceiling(samples: &[ImuSample], rate: SampleRate, sensor: Sensor) -> Option<f64> {
    Some(ROOM * median(&floors(samples, rate, sensor)?))
}

/// By axis, the deviation of a sample of white noise that is as loud as the signal where it is quietest.
pub(crate) fn floors(samples: &[ImuSample], rate: SampleRate, sensor: Sensor) -> Option<[f64; 3]> {
    let welch = Welch::new(SEGMENT).ok()?;
    let floor = |axis: usize| {
        let signal: Vec<f64> = samples.iter().map(|s| s.of(sensor)[axis]).collect();
        let spectrum = welch.spectrum(&signal, rate).ok()?;
        // Zero lacks the mean, Nyquist is not doubled.
        let mut bins = spectrum.density()[1..SEGMENT / 2].to_vec();
        bins.sort_by(f64::total_cmp);
        Some((bins[(QUIETEST * bins.len() as f64) as usize] * 0.5 * rate.hz()).sqrt())
    };
    Some([floor(0)?, floor(1)?, floor(2)?])
}
