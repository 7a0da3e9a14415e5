//! Tones of rotors in a steady hover on one axis, away from any flight, and the process they are samples of.
//!
//! What [`rotors`] makes of a constant speed is stationary: harmonic h of power A_h^2 has the autocovariance
//!
//! R_h(t) = A_h^2 m cos(2 pi h f t) exp(-(2 pi h f)^2 (s_o^2 t^2 / 2 + s_w^2 tau^2 (t / tau - 1 + e^{-t / tau})))
//!
//! with the rotors' fixed differences s_o and their wander s_w of correlation time tau, both relative to the speed f: a Gaussian phase. m = 1 + 6 (s_o^2 + s_w^2) is
//! what the square of the speed adds to the power. Left out: that a faster rotor is louder while it is faster (a tenth of the power at most lags, which sums over a span
//! take out again), and the amplitudes' wander, which is slow against every span of interest.

use super::config::{SILENT, SPEED_WANDER_S, VibrationConfig};
use super::rotors::{self, Turning};
use crate::imu::series::ImuSeries;
use dpn_core::SampleRate;
use dpn_core::random::Stream;
use std::f64::consts::TAU;

/// Rotors in a steady hover, heard on one axis.
#[derive(Debug, Clone, PartialEq)]
pub struct HoverTones {
    config: VibrationConfig,
    /// Deviations of the harmonics, in the sensor's unit.
    harmonics: [f64; 3],
}

impl HoverTones {
    /// The rotors of `config` on an axis that hears their harmonics with these deviations.
    ///
    /// # Units and frames
    /// `harmonics` and the samples are in one unit, any.
    pub fn new(config: VibrationConfig, harmonics: [f64; 3]) -> Self {
        Self { config, harmonics }
    }

    /// `n` samples at `rate`, a draw of the process.
    pub fn draw(&self, n: usize, rate: SampleRate, stream: &Stream) -> Vec<f64> {
        let mut axes = [SILENT; 6];
        axes[0].harmonics = self.harmonics;
        let steady = vec![1.0; n];
        let mut series = ImuSeries::zeros(n);
        let (config, axes, speed, loudness) = (&self.config, &axes, &steady, &steady);
        rotors::add(&Turning { config, axes, speed, loudness, dt: rate.period(), stream }, &mut series);
        series.accel.iter().map(|value| value[0]).collect()
    }

    /// Expectation of the product of two samples that are `lag_s` seconds apart, over all draws.
    pub fn autocovariance(&self, lag_s: f64) -> f64 {
        let VibrationConfig { hover_hz, rotor_spread, speed_wander, .. } = self.config;
        let louder = 1.0 + 6.0 * (rotor_spread.powi(2) + speed_wander.powi(2));
        let t = lag_s.abs();
        let walked = t / SPEED_WANDER_S - 1.0 + (-t / SPEED_WANDER_S).exp();
        let phase = 0.5 * (rotor_spread * t).powi(2) + (speed_wander * SPEED_WANDER_S).powi(2) * walked;
        let harmonic = |(h, deviation): (usize, &f64)| {
            let angular = TAU * (h + 1) as f64 * hover_hz;
            deviation.powi(2) * louder * (angular * t).cos() * (-angular.powi(2) * phase).exp()
        };
        self.harmonics.iter().enumerate().map(harmonic).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn draws_have_the_autocovariance_that_is_said() {
        let rate = SampleRate::HZ_200;
        for (rotors, harmonics, hover_hz, speed_wander) in [
            (1, [1.0, 0.0, 0.0], 91.5, 0.035),
            (2, [0.3, 0.6, 0.2], 60.0, 0.01),
            (1, [0.0, 1.0, 0.0], 91.5, 0.05),
        ] {
            let config = VibrationConfig { rotors, hover_hz, speed_wander, ..VibrationConfig::default() };
            let tones = HoverTones::new(config, harmonics);
            let (draws, n) = (3000, 60);
            let mut found = [0.0; 40];
            for draw in 0..draws {
                let x = tones.draw(n, rate, &Stream::new(8).named("hover").index(draw));
                for (lag, sum) in found.iter_mut().enumerate() {
                    *sum += (10..n - lag).map(|i| x[i] * x[i + lag]).sum::<f64>() / (n - lag - 10) as f64;
                }
            }
            let power = tones.autocovariance(0.0);
            for (lag, sum) in found.iter().enumerate() {
                let expected = tones.autocovariance(lag as f64 * rate.period());
                // A draw's power scatters by some 60 % (gains, loudness, two rotors' beat): 3000 are known to 1.1 %. What the module leaves out,
                // 4 (s_o^2 + s_w^2) h w t sin(h w t) in units of the power, is up to .1 before the phase forgets.
                let off = (sum / draws as f64 - expected) / power;
                assert!(off.abs() < 0.15, "{harmonics:?} {hover_hz} lag {lag}: {off}");
            }
        }
    }
}
