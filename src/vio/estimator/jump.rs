//! Jumps of the biases: found, and allowed for in the interval in which they fell.
//!
//! A bias that walks as its data sheet says cannot follow one that jumps: held where it was, it turns into velocity, the window's poses leave the tracks and
//! these are given up as outliers; some twenty seconds later the speed is beyond belief. So each frame asks, in two steps:
//! 1. The score of a jump ([`Window::jump_score`]) in each of the last intervals, against what it usually is: truths that are wrong and vibration have
//!    their own usual.
//! 2. Where it is far beyond that, the window is solved with a jump in that interval, and with an interval that is not believed. What the jump explains beyond the latter
//!    must be far beyond chance, in units of what inertial residuals of the window are worth.
//!
//! A jump found stays as a raised walk in its interval, as large as it came out; nothing else is changed.

use crate::window::{Doubt, Window};
use dpn_core::Stamp;
use dpn_core::config::ConfigFaults;
use nalgebra::SVector;
use serde::{Deserialize, Serialize};

/// Intervals in which a jump is looked for, the newest first.
const LAGS: usize = 6;
/// Scores before a usual one is known.
const WARM_UP: usize = 20;
/// Share of the usual square that one frame renews.
const RENEWED: f64 = 0.02;
/// A score counts in the usual one as at most so many times it.
const CLIP: f64 = 9.0;
/// Expected mean square of a whitened inertial residual where the noise told is right: the states are fitted to it.
const FITTED: f64 = 0.45;

/// When a bias is held to have jumped.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct JumpConfig {
    /// Whether jumps are looked for.
    pub watch: bool,
    /// A score so many times the usual is looked into; 2 to 1000.
    pub unusual: f64,
    /// Twice the log likelihood that a jump must explain beyond one interval that is wrong, in units of the window's inertial residuals; 10 to 1e6.
    pub evidence: f64,
    /// A jump's deviation that is tried, an axis of the accelerometer \[m/s^2\].
    pub accel_std: f64,
    /// The same of the gyro \[rad/s\].
    pub gyro_std: f64,
}

impl Default for JumpConfig {
    fn default() -> Self {
        Self { watch: true, unusual: 4.0, evidence: 60.0, accel_std: 2.0, gyro_std: 0.1 }
    }
}

impl JumpConfig {
    pub(crate) fn check(&self, faults: &mut ConfigFaults) {
        faults.within("jumps.unusual", self.unusual, 2.0, 1000.0);
        faults.within("jumps.evidence", self.evidence, 10.0, 1e6);
        faults.positive("jumps.accel_std", self.accel_std);
        faults.positive("jumps.gyro_std", self.gyro_std);
    }
}

/// A jump of the biases.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct BiasJump {
    /// Between these two frames.
    pub between: [Stamp; 2],
    /// By how much the accelerometer's, as far as was known when it was found \[m/s^2\].
    pub accel: [f64; 3],
    /// By how much the gyro's \[rad/s\].
    pub gyro: [f64; 3],
}

/// What a frame's look found.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Found {
    /// Nothing out of the usual.
    Nothing,
    /// The newest interval contradicts the others; what it means is not known yet.
    Doubt,
    /// A jump; the window allows for it now.
    Jump(BiasJump),
}

/// Looks for them.
#[derive(Debug, Clone)]
pub(super) struct JumpWatch {
    config: JumpConfig,
    /// Mean squares of the scores by lag.
    usual: [SVector<f64, 6>; LAGS],
    seen: [usize; LAGS],
}

impl JumpWatch {
    pub(super) fn new(config: JumpConfig) -> Self {
        Self { config, usual: [SVector::zeros(); LAGS], seen: [0; LAGS] }
    }

    /// Looks at a window just solved, and puts another in its place where a bias has jumped.
    pub(super) fn look(&mut self, window: &mut Window) -> Found {
        if !self.config.watch {
            return Found::Nothing;
        }
        let newest = window.frames().len() - 1;
        let mut suspects = Vec::new();
        for lag in 0..LAGS.min(newest) {
            let Some(score) = window.jump_score(newest - lag) else { continue };
            if self.unusual(lag, &score) {
                suspects.push(newest - lag);
            }
        }
        if suspects.is_empty() { Found::Nothing } else { self.examine(window, &suspects) }
    }

    /// Whether a score is far beyond the usual, which it then enters.
    fn unusual(&mut self, lag: usize, score: &SVector<f64, 6>) -> bool {
        let (usual, seen) = (&mut self.usual[lag], &mut self.seen[lag]);
        let known = *seen >= WARM_UP;
        *seen += 1;
        let share = RENEWED.max(1.0 / *seen as f64);
        let mut beyond = false;
        for k in 0..6 {
            let mut square = score[k] * score[k];
            if !square.is_finite() {
                continue;
            }
            if known {
                beyond |= square > self.config.unusual.powi(2) * usual[k];
                square = square.min(CLIP * usual[k]);
            }
            usual[k] += share * (square - usual[k]);
        }
        beyond
    }

    fn examine(&self, window: &mut Window, suspects: &[usize]) -> Found {
        let wide = Doubt::Jump([self.config.accel_std, self.config.gyro_std]);
        let trials = suspects.iter().filter_map(|&j| {
            let (jumped, cost) = window.doubting(j, wide)?;
            Some((j, jumped, cost))
        });
        let Some((j, jumped, cost)) = trials.min_by(|a, b| a.2.total_cmp(&b.2)) else { return Found::Nothing };
        let Some((_, disbelieved)) = window.doubting(j, Doubt::Samples) else { return Found::Nothing };
        let unit = jumped.mean_inertial_square(j).map_or(1.0, |square| (square / FITTED).max(1.0));
        let explained = 2.0 * (disbelieved - cost) / unit;
        let change = jumped.bias_change(j);
        if std::env::var_os("DPN_JUMPS").is_some() {
            let (_, same) = window.doubting(j, Doubt::Jump([0.0; 2])).unwrap();
            eprintln!(
                "look {:?} lag {} of {suspects:?} same {same:.1} jump {cost:.1} samples {disbelieved:.1} unit {unit:.2} explained {explained:.1} a {:.3?} g {:.4?}",
                window.newest().unwrap().t,
                window.frames().len() - 1 - j,
                change.accel.as_slice(),
                change.gyro.as_slice()
            );
        }
        if explained < self.config.evidence {
            return Found::Nothing;
        }
        let size = |change: f64| 2.0 * change / 3.0f64.sqrt();
        let std = [size(change.accel.norm()), size(change.gyro.norm())];
        *window = jumped;
        window.reintegrate_after(j);
        if let Some((sized, _)) = window.doubting(j, Doubt::Jump(std)) {
            *window = sized;
        }
        let (frames, change) = (window.frames(), window.bias_change(j));
        let between = [frames[j - 1].t, frames[j].t];
        Found::Jump(BiasJump { between, accel: change.accel.into(), gyro: change.gyro.into() })
    }
}
