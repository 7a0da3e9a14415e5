//! Jumps of the biases: found, and allowed for in the interval in which they fell.
//!
//! A bias that walks as its data sheet says cannot follow one that jumps: held where it was, what it lacks turns into velocity, the window's poses leave the tracks, these are
//! given up as outliers, and some twenty seconds later the speed is beyond belief. So each frame asks:
//! 1. The score of a jump ([`Window::jump_score`]) in each of the last intervals, against what it usually is: truths that are wrong and vibration have
//!    their own usual.
//! 2. Where it is far beyond that, the window is solved with a jump in that interval. Unless this explains far more than chance would, in units of
//!    what inertial residuals of the window are worth, nothing has happened. Nor is anything asked of a window through which the images do not reach: where
//!    all tracks were lost, a jump explains whatever the motion over that gap was estimated wrong by.
//! 3. The same is asked against a window that does not believe the interval and the next. A jump that explains far more than that too is one: its window
//!    takes the place of the old one, unless its images fit badly: a bias is no reason for that, blurred or empty images are, and they are
//!    explained by a free bias as well.
//! 4. It cannot when it fell in the last two intervals. Then its window goes on beside the old one for a few frames, with the tracks that the old one
//!    gives up meanwhile, and is asked again at each.
//!
//! A window without a jump is not touched by any of this. A jump found stays as a raised walk in its interval.

use crate::window::Window;
use dpn_core::Stamp;
use nalgebra::SVector;
use serde::Serialize;

/// Intervals in which a jump is looked for, the newest first.
const LAGS: usize = 6;
/// Scores before a usual one is known.
const WARM_UP: usize = 20;
/// Share of the usual square that one frame renews.
const RENEWED: f64 = 0.02;
/// A score counts in the usual one as at most so many times it.
const CLIP: f64 = 9.0;
/// Mean square of a whitened inertial residual where the noise told is right: the states are fitted to it.
const FITTED: f64 = 0.45;
/// Most that sightings after a jump may be off in its window, mean square in pixels as told: after 24 injected jumps, told x1 and `self`, it is .8 to
/// 2.2, in rendered phones' spans of blur and bare walls that were taken for jumps 3.1 to 5.6.
const MISFIT: f64 = 2.5;
/// Landmarks that the images must have followed through every interval of a window that is asked, one more than a relative pose needs: in V2_03 all are lost
/// five times within five seconds, and told half the noise two jumps were found right after that were none.
const FOLLOWED: usize = 6;
/// Frames for which the window of a jump goes on beside the old one.
const BESIDE: usize = 4;
/// How many times its deviation a jump may be.
const REACH: f64 = 3.0;

/// A score so many times the usual is looked into.
const UNUSUAL: f64 = 4.0;
/// Twice the log likelihood that a jump must explain beyond two intervals that are wrong, in units of the window's inertial residuals.
const EVIDENCE: f64 = 200.0;
/// Deviation of a jump, an axis of the accelerometer \[m/s^2\] and of the gyro \[rad/s\].
const JUMP_STD: [f64; 2] = [2.0, 0.1];

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

/// A window that allows for a jump.
#[derive(Debug, Clone)]
struct Jumped {
    window: Window,
    cost: f64,
    /// The frame at which the jump's interval ends.
    end: Stamp,
    frames_left: usize,
}

impl Jumped {
    /// Where the jump's interval ends in the window now; `None` once it has left.
    fn place(&self) -> Option<usize> {
        self.window.frames().iter().position(|frame| frame.t == self.end).filter(|j| *j > 0)
    }

    /// What inertial residuals of the window are worth where the noise told is too small.
    fn unit(&self) -> f64 {
        let square = self.place().and_then(|j| self.window.mean_inertial_square(j));
        square.map_or(1.0, |square| (square / FITTED).max(1.0))
    }

    /// The jump, where it explains what the next interval together with its own cannot.
    fn confirmed(&self) -> Option<BiasJump> {
        let j = self.place()?;
        let without = self.window.cost_disbelieving(j)?;
        if 2.0 * (without - self.cost) < EVIDENCE * self.unit() {
            return None;
        }
        if self.window.mean_visual_square(j).is_some_and(|square| square > MISFIT) {
            return None;
        }
        let change = self.window.bias_change(j);
        let between = [self.window.frames()[j - 1].t, self.end];
        Some(BiasJump { between, accel: change.accel.into(), gyro: change.gyro.into() })
    }
}

/// Looks for them.
#[derive(Debug, Clone, Default)]
pub(super) struct JumpWatch {
    /// Mean squares of the scores by lag.
    usual: [SVector<f64, 6>; LAGS],
    seen: [usize; LAGS],
    beside: Option<Jumped>,
    found: bool,
}

impl JumpWatch {
    /// The window that goes on beside, where there is one.
    pub(super) fn beside(&mut self) -> Option<&mut Window> {
        self.beside.as_mut().map(|jumped| &mut jumped.window)
    }

    /// Looks at a window just solved, of this cost, and at the one beside it, which the same frame was added to. Where a bias has jumped, the window that
    /// allows for it is put in the place of `window`.
    pub(super) fn look(&mut self, window: &mut Window, cost: f64) -> Option<BiasJump> {
        let newest = window.frames().len() - 1;
        let mut suspects = Vec::new();
        for lag in 0..LAGS.min(newest) {
            let Some(score) = window.jump_score(newest - lag) else { continue };
            let ratio = self.ratio_to_usual(lag, &score);
            if ratio > UNUSUAL {
                suspects.push((newest - lag, ratio));
            }
        }
        if suspects.is_empty() && self.beside.is_none() {
            return None;
        }
        if window.least_followed() < FOLLOWED {
            self.beside = None;
            return None;
        }
        let jump = self.ask_beside(window).or_else(|| {
            let jumped = self.trial(window, cost, &suspects)?;
            let jump = jumped.confirmed();
            if jump.is_some() {
                accept(jumped, window);
            } else {
                self.beside.get_or_insert(jumped);
            }
            jump
        });
        if jump.is_some() {
            self.beside = None;
            self.found = true;
        }
        jump
    }

    /// How far beyond any sensor's a bias may lie since a jump was found, accelerometer \[m/s^2\] and gyro \[rad/s\].
    pub(super) fn reach(&self) -> [f64; 2] {
        if self.found { JUMP_STD.map(|std| REACH * std) } else { [0.0; 2] }
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

    /// The window of the jump that explains most, where it explains far more than chance would.
    fn trial(&self, window: &Window, cost: f64, suspects: &[(usize, f64)]) -> Option<Jumped> {
        let jumped = |j: usize| {
            let (window, cost) = window.with_jump(j, JUMP_STD)?;
            Some(Jumped { end: window.frames()[j].t, window, cost, frames_left: BESIDE })
        };
        let most = suspects.iter().max_by(|a, b| a.1.total_cmp(&b.1))?.0;
        let first = jumped(most)?;
        if 2.0 * (cost - first.cost) < EVIDENCE * first.unit() {
            return None;
        }
        let others = suspects.iter().filter(|(j, _)| *j != most).filter_map(|(j, _)| jumped(*j));
        others.chain([first]).min_by(|a, b| a.cost.total_cmp(&b.cost))
    }

    /// Solves the window beside, if there is one, asks it, and readies it for the next frame.
    fn ask_beside(&mut self, window: &mut Window) -> Option<BiasJump> {
        let mut jumped = self.beside.take()?;
        jumped.cost = jumped.window.optimise().last_cost;
        jumped.frames_left -= 1;
        let jump = jumped.confirmed();
        if jump.is_some() {
            accept(jumped, window);
        } else if jumped.frames_left > 0 {
            jumped.window.reject_outliers();
            self.beside = Some(jumped);
        }
        jump
    }
}

/// Puts the window of a jump in the place of the old one.
fn accept(jumped: Jumped, window: &mut Window) {
    let place = jumped.place();
    *window = jumped.window;
    if let Some(j) = place {
        window.reintegrate_after(j);
        window.optimise();
    }
}
