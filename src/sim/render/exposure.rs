//! How long and with how much gain a frame is taken, and how much light there is: functions of time, so that any frame can be made alone.
//!
//! What the automatic exposure wants is known at whole quarters of a second, from what the camera sees there, and is followed with a lag of
//! one to two of them. Random changes and dark phases lie on grids of their own, each draw named by its place.

use super::config::{ExposureConfig, LowLightConfig};
use dpn_core::Stamp;
use dpn_core::random::Stream;
use rand::Rng;
use rand_distr::StandardNormal;
use std::collections::BTreeMap;

/// The exposure is settled this often \[ns\].
const KNOT_NS: i64 = 250_000_000;

/// Knots that are remembered.
const KEPT: usize = 64;

/// Length of a dark phase's begin and end \[s\].
const DUSK_S: f64 = 0.3;

/// How a frame is taken.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Setting {
    /// Light there is; 1 but in dark phases.
    pub(super) light: f64,
    /// Length of the exposure, 1 in mean light.
    pub(super) time: f64,
    /// Gain on top.
    pub(super) gain: f64,
}

/// An exposure control.
#[derive(Debug, Clone)]
pub(super) struct Exposure {
    config: ExposureConfig,
    low_light: LowLightConfig,
    changes: Stream,
    phases: Stream,
    /// ln of the factor that brings what is seen at a knot to the target, at a light of 1.
    wanted: BTreeMap<i64, Option<f64>>,
}

impl Exposure {
    pub(super) fn new(config: ExposureConfig, low_light: LowLightConfig, stream: &Stream) -> Self {
        Self {
            config,
            low_light,
            changes: stream.named("exposure"),
            phases: stream.named("low-light"),
            wanted: BTreeMap::new(),
        }
    }

    /// The setting at `t`; `sees` says what the camera sees at some time in a light of 1, coarsely, where it is known.
    pub(super) fn at(&mut self, t: Stamp, mut sees: impl FnMut(Stamp, &mut Vec<f32>) -> bool) -> Setting {
        let knot = t.ns().div_euclid(KNOT_NS);
        let between = t.ns().rem_euclid(KNOT_NS) as f64 / KNOT_NS as f64;
        let older = self.knot(knot - 1, &mut sees);
        let newer = self.knot(knot, &mut sees);
        let wanted = match (older, newer) {
            (Some(older), Some(newer)) => older + between * (newer - older),
            (Some(only), None) | (None, Some(only)) => only,
            (None, None) => self.wanted_at(t, &mut sees).unwrap_or(0.0),
        };
        let light = self.light(t);
        let factor = (wanted + self.change(t)).exp();
        let time = factor.clamp(1e-3, self.config.longest);
        Setting { light, time, gain: (factor / time).clamp(1.0, self.config.most_gain) }
    }

    /// What is wanted at a knot, remembered.
    fn knot(&mut self, knot: i64, sees: &mut impl FnMut(Stamp, &mut Vec<f32>) -> bool) -> Option<f64> {
        if let Some(wanted) = self.wanted.get(&knot) {
            return *wanted;
        }
        let wanted = self.wanted_at(Stamp::from_ns(knot.saturating_mul(KNOT_NS)), sees);
        if self.wanted.len() >= KEPT {
            self.wanted.clear();
        }
        self.wanted.insert(knot, wanted);
        wanted
    }

    /// ln of the factor that brings the mean of what is seen, cut off at white, to the target; `None` where nothing is known.
    fn wanted_at(&self, t: Stamp, sees: &mut impl FnMut(Stamp, &mut Vec<f32>) -> bool) -> Option<f64> {
        const STEPS: u32 = 24;
        let mut seen = Vec::new();
        if !sees(t, &mut seen) {
            return None;
        }
        let light = self.light(t);
        let most = self.config.longest * self.config.most_gain;
        let (mut low, mut high) = ((0.02_f64).ln(), most.ln());
        for _ in 0..STEPS {
            let middle = 0.5 * (low + high);
            let factor = (middle.exp() * light) as f32;
            let sum: f64 = seen.iter().map(|grey| f64::from((factor * grey).min(255.0))).sum();
            if sum < self.config.target_grey * seen.len() as f64 {
                low = middle;
            } else {
                high = middle;
            }
        }
        Some(0.5 * (low + high))
    }

    /// ln of the random change at `t`.
    fn change(&self, t: Stamp) -> f64 {
        if self.config.change == 0.0 {
            return 0.0;
        }
        let (cell, within) = cell(t, self.config.change_every_s);
        let draw = |cell: i64| {
            self.config.change * self.changes.index(cell as u64).rng().sample::<f64, _>(StandardNormal)
        };
        let (last, own) = (draw(cell - 1), draw(cell));
        last + (within * 10.0).min(1.0) * (own - last)
    }

    /// Light at `t`.
    fn light(&self, t: Stamp) -> f64 {
        let LowLightConfig { share, length_s, light } = self.low_light;
        if share == 0.0 {
            return 1.0;
        }
        let (cell, within) = cell(t, length_s);
        let dark = |cell: i64| self.phases.index(cell as u64).rng().random::<f64>() < share;
        let level = |dark: bool| if dark { light.ln() } else { 0.0 };
        let (last, own) = (level(dark(cell - 1)), level(dark(cell)));
        let passed = (within * length_s / DUSK_S).min(1.0);
        (last + passed * (own - last)).exp()
    }
}

/// Which stretch of `length_s` a time lies in, and how far, 0 to 1.
fn cell(t: Stamp, length_s: f64) -> (i64, f64) {
    let length = ((length_s * 1e9) as i64).max(1);
    (t.ns().div_euclid(length), t.ns().rem_euclid(length) as f64 / length as f64)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn steady(config: ExposureConfig, low_light: LowLightConfig) -> Exposure {
        Exposure::new(config, low_light, &Stream::new(2))
    }

    fn at_ms(ms: i64) -> Stamp {
        Stamp::from_ns(1_403_715_273_000_000_000 + ms * 1_000_000)
    }

    #[test]
    fn the_mean_is_led_to_the_target_first_by_time_then_by_gain() {
        let config = ExposureConfig { change: 0.0, ..ExposureConfig::default() };
        let mut exposure = steady(config, LowLightConfig::default());
        for (grey, time, gain) in
            [(64.0_f32, 2.0, 1.0), (256.0, 0.5, 1.0), (16.0, 3.0, 128.0 / 48.0), (1.0, 3.0, 8.0)]
        {
            exposure.wanted.clear();
            let setting = exposure.at(at_ms(10), |_, seen| {
                seen.extend([grey; 100]);
                true
            });
            assert!(
                (setting.time - time).abs() < 1e-3 && (setting.gain - gain).abs() < 1e-2,
                "{grey}: {setting:?}"
            );
        }
        // What is white already does not get brighter.
        exposure.wanted.clear();
        let setting = exposure.at(at_ms(10), |_, seen| {
            seen.extend([1000.0; 30]);
            seen.extend([50.0; 70]);
            true
        });
        let mean = 0.3 * 255.0 + 0.7 * 50.0 * setting.time;
        assert!((mean - 128.0).abs() < 0.1, "{setting:?}");
    }

    #[test]
    fn it_follows_with_a_lag_without_steps_and_frames_do_not_depend_on_their_order() {
        let config = ExposureConfig { change: 0.0, ..ExposureConfig::default() };
        let mut sees = |t: Stamp, seen: &mut Vec<f32>| {
            seen.extend([if t < at_ms(1000) { 128.0 } else { 64.0 }; 4]);
            true
        };
        let mut exposure = steady(config, LowLightConfig::default());
        let times: Vec<f64> = (0..200).map(|i| exposure.at(at_ms(i * 10), &mut sees).time).collect();
        assert!((times[99] - 1.0).abs() < 1e-3 && (times[199] - 2.0).abs() < 1e-3);
        assert!(times.windows(2).all(|pair| (pair[1] - pair[0]).abs() < 0.06));
        let mut backwards = steady(config, LowLightConfig::default());
        for i in (0..200).rev() {
            assert_eq!(backwards.at(at_ms(i * 10), &mut sees).time, times[i as usize]);
        }
        // Nothing seen anywhere: as in mean light.
        assert!(
            (steady(config, LowLightConfig::default()).at(at_ms(0), |_, _| false).time - 1.0).abs() < 1e-9
        );
    }

    #[test]
    fn changes_and_dark_phases_come_as_often_and_as_strong_as_asked_for() {
        let config =
            ExposureConfig { change: 0.3, change_every_s: 1.0, longest: 100.0, ..ExposureConfig::default() };
        let low_light = LowLightConfig { share: 0.4, length_s: 1.0, light: 0.05 };
        let exposure = steady(config, low_light);
        let ends: Vec<Stamp> = (0..1000).map(|i| at_ms(i * 1000 + 990)).collect();
        let square = ends.iter().map(|t| exposure.change(*t).powi(2)).sum::<f64>() / 1000.0;
        assert!((square.sqrt() / 0.3 - 1.0).abs() < 0.1, "{square}");
        let dark = ends.iter().filter(|t| (exposure.light(**t) - 0.05).abs() < 1e-9).count();
        assert!((340..460).contains(&dark), "{dark}");
        assert!(ends.iter().all(|t| exposure.light(*t) <= 1.0));
    }
}
