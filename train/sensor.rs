//! What sensors do to their samples, beside white noise: a low pass of their own, and steps of their converter.
//!
//! Both leave the noise of sums over a tenth of a second nearly as it is, so the label does not change; a network that has seen neither takes a low pass for less noise.

use dpn_core::SampleRate;
use dpn_core::config::ConfigFaults;
use dpn_core::random::Stream;
use rand::Rng;
use serde::{Deserialize, Serialize};
use std::f64::consts::PI;

/// Which windows a sensor's low pass and steps are drawn for.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SensorDraw {
    /// Share of the windows behind a low pass, of first or second order by equal chance \[0 to 1\].
    pub low_pass_share: f64,
    /// Lowest and highest corner, log-uniform \[Hz, 5 to 400\].
    pub corner_hz: [f64; 2],
    /// Share of the windows in steps \[0 to 1\].
    pub step_share: f64,
    /// Smallest and largest step, log-uniform \[m/s^2 or rad/s\].
    pub step: [f64; 2],
}

/// What one window's sensor does.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct SensorEffects {
    /// Corner \[Hz\], and whether it is of first order.
    pub(crate) low_pass: Option<(f64, bool)>,
    /// In the sensor's unit.
    pub(crate) step: Option<f64>,
}

impl SensorDraw {
    /// A window's effects.
    pub(crate) fn draw(&self, stream: &Stream) -> SensorEffects {
        let mut rng = stream.named("sensor").rng();
        let mut log_uniform = |[low, high]: [f64; 2]| low * (high / low).powf(rng.random::<f64>());
        let (corner_hz, step) = (log_uniform(self.corner_hz), log_uniform(self.step));
        let [passes, steps, order] = [(); 3].map(|()| rng.random::<f64>());
        SensorEffects {
            low_pass: (passes < self.low_pass_share).then_some((corner_hz, order < 0.5)),
            step: (steps < self.step_share).then_some(step),
        }
    }

    pub(crate) fn check(&self, faults: &mut ConfigFaults) {
        let key = |name: &str| format!("noise.sensor.{name}");
        faults.within(key("low_pass_share"), self.low_pass_share, 0.0, 1.0);
        faults.within(key("step_share"), self.step_share, 0.0, 1.0);
        faults.pair(key("corner_hz"), self.corner_hz, |hz| (5.0..=400.0).contains(&hz), "from 5 to 400");
        faults.pair(key("step"), self.step, |step| step > 0.0 && step <= 10.0, "above 0 and at most 10");
    }
}

impl SensorEffects {
    /// Puts `window`, samples of `rate`, behind the low pass and in steps.
    pub(crate) fn apply(&self, window: &mut [f64], rate: SampleRate) {
        if let Some((corner_hz, first_order)) = self.low_pass {
            low_pass(window, corner_hz / rate.hz(), first_order);
        }
        if let Some(step) = self.step {
            window.iter_mut().for_each(|v| *v = step * (*v / step).round());
        }
    }
}

/// Butterworth's low pass of first or second order with its corner at `cycles` a sample, by the bilinear transform; before the window its first sample has stood for ever.
fn low_pass(window: &mut [f64], cycles: f64, first_order: bool) {
    let Some(&first) = window.first() else { return };
    // At half the rate the transform has its pole: a corner there and above changes nothing.
    if cycles >= 0.499 {
        return;
    }
    let k = (PI * cycles).tan();
    if first_order {
        let (gain, pole) = (k / (1.0 + k), (1.0 - k) / (1.0 + k));
        let (mut x1, mut y1) = (first, first);
        for v in window {
            let y = gain * (*v + x1) + pole * y1;
            (x1, y1, *v) = (*v, y, y);
        }
        return;
    }
    let norm = 1.0 / (1.0 + 2f64.sqrt() * k + k * k);
    let gain = k * k * norm;
    let (a1, a2) = (2.0 * (k * k - 1.0) * norm, (1.0 - 2f64.sqrt() * k + k * k) * norm);
    let ([mut x1, mut x2], [mut y1, mut y2]) = ([first; 2], [first; 2]);
    for v in window {
        let y = gain * (*v + 2.0 * x1 + x2) - a1 * y1 - a2 * y2;
        (x2, x1, y2, y1) = (x1, *v, y1, y);
        *v = y;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_low_pass_lets_constants_by_and_halves_the_power_at_its_corner() {
        for first_order in [true, false] {
            let mut still = vec![9.81; 50];
            low_pass(&mut still, 0.1, first_order);
            assert!(still.iter().all(|v| (v - 9.81).abs() < 1e-12));
            for (cycles, gain) in [(0.1, 0.5f64.sqrt()), (0.01, 1.0)] {
                let mut tone: Vec<f64> =
                    (0..4000).map(|i| (2.0 * PI * cycles * f64::from(i)).sin()).collect();
                low_pass(&mut tone, 0.1, first_order);
                let power = tone[2000..].iter().map(|v| v * v).sum::<f64>() / 1000.0;
                assert!((power.sqrt() / gain - 1.0).abs() < 0.01, "{cycles}: {}", power.sqrt());
            }
        }
    }

    #[test]
    fn shares_are_kept_and_steps_are_steps() {
        let draw =
            SensorDraw { low_pass_share: 0.3, corner_hz: [20.0, 80.0], step_share: 1.0, step: [0.1, 0.1] };
        let mut behind = 0;
        for i in 0..1000 {
            let mut window: Vec<f64> = (0..40).map(|i| (f64::from(i) * 0.7).sin()).collect();
            let effects = draw.draw(&Stream::new(2).index(i));
            effects.apply(&mut window, SampleRate::HZ_200);
            behind += u32::from(effects.low_pass.is_some());
            assert!(window.iter().all(|v| (v / 0.1 - (v / 0.1).round()).abs() < 1e-9));
        }
        // 300 expected, deviation 14.
        assert!((245..355).contains(&behind), "{behind}");
    }
}
