//! Whether the spectrum of a log in motion falls as behind a low pass: then what is above motion says nothing of the noise below.

use dpn_core::signal::Spectrum;
use dpn_core::signal::stats::quantile;

/// The lower band's density over the upper one's from which a low pass is taken to be on: one of first order at a fifth of the rate has 3, of second order 15. In
/// EuRoC's flights and TUM-VI's rooms, which have none that shows, the most is 3.
const FALLS: f64 = 5.0;
/// What stands out of a band as vibration does is none of its level.
const LEVEL: f64 = 0.25;
/// Between these \[Hz\] motion is least of all that a low pass lets through.
const SLOW: [f64; 2] = [5.0, 35.0];

/// Densities that the noise lies between \[unit^2 / Hz\], where the spectrum falls above `motion_hz`.
pub(super) fn between(spectrum: &Spectrum, motion_hz: f64) -> Option<[f64; 2]> {
    let (bin, density) = (spectrum.bin_hz(), spectrum.density());
    let nyquist = bin * (density.len() - 1) as f64;
    let level = |low: f64, high: f64| {
        let inside = |k: &usize| (low..high).contains(&(*k as f64 * bin));
        let values: Vec<f64> = (1..density.len()).filter(inside).map(|k| density[k]).collect();
        (values.len() >= 3).then(|| quantile(&values, LEVEL))
    };
    let low = level(motion_hz, motion_hz + 0.2 * nyquist)?;
    let high = level(0.75 * nyquist, 0.95 * nyquist)?;
    let slow = level(SLOW[0], SLOW[1].min(motion_hz))?;
    (low > FALLS * high).then(|| [low, slow.max(low)])
}
