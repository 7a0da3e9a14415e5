//! What the frame adds to the rotors' tones: a line near 27 Hz and a broad band.
//!
//! The line is one oscillation, phi' = 2 pi (f_low + wander), heard on all axes with its own phase, already when
//! the motors idle. The band is white noise through a two-pole resonance,
//! x_k = 2 r cos(w) x_{k-1} - r^2 x_{k-2} + e_k, scaled to unit deviation, one stream an axis; it grows with the
//! square of the motors' speed.

use super::shaking::Shaking;
use crate::imu::ou::Wander;
use crate::imu::series::ImuSeries;
use dpn_core::random::StreamRng;
use rand::Rng;
use rand_distr::StandardNormal;
use std::f64::consts::{SQRT_2, TAU};

/// Correlation time of the low line's frequency \[s\].
const LOW_LINE_WANDER_S: f64 = 0.3;

/// Adds the low line.
pub(super) fn add_low_line(of: &Shaking<'_>, to: &mut ImuSeries) {
    let Shaking { config, axes, speed, dt, .. } = *of;
    let stream = of.stream.named("low-line");
    let mut rng = stream.named("place").rng();
    let mut phase = rng.random_range(0.0..TAU);
    let lag: [f64; 6] = std::array::from_fn(|_| rng.random_range(0.0..TAU));
    let mut wander =
        Wander::new(config.low_line_wander_hz, LOW_LINE_WANDER_S, dt, stream.named("frequency").rng());
    // It swells and fades more, and faster, than the rotors do.
    let swell = 4.0 * config.amplitude_wander;
    let mut loudness =
        Wander::new(swell, 0.25 * config.amplitude_wander_s, dt, stream.named("loudness").rng());
    for (i, &motors) in speed.iter().enumerate() {
        phase += TAU * (config.low_line_hz + wander.next()) * dt;
        // exp of a normal has a mean square of exp(2 swell^2); the ramp ends at the idle speed.
        let ramp = (motors / config.idle_speed).min(1.0);
        let swing = SQRT_2 * ramp * (loudness.next() - swell * swell).exp();
        for (a, axis) in axes.iter().enumerate() {
            *to.value_mut(a, i) += axis.low_line * swing * (phase + lag[a]).sin();
        }
    }
}

/// Adds the broad band.
pub(super) fn add_broad_band(of: &Shaking<'_>, to: &mut ImuSeries) {
    let Shaking { config, axes, speed, loudness, dt, stream } = *of;
    for (a, axis) in axes.iter().enumerate() {
        let rng = stream.named("broad-band").index(a as u64).rng();
        let mut resonance = Resonance::new(axis.broad_band_hz, dt, rng);
        // Bursts give the tails that the real residual has.
        let swell = 2.5 * config.amplitude_wander;
        let mut burst = Wander::new(
            swell,
            0.125 * config.amplitude_wander_s,
            dt,
            stream.named("burst").index(a as u64).rng(),
        );
        for (i, (&motors, &loud)) in speed.iter().zip(loudness).enumerate() {
            let swing = motors * motors * loud * (burst.next() - swell * swell).exp();
            *to.value_mut(a, i) += axis.broad_band * swing * resonance.next();
        }
    }
}

/// A two-pole resonance driven by white noise, of unit deviation.
struct Resonance {
    phi: [f64; 2],
    drive: f64,
    past: [f64; 2],
    rng: StreamRng,
}

impl Resonance {
    /// Centre \[Hz\]; the band is about as wide as its centre is high.
    fn new(centre_hz: f64, dt: f64, rng: StreamRng) -> Self {
        let angle = TAU * centre_hz * dt;
        // Half width pi f dt in the exponent: quality about 1.
        let r = (-0.5 * angle).exp();
        let phi = [2.0 * r * angle.cos(), -r * r];
        // Variance of an AR(2) process driven by unit noise.
        let variance = (1.0 - phi[1]) / ((1.0 + phi[1]) * ((1.0 - phi[1]).powi(2) - phi[0].powi(2)));
        let mut resonance = Self { phi, drive: 1.0 / variance.sqrt(), past: [0.0; 2], rng };
        for _ in 0..500 {
            resonance.next();
        }
        resonance
    }

    fn next(&mut self) -> f64 {
        let draw: f64 = self.rng.sample(StandardNormal);
        let now = self.phi[0] * self.past[0] + self.phi[1] * self.past[1] + self.drive * draw;
        self.past = [now, self.past[0]];
        now
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use dpn_core::random::Stream;

    #[test]
    fn a_resonance_has_unit_deviation_at_any_centre() {
        for centre in [5.0, 13.0, 50.0, 90.0] {
            let mut resonance = Resonance::new(centre, 0.005, Stream::new(1).rng());
            let n = 100_000;
            let variance = (0..n).map(|_| resonance.next().powi(2)).sum::<f64>() / f64::from(n);
            // At 5 Hz the memory is about 13 samples: 7,700 independent ones, a standard error of 1.6 %.
            assert!((variance - 1.0).abs() < 0.065, "{centre}: {variance}");
        }
    }
}
