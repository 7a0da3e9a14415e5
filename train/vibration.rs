//! Vibration that is injected beside white noise, and what it counts in sums over a span.
//!
//! A window's vibration is a draw of rotors in a steady hover ([`HoverTones`]) whose every figure is drawn too, so that no platform's own profile is
//! learned. Its tones are noise to whoever sums samples: over n of them a stationary noise of autocovariance R errs as much as white noise of variance
//!
//! sigma_eff^2 = R(0) + 2 sum_{m=1}^{n-1} (1 - m / n) R(m)
//!
//! That is the process's expectation, not one draw's: a second holds ten sums over a tenth of it, whose own scatter is 20 %.

use dpn_core::SampleRate;
use dpn_core::config::ConfigFaults;
use dpn_core::random::Stream;
use dpn_sim::imu::{HoverTones, VibrationConfig};
use rand::Rng;
use serde::{Deserialize, Serialize};

/// Rotors at most.
const ROTORS: u32 = 8;
/// Deviations of the second and third harmonics over that of the first, log-uniform.
const OVERTONES: (f64, f64) = (0.05, 1.0);
/// Fixed differences of the rotors' speeds, and their wander, each uniform, relative to the speed.
const UNSTEADY: (f64, f64) = (0.005, 0.06);
/// Deviation of the logarithm of the amplitudes, uniform.
const SWELL: (f64, f64) = (0.0, 0.2);

/// Which vibration windows have.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct VibrationDraw {
    /// Share of the windows with any \[0 to 1\].
    pub share: f64,
    /// Smallest and largest deviation of all tones together, log-uniform \[m/s^2 or rad/s\].
    pub deviation: [f64; 2],
    /// Slowest and fastest rotors, log-uniform \[Hz, 10 to 400\].
    pub hover_hz: [f64; 2],
}

/// One window's vibration.
#[derive(Debug, Clone, PartialEq)]
pub struct Vibration {
    /// In the sensor's unit.
    pub samples: Vec<f64>,
    /// The process they are a draw of.
    pub tones: HoverTones,
}

impl VibrationDraw {
    /// The vibration of a window of `len` samples of `rate`; none for the share that has none.
    pub fn draw(&self, len: usize, rate: SampleRate, stream: &Stream) -> Option<Vibration> {
        let mut rng = stream.named("vibration").rng();
        if rng.random::<f64>() >= self.share {
            return None;
        }
        let mut log_uniform = |[low, high]: [f64; 2]| low * (high / low).powf(rng.random::<f64>());
        let (deviation, hover_hz) = (log_uniform(self.deviation), log_uniform(self.hover_hz));
        let overtones = [(); 2].map(|()| log_uniform(OVERTONES.into()));
        let all = 1f64.hypot(overtones[0]).hypot(overtones[1]);
        let harmonics = [1.0, overtones[0], overtones[1]].map(|part| deviation * part / all);
        let mut uniform = |(low, high): (f64, f64)| rng.random_range(low..=high);
        let (rotor_spread, speed_wander) = (uniform(UNSTEADY), uniform(UNSTEADY));
        let amplitude_wander = uniform(SWELL);
        let rotors = rng.random_range(1..=ROTORS);
        let config = VibrationConfig {
            rotors,
            hover_hz,
            rotor_spread,
            speed_wander,
            amplitude_wander,
            ..VibrationConfig::default()
        };
        let tones = HoverTones::new(config, harmonics);
        Some(Vibration { samples: tones.draw(len, rate, stream), tones })
    }

    pub(crate) fn check(&self, faults: &mut ConfigFaults) {
        faults.within("noise.vibration.share", self.share, 0.0, 1.0);
        let (deviation, above) = (self.deviation, |v| v > 0.0 && v <= 100.0);
        faults.pair("noise.vibration.deviation", deviation, above, "above 0 and at most 100");
        let (hover_hz, usual) = (self.hover_hz, |hz| (10.0..=400.0).contains(&hz));
        faults.pair("noise.vibration.hover_hz", hover_hz, usual, "from 10 to 400");
    }
}

/// Deviation of the white noise that errs as much as `tones` do in sums of `samples` at `rate`.
pub fn effective(tones: &HoverTones, samples: usize, rate: SampleRate) -> f64 {
    let dt = rate.period();
    let product = |m: usize| (1.0 - m as f64 / samples as f64) * tones.autocovariance(m as f64 * dt);
    // Rounding may leave a little less than nothing of tones whose sums cancel.
    (product(0) + 2.0 * (1..samples).map(product).sum::<f64>()).max(0.0).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    const DRAW: VibrationDraw = VibrationDraw { share: 1.0, deviation: [0.5, 0.5], hover_hz: [60.0, 120.0] };

    fn drawn(draw: &VibrationDraw, stream: &Stream) -> Option<Vibration> {
        draw.draw(200, SampleRate::HZ_200, stream)
    }

    #[test]
    fn vibration_counts_as_much_as_its_sums_err() {
        let (mut found, mut expected) = (0.0, 0.0);
        for window in 0..3000 {
            let vibration = drawn(&DRAW, &Stream::new(6).index(window)).unwrap();
            let sums = vibration.samples.chunks_exact(20).map(|part| part.iter().sum::<f64>().powi(2) / 20.0);
            found += sums.sum::<f64>() / 10.0;
            expected += effective(&vibration.tones, 20, SampleRate::HZ_200).powi(2);
        }
        let ratio = (found / expected).sqrt();
        // Windows' mean squares scatter by a factor of some three: 3000 of them give the deviation to 3 %.
        assert!((ratio - 1.0).abs() < 0.08, "{ratio}");
        // And it counts a fifth of the samples' deviation, not all of it.
        assert!((0.02..0.3).contains(&(expected / 3000.0).sqrt()), "{}", (expected / 3000.0).sqrt());
    }

    #[test]
    fn the_share_without_has_none_and_a_span_of_one_sample_sees_all_of_it() {
        let half = VibrationDraw { share: 0.5, ..DRAW };
        let with = (0..400).filter(|window| drawn(&half, &Stream::new(7).index(*window)).is_some()).count();
        // 200 expected, deviation 10.
        assert!((160..240).contains(&with), "{with}");
        let vibration = drawn(&DRAW, &Stream::new(1)).unwrap();
        assert!((effective(&vibration.tones, 1, SampleRate::HZ_200) / 0.5 - 1.0).abs() < 0.03);
    }
}
