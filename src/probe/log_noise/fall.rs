//! Whether the spectrum of a log in motion falls as behind a low pass: then what is above motion says nothing of the noise below.

use dpn_core::estimate::MOTION_HZ;
use dpn_core::signal::stats::quantile;
use dpn_core::signal::{Spectrum, Welch};
use dpn_core::{ImuSample, Recorded, Sensor};
use std::io;
use std::ops::Range;

/// The lower band's density over the upper one's from which a low pass is taken to be on: one of first order at a fifth of the rate has 3, of second order 15. In
/// EuRoC's flights and TUM-VI's rooms, which have none that shows, the most is 3.
const FALLS: f64 = 5.0;
/// What stands out of a band as vibration does is none of its level.
const LEVEL: f64 = 0.25;
/// Between these \[Hz\] the density is with motion in it, and below the corner of what IMUs have: no noise is louder.
const SLOW: [f64; 2] = [4.0, 10.0];

/// What a sensor's density lies between, its loudest axis, where the seconds that count fall as behind a low pass.
pub(super) fn hidden(
    recording: &dyn Recorded,
    sensor: Sensor,
    range: Range<usize>,
    second: usize,
    counts: &dyn Fn(&[ImuSample]) -> bool,
) -> io::Result<Option<[f64; 2]>> {
    let rate = recording.rate();
    let Ok(welch) = Welch::new(second) else { return Ok(None) };
    let mut axes = [(); 3].map(|()| welch.averaging());
    let mut signal = Vec::with_capacity(second);
    recording.pieces(range, second, &mut |second| {
        for (axis, averaging) in axes.iter_mut().enumerate().filter(|_| counts(second)) {
            signal.clear();
            signal.extend(second.iter().map(|s| s.of(sensor)[axis]));
            averaging.take(&signal);
        }
        Ok(())
    })?;
    let motion = MOTION_HZ.min(0.25 * rate.hz());
    let all = axes.into_iter().filter_map(|averaging| averaging.spectrum(rate));
    let found: Vec<[f64; 2]> = all.filter_map(|spectrum| between(&spectrum, motion)).collect();
    // A low pass is on all axes; what shakes, on one more than on the others.
    let loudest = found.iter().copied().reduce(|a, b| [a[0].max(b[0]), a[1].max(b[1])]);
    // A bound has no more digits than these.
    let short = |density: f64| {
        let text = format!("{:.2e}", (0.5 * density).sqrt());
        text.parse().expect("Rust reads its own numbers")
    };
    Ok(loudest.filter(|_| found.len() == 3).map(|of| of.map(short)))
}

/// Densities that the noise lies between \[unit^2 / Hz\], where the spectrum falls above `motion_hz`.
fn between(spectrum: &Spectrum, motion_hz: f64) -> Option<[f64; 2]> {
    let (bin, density) = (spectrum.bin_hz(), spectrum.density());
    let nyquist = bin * (density.len() - 1) as f64;
    let level = |low: f64, high: f64| {
        let inside = |k: &usize| (low..high).contains(&(*k as f64 * bin));
        let values: Vec<f64> = (1..density.len()).filter(inside).map(|k| density[k]).collect();
        (values.len() >= 3).then(|| quantile(&values, LEVEL))
    };
    let low = level(motion_hz, motion_hz + 0.2 * nyquist)?;
    let high = level(0.75 * nyquist, 0.95 * nyquist)?;
    let slow = level(SLOW[0], SLOW[1])?;
    (low > FALLS * high).then(|| [low, slow.max(low)])
}

#[cfg(test)]
mod tests {
    use super::between;
    use dpn_core::SampleRate;
    use dpn_core::random::Stream;
    use dpn_core::signal::{Spectrum, Welch};
    use rand::Rng;
    use rand_distr::StandardNormal;
    use std::f64::consts::{PI, SQRT_2, TAU};

    /// White noise of 1 a sample behind two poles at `corner` of 200 Hz, with slow motion and a rotor.
    fn spectrum(corner: Option<f64>, rotor: f64) -> Spectrum {
        let mut rng = Stream::new(6).named("fall").rng();
        let k = (PI * corner.unwrap_or(50.0) / 200.0).tan();
        let g = 1.0 / (1.0 + k * SQRT_2 + k * k);
        let (mut x, mut y) = ([0.0; 2], [0.0; 2]);
        let signal: Vec<f64> = (0..12_000)
            .map(|i| {
                let now: f64 = rng.sample(StandardNormal);
                let a = [2.0 * (k * k - 1.0) * g, (1.0 - k * SQRT_2 + k * k) * g];
                let out = g * k * k * (now + 2.0 * x[0] + x[1]) - a[0] * y[0] - a[1] * y[1];
                (x, y) = ([now, x[0]], [out, y[0]]);
                let t = f64::from(i) / 200.0;
                let noise = if corner.is_some() { out } else { now };
                noise
                    + 20.0 * (TAU * 0.7 * t).sin()
                    + rotor * (TAU * (41.0 * t + 2.0 * (0.5 * t).sin())).sin()
            })
            .collect();
        Welch::new(200).unwrap().spectrum(&signal, SampleRate::HZ_200).unwrap()
    }

    #[test]
    fn a_low_pass_falls_and_neither_motion_nor_a_rotor_does() {
        assert_eq!(between(&spectrum(None, 0.0), 35.0), None);
        assert_eq!(between(&spectrum(None, 2.0), 35.0), None);
        for corner in [20.0, 42.0] {
            let [low, high] = between(&spectrum(Some(corner), 0.0), 35.0).unwrap();
            // One-sided: 1 a sample is .01.
            assert!(low < 0.0101 && high > 0.0085, "{corner}: {low} {high}");
        }
    }
}
