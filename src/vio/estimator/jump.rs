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

/// Looks for them.
#[derive(Debug, Clone)]
pub(super) struct JumpWatch {
    config: JumpConfig,
    /// Mean squares of the scores by lag.
    usual: [SVector<f64, 6>; LAGS],
    seen: [usize; LAGS],
    found: bool,
}

impl JumpWatch {
    pub(super) fn new(config: JumpConfig) -> Self {
        Self { config, usual: [SVector::zeros(); LAGS], seen: [0; LAGS], found: false }
    }

    /// Looks at a window just solved, of this cost, and puts another in its place where a bias has jumped.
    pub(super) fn look(&mut self, window: &mut Window, cost: f64) -> Option<BiasJump> {
        if !self.config.watch {
            return None;
        }
        let newest = window.frames().len() - 1;
        let mut suspects = Vec::new();
        for lag in 0..LAGS.min(newest) {
            let Some(score) = window.jump_score(newest - lag) else { continue };
            let ratio = self.ratio_to_usual(lag, &score);
            if ratio > self.config.unusual {
                suspects.push((newest - lag, ratio));
            }
        }
        let jump = self.examine(window, cost, &suspects);
        self.found |= jump.is_some();
        jump
    }

    /// How far beyond any sensor's a bias may lie since a jump was found, accelerometer \[m/s^2\] and gyro \[rad/s\].
    pub(super) fn reach(&self) -> [f64; 2] {
        let JumpConfig { accel_std, gyro_std, .. } = self.config;
        if self.found { [accel_std, gyro_std].map(|std| 3.0 * std) } else { [0.0; 2] }
    }

    /// How many times the usual a score is, in deviations of the axis on which it is most; it then enters the usual.
    fn ratio_to_usual(&mut self, lag: usize, score: &SVector<f64, 6>) -> f64 {
        let (usual, seen) = (&mut self.usual[lag], &mut self.seen[lag]);
        let known = *seen >= WARM_UP;
        *seen += 1;
        let share = RENEWED.max(1.0 / *seen as f64);
        let mut most: f64 = 0.0;
        for k in 0..6 {
            let mut square = score[k] * score[k];
            if !square.is_finite() {
                continue;
            }
            if known {
                most = most.max(square / usual[k]);
                square = square.min(CLIP * usual[k]);
            }
            usual[k] += share * (square - usual[k]);
        }
        most.sqrt()
    }

    fn examine(&self, window: &mut Window, cost: f64, suspects: &[(usize, f64)]) -> Option<BiasJump> {
        let most = suspects.iter().max_by(|a, b| a.1.total_cmp(&b.1))?.0;
        let wide = Doubt::Jump([self.config.accel_std, self.config.gyro_std]);
        let first = window.doubting(most, wide)?;
        let unit = first.0.mean_inertial_square(most).map_or(1.0, |square| (square / FITTED).max(1.0));
        let enough = |from: f64, to: f64| 2.0 * (from - to) > self.config.evidence * unit;
        if std::env::var_os("DPN_JUMPS").is_some() {
            let change = first.0.bias_change(most);
            eprintln!(
                "look {:?} suspects {suspects:.1?} D {:.1} unit {unit:.2} a {:.3?} g {:.4?}",
                window.newest().unwrap().t,
                2.0 * (cost - first.1) / unit,
                change.accel.as_slice(),
                change.gyro.as_slice()
            );
        }
        if !enough(cost, first.1) {
            return None;
        }
        let others = suspects.iter().filter(|(j, _)| *j != most);
        let others = others.filter_map(|&(j, _)| window.doubting(j, wide).map(|(jumped, cost)| (j, jumped, cost)));
        let (j, jumped, jump_cost) =
            others.chain([(most, first.0, first.1)]).min_by(|a, b| a.2.total_cmp(&b.2))?;
        let (_, disbelieved) = window.doubting(j, Doubt::Samples)?;
        let two = window.doubting2(j)?.1;
        if std::env::var_os("DPN_JUMPS").is_some() {
            eprintln!("  lag {} explained {:.1} two {:.1}", window.frames().len() - 1 - j, 2.0 * (disbelieved - jump_cost) / unit, 2.0 * (two - jump_cost) / unit);
        }
        if !enough(two, jump_cost) {
            return None;
        }
        *window = jumped;
        window.reintegrate_after(j);
        window.optimise();
        let (frames, change) = (window.frames(), window.bias_change(j));
        let between = [frames[j - 1].t, frames[j].t];
        Some(BiasJump { between, accel: change.accel.into(), gyro: change.gyro.into() })
    }
}
