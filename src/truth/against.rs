//! An IMU's noise, biases, scale and misalignment against a trajectory of the same body: from motion capture, or anybody's odometry.
//!
//! 1. Clocks that are apart are brought together, and a trajectory that is not in metres is refused (`metric`).
//! 2. Scale and misalignment are asked for beside a rough adjustment (`intrinsics`), taken out of the samples where they are told from chance, and all is adjusted anew.
//! 3. The IMU's white levels axis by axis, as if the trajectory's errors were white, so that all the rest is the IMU's. Where the restricted likelihood wants a slow part of the trajectory's
//!    own, which over an interval looks as the IMU's noise does, the lower end is what is left with it, or the signal's own floor; where that is far away, a bound is all that is known.
//!
//! A level is a restricted maximum likelihood. A trajectory that was made from this IMU holds its noise: from pose to pose it turns as the
//! gyroscope does to less than the gyroscope's own noise, and then its levels are known from below alone.

use crate::adjust::{Adjusted, adjust};
use crate::align::{clock_offset, guess};
use crate::ceiling::floors;
use crate::components::{AXIS_BOUNDS, ByAxis};
use crate::config::TruthConfig;
use crate::dense::deviations;
use crate::error::TruthError;
use crate::intrinsics::{Intrinsics, PRIOR};
use crate::layout::KEY_DIM;
use crate::metric::scale;
use crate::problem::{Estimate, Problem, Role};
use crate::reconcile::{LEAST, MOST_ROUNDS, Settled, settle};
use crate::report::{Estimated, Report, report};
use dpn_core::noise::Interval;
use dpn_core::signal::stats::median;
use dpn_core::trajectory::StampedPose;
use dpn_core::{ImuRecording, Sensor, Stamp};
use dpn_vio::state::{ACCEL_BIAS, GYRO_BIAS};
use nalgebra::{SMatrix, Vector3};
use serde::Serialize;

/// A figure so near a bound is at it.
const AT_BOUND: f64 = 1.03;
/// Walks that a figure is found between: those of the reconciliation.
const WALKS: [(f64, f64); 2] = [(1e-4, 0.01), (1e-6, 3e-4)];
/// A trajectory that is larger or smaller by more than this is not in metres.
const METRIC: f64 = 0.1;
/// Scale or misalignment is told from chance beyond this many deviations.
const BEYOND: f64 = 4.0;
/// Of the prior's deviation: what stays above is not known.
const LEARNED: f64 = 0.5;
/// Iterations of the first, rough adjustment.
const ROUGH: usize = 15;
/// From pose to pose, of what the gyroscope's noise would make of it: below this a trajectory follows the gyroscope.
const FOLLOWS: f64 = 0.5;
/// The slow part's four numbers are needed where they gain more than chance does (99.9 %), twice the logarithm of the likelihood.
const GAINS: f64 = 18.5;
/// Steps between poses that this is asked of.
const LEAST_STEPS: usize = 100;
/// What an interval adds to one pose's noise, beyond which poses are not averaged over it.
const EXACT: f64 = 0.3;

/// What a figure is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Known {
    /// A figure with its interval.
    Figure,
    /// The upper end alone: the trajectory's own errors may be all of it.
    AtMost,
    /// The lower end alone: the trajectory follows this IMU.
    AtLeast,
}

/// A level of the IMU.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Found {
    /// As a density.
    pub density: Interval,
    /// Figure or bound.
    pub known: Known,
}

/// One sensor.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SensorAgainst {
    /// The sensor.
    pub sensor: Sensor,
    /// White noise, x, y, z.
    pub white: [Found; 3],
    /// Walk of the bias, one for all axes.
    pub walk: Found,
    /// Mean bias over the log and the mean deviation that one instant's is known by, in the sensor's unit.
    pub bias: Estimated<[f64; 3]>,
    /// Scale less 1, x, y, z, and deviations; none of an axis whose motion does not tell.
    pub scale: [Option<Estimated<f64>>; 3],
    /// Rows of the misalignment: what of the other two axes' readings is in each, by column y z, x z, x y; none where it is not told. An accelerometer's is lower triangular.
    pub misalignment: [[Option<Estimated<f64>>; 2]; 3],
}

/// Biases at an instant, with deviations.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct BiasAt {
    /// When.
    pub t: Stamp,
    /// Accelerometer, gyroscope.
    pub bias: [[f64; 3]; 2],
    /// Their deviations.
    pub std: [[f64; 3]; 2],
}

/// What a trajectory says of an IMU.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Against {
    /// Seconds of samples that poses lie beside.
    pub seconds: f64,
    /// The trajectory's clock is ahead of the samples' by this \[s\], beyond the delay of the report; 0 where both are one.
    pub clock_s: f64,
    /// Whether the trajectory was made from this IMU.
    pub follows: bool,
    /// Accelerometer, gyroscope.
    pub sensors: [SensorAgainst; 2],
    /// About a row a second.
    #[serde(skip)]
    pub biases: Vec<BiasAt>,
    /// Delay, frames, and how good the trajectory is.
    pub report: Report,
}

/// Holds `recording` against a trajectory in metres, of any frame.
///
/// # Errors
/// Too little of either; no common motion; what is no gravity; a trajectory that is not in metres.
pub fn against(recording: &ImuRecording, poses: &[StampedPose]) -> Result<Against, TruthError> {
    // Nothing is written here that would have to be known so well.
    let config = &TruthConfig { position_limit_m: 1.0, rotation_limit_deg: 10.0, ..TruthConfig::default() };
    let (samples, rate) = (recording.samples(), recording.rate());
    if poses.len() < LEAST || samples.len() < LEAST {
        return Err(TruthError::TooShort { poses: poses.len(), samples: samples.len(), least: LEAST });
    }
    let mut poses = poses.to_vec();
    let mut clock_s = 0.0;
    let frames = match guess(samples, &poses, config) {
        Err(apart @ (TruthError::NoOverlap { .. } | TruthError::RatesDisagree { .. })) => {
            clock_s = clock_offset(samples, &poses, config.longest_gap_s).ok_or(apart)?;
            poses.iter_mut().for_each(|pose| pose.t = pose.t.plus_seconds(-clock_s));
            guess(samples, &poses, config)?.frames
        }
        guessed => guessed?.frames,
    };
    if let Some(scale) = scale(samples, &poses, &frames, config).filter(|s| (s - 1.0).abs() > METRIC) {
        return Err(TruthError::NotMetric { scale });
    }
    let rough = settle(samples, rate, &poses, &TruthConfig { most_iterations: ROUGH, ..*config }, 0)?;
    let none = Intrinsics::none();
    let first = Intrinsics::found(&rough.problem, &rough.adjusted, &none).filter(is_told).unwrap_or(none);
    let corrected = first.taken_out_of(samples);

    let Settled { mut problem, adjusted, guessed, left_out } =
        settle(&corrected, rate, &poses, config, MOST_ROUNDS)?;
    let iterations = config.most_iterations;
    problem.by_axis = Some(ByAxis { slow: false });
    let whole = without_slow(&adjusted.estimate);
    let mut all = adjust(&problem, whole, adjusted.levels.without_slow(), iterations)?;
    if poses_are_exact(&problem, &all, rate.period()) {
        problem.leave_nearest(&all.estimate);
        all = adjust(&problem, all.estimate, all.levels, iterations)?;
    }
    let intrinsics = Intrinsics::found(&problem, &all, &first).unwrap_or(first);
    problem.by_axis = Some(ByAxis { slow: true });
    let slow = adjust(&problem, adjusted.estimate, adjusted.levels, iterations)?;
    let unlikely = |of: &Adjusted| problem.unlikelihood(&of.estimate, &of.levels);
    let gain = unlikely(&all).zip(unlikely(&slow)).map_or(f64::INFINITY, |(all, slow)| all - slow);
    let quiet = Sensor::ALL.map(|sensor| floors(samples, rate, sensor).unwrap_or([f64::INFINITY; 3]));
    let follows = follows(&problem, &all.estimate, median(&quiet[1]), rate.period());
    let levels = Level {
        all: &all,
        least: (gain > GAINS).then_some((&slow, quiet)),
        follows,
        period_s: rate.period(),
    };
    let sensors = Sensor::ALL.map(|sensor| of_sensor(sensor, &levels, &intrinsics));
    let report = report(&problem, &all, &guessed, &deviations(&all.covariance), &left_out, config);
    let biases = biases(&problem, &all);
    let seconds = problem.samples[problem.samples.len() - 1].t.seconds_since(problem.samples[0].t);
    Ok(Against { seconds, clock_s, follows, sensors, biases, report })
}

/// The estimate with no slow errors.
fn without_slow(estimate: &Estimate) -> Estimate {
    let mut estimate = estimate.clone();
    for key in &mut estimate.keys {
        (key.position_error, key.rotation_error, key.error_rate) = Default::default();
    }
    estimate
}

/// Whether any number of them is told from chance.
fn is_told(found: &Intrinsics) -> bool {
    let beyond = |i: usize| {
        let all = found.value[i].iter().zip(&found.std[i]);
        all.into_iter().any(|(v, std)| *std > 0.0 && v.abs() > BEYOND * std)
    };
    beyond(0) || beyond(1)
}

/// Whether what the IMU's noise does between a pose and its key would be felt beside one pose's own.
fn poses_are_exact(problem: &Problem<'_>, adjusted: &Adjusted, period_s: f64) -> bool {
    let (levels, half_s) = (&adjusted.levels, 0.5 * problem.interval_s);
    let used = problem.published.iter().filter(|p| p.role == Role::Used).count();
    let beside = (used as f64 / adjusted.estimate.keys.len() as f64).max(1.0).sqrt();
    let [accel, gyro] = levels.sample_stds().map(|axes| median(&axes) * period_s.sqrt());
    gyro * half_s.sqrt() > EXACT * beside * levels.rotation_std
        || accel * (half_s.powi(3) / 3.0).sqrt() > EXACT * beside * levels.position_std
}

/// Whether most steps from pose to pose turn as the gyroscope does, to less than white noise of `floor` a sample would let them; by the delay that was found, or on the
/// IMU's own stamps.
fn follows(problem: &Problem<'_>, estimate: &Estimate, floor: f64, period_s: f64) -> bool {
    let mut on_stamps = estimate.clone();
    on_stamps.frames.delay_s = 0.0;
    [estimate, &on_stamps].into_iter().any(|estimate| steps_follow(problem, estimate, floor, period_s))
}

fn steps_follow(problem: &Problem<'_>, estimate: &Estimate, floor: f64, period_s: f64) -> bool {
    let terms = problem.terms(estimate);
    let mut shares = Vec::new();
    for (poses, terms) in problem.published.windows(3).zip(terms.windows(3)) {
        if terms[0].0 != terms[2].0 || poses.iter().any(|pose| pose.role == Role::LeftOut) {
            continue;
        }
        // A step less the one before it: no bias is in that. By the mid-point rule the samples at both ends count half.
        let [before, here, after] = [0, 1, 2].map(|i| terms[i].1.residual.fixed_rows::<3>(3).into_owned());
        let off: Vector3<f64> = after - 2.0 * here + before;
        let steps = poses[2].pose.t.seconds_since(poses[0].pose.t) / period_s;
        let expected = floor * period_s * (steps - 1.5).max(0.25).sqrt();
        shares.extend(off.iter().map(|off| off.abs() / expected));
    }
    /// A normal deviation over the median of distances.
    const OF_MEDIAN: f64 = 1.4826;
    shares.len() >= 3 * LEAST_STEPS && OF_MEDIAN * median(&shares) < FOLLOWS
}

/// Both adjustments that levels are read off.
struct Level<'a> {
    all: &'a Adjusted,
    /// Where a slow part is needed, the adjustment with it and where the signal is quietest.
    least: Option<(&'a Adjusted, [[f64; 3]; 2])>,
    follows: bool,
    period_s: f64,
}

impl Level<'_> {
    fn white(&self, i: usize, axis: usize) -> Found {
        let of = |adjusted: &Adjusted| {
            let density = adjusted.levels.sample_stds()[i][axis] * self.period_s.sqrt();
            let [_, redundancy, rows] = adjusted.found.axes[i][axis];
            of_redundancy(density, redundancy, rows)
        };
        let all = of(self.all);
        let least = self
            .least
            .map_or(all.low, |(slow, quiet)| of(slow).low.min(quiet[i][axis] * self.period_s.sqrt()));
        let density = Interval { low: all.low.min(least), ..all };
        let (low, high) = AXIS_BOUNDS[i];
        let sample = all.value / self.period_s.sqrt();
        Found { density, known: known(sample, (low, high), &density, self.follows) }
    }

    fn walk(&self, i: usize) -> Found {
        let Adjusted { levels, found, .. } = self.all;
        let group = 2 + i;
        let value = [levels.accel_bias_walk, levels.gyro_bias_walk][i];
        let density = of_redundancy(value, found.rows[group] - found.leverage[group], found.rows[group]);
        Found { density, known: known(value, WALKS[i], &density, false) }
    }
}

/// What a level is that was looked for within bounds.
fn known(value: f64, (low, high): (f64, f64), density: &Interval, holds_noise: bool) -> Known {
    if holds_noise || value * AT_BOUND > high {
        Known::AtLeast
    } else if value < AT_BOUND * low || density.width() > Interval::WIDEST {
        Known::AtMost
    } else {
        Known::Figure
    }
}

/// A level and how well so many rows' worth of redundancy know it. With the share `l` of each frequency that is the level's own, the redundancy is the sum of `l`, what is known of it twice the
/// sum of `l^2`: all where the others are exact, and about half where all but the slowest is theirs.
fn of_redundancy(value: f64, redundancy: f64, rows: f64) -> Interval {
    let share = 0.5 * (1.0 + redundancy / rows);
    Interval::of_log(value, (2.0 * share * redundancy.max(0.5)).sqrt().recip())
}

fn of_sensor(sensor: Sensor, levels: &Level<'_>, intrinsics: &Intrinsics) -> SensorAgainst {
    let i = usize::from(sensor == Sensor::Gyro);
    let (keys, covariance) = (&levels.all.estimate.keys, &levels.all.covariance.keys);
    let at = [ACCEL_BIAS, GYRO_BIAS][i];
    let mean = |of: &dyn Fn(usize) -> f64| (0..keys.len()).map(of).sum::<f64>() / keys.len() as f64;
    let bias = [0, 1, 2].map(|axis| {
        let value = |k: usize| [keys[k].state.bias.accel, keys[k].state.bias.gyro][i][axis];
        let variance = |k: usize| covariance[k][(at + axis, at + axis)];
        (mean(&value), mean(&variance).max(0.0).sqrt())
    });
    let told = |row: usize, column: usize| {
        let std = intrinsics.std[i][(row, column)];
        (std > 0.0 && std < LEARNED * PRIOR)
            .then(|| Estimated { value: intrinsics.value[i][(row, column)], std })
    };
    SensorAgainst {
        sensor,
        white: [0, 1, 2].map(|axis| levels.white(i, axis)),
        walk: levels.walk(i),
        bias: Estimated { value: bias.map(|b| b.0), std: bias.map(|b| b.1) },
        scale: [told(0, 0), told(1, 1), told(2, 2)],
        misalignment: [[told(0, 1), told(0, 2)], [told(1, 0), told(1, 2)], [told(2, 0), told(2, 1)]],
    }
}

/// About a row a second.
fn biases(problem: &Problem<'_>, adjusted: &Adjusted) -> Vec<BiasAt> {
    let every = (1.0 / problem.interval_s).round().max(1.0) as usize;
    let keys = adjusted.estimate.keys.iter().zip(&adjusted.covariance.keys);
    let std = |block: &SMatrix<f64, KEY_DIM, KEY_DIM>, at: usize| {
        [0, 1, 2].map(|axis| block[(at + axis, at + axis)].max(0.0).sqrt())
    };
    keys.step_by(every)
        .map(|(key, block)| BiasAt {
            t: problem.samples[key.sample].t,
            bias: [key.state.bias.accel.into(), key.state.bias.gyro.into()],
            std: [std(block, ACCEL_BIAS), std(block, GYRO_BIAS)],
        })
        .collect()
}
