//! Variance components: how noisy IMU and published poses are, by their own disagreement.
//!
//! Residuals come in groups of one unknown level each. With whitened residuals `r`, derivatives `A` and the covariance `P` of the unknowns,
//! ```text
//! level^2 <- level^2 * sum r^2 / (n - sum A P A')
//! ```
//! until nothing changes: the fixed point is the restricted maximum likelihood (Foerstner 1979; Koch 1986). `n - sum A P A'` is the group's redundancy:
//! what the others know of these residuals without them. An oscillation of the rotors, which every sum over an interval loses,
//! shows in few of them and counts little.
//!
//! The slow part of the published errors is a Gauss-Markov process: of the first order for rotations, whose spectrum falls as that of an integrated
//! gyro's does, and of the second order (both poles at `-1/time`) for positions, as of an accelerometer's. So far above its corner it cannot be told from the IMU's noise,
//! and below it can: a smooth error is not taken for a noisy IMU. Correlation times come from moments of the estimated errors,
//! `phi = sum E[e_k e_k+1] / sum E[e_k^2]` and `1/time^2 = sum E[e'_k^2] / sum E[e_k^2]`.

use nalgebra::Matrix2;
use serde::Serialize;

/// How many groups there are.
pub(crate) const GROUPS: usize = 8;

/// A group of residuals of one level.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Group {
    Accel = 0,
    Gyro = 1,
    AccelWalk = 2,
    GyroWalk = 3,
    Position = 4,
    Rotation = 5,
    SlowPosition = 6,
    SlowRotation = 7,
}

/// The levels.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Levels {
    /// Accelerometer, what a white noise of this deviation a sample would do over an interval \[m/s^2\].
    pub accel_sample_std: f64,
    /// Gyro, likewise \[rad/s\].
    pub gyro_sample_std: f64,
    /// Walk of the accelerometer's bias \[m/s^3/sqrt(Hz)\].
    pub accel_bias_walk: f64,
    /// Walk of the gyro's bias \[rad/s^2/sqrt(Hz)\].
    pub gyro_bias_walk: f64,
    /// Published position, the mean of those beside one key, what is new at every key, an axis \[m\].
    pub position_std: f64,
    /// Published rotation, likewise \[rad\].
    pub rotation_std: f64,
    /// Published position, the slow part, an axis \[m\].
    pub slow_position_std: f64,
    /// Published rotation, the slow part, an axis \[rad\].
    pub slow_rotation_std: f64,
    /// Correlation time of the slow part of positions \[s\].
    pub slow_position_s: f64,
    /// Correlation time of the slow part of rotations \[s\].
    pub slow_rotation_s: f64,
    /// Factors of the IMU's axes on its levels, accelerometer and gyro; 1 unless they are asked for one by one.
    #[serde(skip)]
    pub(crate) axes: [[f64; 3]; 2],
}

/// How the levels are asked for where the IMU's are what is wanted: axis by axis, with poses that may be exact.
#[derive(Debug, Clone, Copy)]
pub(crate) struct ByAxis {
    /// Whether the published errors have a slow part; without it all that it would explain is the IMU's.
    pub(crate) slow: bool,
}

/// Least and most deviation of one sample's axis, accelerometer \[m/s^2\] and gyro \[rad/s\]: no sensor is beyond.
pub(crate) const AXIS_BOUNDS: [(f64, f64); 2] = [(1e-3, 5.0), (3e-5, 0.5)];
/// The poses' least, a simulation's.
const EXACT: f64 = 1e-6;
/// No slow part at all \[m, rad\].
const NO_SLOW: f64 = 1e-6;

/// Least and most of each level: a group that says nothing of its level must stop somewhere.
/// That of the sensors is a good data sheet's, the most is what no working one has: a published trajectory that an IMU went into
/// follows it too closely, and would leave it no noise at all. No motion capture is better than .2 mm and .01 deg.
const BOUNDS: [(f64, f64); GROUPS] = [
    (0.02, 2.0),
    (1e-3, 0.2),
    (1e-4, 0.01),
    (1e-6, 3e-4),
    (2e-4, 0.1),
    (2e-4, 0.1),
    (1e-5, 0.1),
    (1e-5, 0.1),
];
/// Least and most of the correlation times \[s\].
const TIMES: (f64, f64) = (0.05, 10.0);
/// A group of fewer rows' worth of redundancy is not waited for.
const MATTERS: f64 = 30.0;
/// A level moves by no more than this factor at a time.
const FASTEST: f64 = 4.0;

impl Levels {
    /// Where the search begins: a cheap IMU beside a good motion capture.
    pub(crate) fn start() -> Self {
        Self {
            accel_sample_std: 0.1,
            gyro_sample_std: 5e-3,
            accel_bias_walk: 3e-3,
            gyro_bias_walk: 5e-5,
            position_std: 1e-3,
            rotation_std: 2e-3,
            slow_position_std: 3e-3,
            slow_rotation_std: 2e-3,
            slow_position_s: 0.5,
            slow_rotation_s: 0.5,
            axes: [[1.0; 3]; 2],
        }
    }

    /// The same with no slow part.
    pub(crate) fn without_slow(self) -> Self {
        Self { slow_position_std: NO_SLOW, slow_rotation_std: NO_SLOW, ..self }
    }

    /// Deviations of one sample by axis, accelerometer and gyro.
    pub(crate) fn sample_stds(&self) -> [[f64; 3]; 2] {
        let of = |level: f64, axes: [f64; 3]| axes.map(|axis| level * axis);
        [of(self.accel_sample_std, self.axes[0]), of(self.gyro_sample_std, self.axes[1])]
    }

    fn of(&mut self, group: usize) -> &mut f64 {
        match group {
            0 => &mut self.accel_sample_std,
            1 => &mut self.gyro_sample_std,
            2 => &mut self.accel_bias_walk,
            3 => &mut self.gyro_bias_walk,
            4 => &mut self.position_std,
            5 => &mut self.rotation_std,
            6 => &mut self.slow_position_std,
            _ => &mut self.slow_rotation_std,
        }
    }

    /// The levels by what was found with these, and the largest change of any, as a factor minus 1. `ceilings` are the most that
    /// accelerometer and gyro may have where they are one level each; `pace` remembers how each level went before.
    pub(crate) fn updated(
        &self,
        found: &Found,
        ceilings: [f64; 2],
        by_axis: Option<ByAxis>,
        pace: &mut Pace,
    ) -> (Self, f64) {
        let mut next = *self;
        let mut change = 0.0_f64;
        let slow = by_axis.is_none_or(|how| how.slow);
        for (group, (low, high)) in BOUNDS.into_iter().enumerate() {
            if (by_axis.is_some() && group < 2) || (!slow && group >= Group::SlowPosition as usize) {
                continue;
            }
            let low =
                if by_axis.is_some() && group >= Group::Position as usize { low.min(EXACT) } else { low };
            let high = ceilings.get(group).map_or(high, |ceiling| high.min(ceiling.max(low)));
            let redundancy = found.rows[group] - found.leverage[group];
            // Fewer than a row's worth of redundancy says nothing.
            if redundancy < 1.0 {
                continue;
            }
            let factor =
                pace.hurried(group, (found.squares[group] / redundancy).sqrt()).clamp(1.0 / FASTEST, FASTEST);
            let level = next.of(group);
            let before = *level;
            *level = (before * factor).clamp(low, high);
            // A level that hardly anything hangs on may go on changing.
            if redundancy > MATTERS {
                change = change.max((*level / before).max(before / *level) - 1.0);
            }
        }
        if by_axis.is_some() {
            let levels = [self.accel_sample_std, self.gyro_sample_std];
            for (place, axis) in (0..6).map(|i| (GROUPS + i, (i / 3, i % 3))) {
                let [squares, redundancy, _] = found.axes[axis.0][axis.1];
                if redundancy < 1.0 {
                    continue;
                }
                let ((low, high), level) = (AXIS_BOUNDS[axis.0], levels[axis.0]);
                let before = self.axes[axis.0][axis.1];
                let factor = pace.hurried(place, (squares / redundancy).sqrt()).clamp(1.0 / FASTEST, FASTEST);
                let after = (level * before * factor).clamp(low, high) / level;
                next.axes[axis.0][axis.1] = after;
                if redundancy > MATTERS {
                    change = change.max((after / before).max(before / after) - 1.0);
                }
            }
        }
        if !slow {
            return (next, change);
        }
        let [rates, own] = found.position_moments;
        if rates > 0.0 {
            next.slow_position_s = (own / rates).sqrt().clamp(TIMES.0, TIMES.1);
        }
        let [cross, own] = found.rotation_moments;
        let phi = cross / own;
        if phi > 0.0 && phi < 1.0 {
            next.slow_rotation_s = (-found.interval_s / phi.ln()).clamp(TIMES.0, TIMES.1);
        }
        (next, change)
    }

    /// The share of a rotation's slow error that is left after `interval_s`.
    pub(crate) fn persistence(&self, interval_s: f64) -> f64 {
        (-interval_s / self.slow_rotation_s).exp()
    }

    /// How a position's slow error and its rate go on over `interval_s`, and the inverse of the root of what is new in them.
    pub(crate) fn position_course(&self, interval_s: f64) -> (Matrix2<f64>, Matrix2<f64>) {
        let corner = 1.0 / self.slow_position_s;
        let x = corner * interval_s;
        let next = Matrix2::new(1.0 + x, interval_s, -corner * x, 1.0 - x) * (-x).exp();
        let stationary = Matrix2::new(1.0, 0.0, 0.0, corner * corner) * self.slow_position_std.powi(2);
        let new = stationary - next * stationary * next.transpose();
        let root =
            new.cholesky().expect("an interval is no less than a thousandth of the correlation time").l();
        let inverse = root.try_inverse().expect("a Cholesky factor has an inverse");
        (next, inverse)
    }
}

/// How fast each level goes: a fixed point that is neared from one side in ever the same small steps is stepped towards in larger ones.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Pace {
    /// The last step of each level, as a logarithm; those of the IMU's axes behind the groups'.
    last: [f64; GROUPS + 6],
    /// What it was multiplied with.
    power: [f64; GROUPS + 6],
}

impl Pace {
    /// The most that a step is multiplied with.
    const MOST: f64 = 8.0;

    fn hurried(&mut self, group: usize, factor: f64) -> f64 {
        let step = factor.ln();
        let power = &mut self.power[group];
        *power = if step * self.last[group] > 0.0 { (*power * 1.5).clamp(1.0, Self::MOST) } else { 1.0 };
        self.last[group] = step;
        (step * *power).exp()
    }
}

/// What one adjustment says of its levels.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Found {
    /// Rows of each group.
    pub(crate) rows: [f64; GROUPS],
    /// Sum of their squared whitened residuals.
    pub(crate) squares: [f64; GROUPS],
    /// Sum of their shares in the estimate.
    pub(crate) leverage: [f64; GROUPS],
    /// `sum E[e'_k^2]` and `sum E[e_k^2]` of the slow position error.
    pub(crate) position_moments: [f64; 2],
    /// `sum E[e_k e_k+1]` and `sum E[e_k^2]` of the slow rotation error.
    pub(crate) rotation_moments: [f64; 2],
    /// Between two keys \[s\].
    pub(crate) interval_s: f64,
    /// Squares, redundancy and rows of accelerometer and gyro by axis.
    pub(crate) axes: [[[f64; 3]; 3]; 2],
}

impl Found {
    /// A row of a sensor's axis.
    pub(crate) fn add_axis(&mut self, sensor: usize, axis: usize, square: f64, leverage: f64) {
        for (sum, add) in self.axes[sensor][axis].iter_mut().zip([square, 1.0 - leverage, 1.0]) {
            *sum += add;
        }
    }

    /// One row.
    pub(crate) fn add(&mut self, group: Group, square: f64, leverage: f64) {
        self.rows[group as usize] += 1.0;
        self.squares[group as usize] += square;
        self.leverage[group as usize] += leverage;
    }
}
