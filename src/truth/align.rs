//! A first guess of clock and frames, from turning alone: how late the published poses are, how their body is mounted, where up is.
//!
//! The delay is the one at which the published and the gyro's absolute rates agree best; the mount then takes one rate to the other
//! (Kabsch); up is where the accelerometer points on average, through the published attitude.

use crate::config::TruthConfig;
use crate::error::TruthError;
use crate::layout::Frames;
use dpn_core::geometry::nearest::nearest_orthogonal;
use dpn_core::geometry::so3;
use dpn_core::trajectory::StampedPose;
use dpn_core::{GRAVITY, ImuSample, Stamp};
use nalgebra::{Matrix3, UnitQuaternion, Vector3};

/// Steps of the grid on which rates are compared \[s\].
const GRID_S: f64 = 0.01;
/// Rates are means over this \[s\].
const MEAN_S: f64 = 0.05;
/// Where the body turns less than this \[rad/s, root mean square\], nothing can be said of clock and mount.
const LEAST_TURNING: f64 = 0.05;
/// Where it turns less than this, rates that do not agree may be noise \[rad/s\].
const SURE_TURNING: f64 = 0.2;
/// Rates that agree less than this are not of one body.
const LEAST_CORRELATION: f64 = 0.6;

/// The guess.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Guess {
    /// Clock and frames.
    pub(crate) frames: Frames,
    /// How well both rates agree there, 1 at best; `None` where the body hardly turns.
    pub(crate) correlation: Option<f64>,
}

/// Rotation vectors over [`MEAN_S`] around the instants of a grid, divided by it; none in gaps.
struct Rates {
    first: Stamp,
    values: Vec<Option<Vector3<f64>>>,
}

/// Of the published poses, in their body's frame.
fn published_rates(poses: &[StampedPose], longest_gap_s: f64) -> Rates {
    let (first, last) = (poses[0].t, poses[poses.len() - 1].t);
    let count = (last.seconds_since(first) / GRID_S) as usize;
    let at = |t: Stamp| interpolated(poses, t, longest_gap_s);
    let rate = |i: usize| {
        let t = first.plus_seconds(GRID_S * i as f64);
        let (a, b) = (at(t.plus_seconds(-0.5 * MEAN_S))?, at(t.plus_seconds(0.5 * MEAN_S))?);
        Some(so3::log(&(a.rotation.inverse() * b.rotation)) / MEAN_S)
    };
    Rates { first, values: (0..count).map(rate).collect() }
}

/// A pose between two that are no farther apart than `longest_gap_s`; linear.
pub fn interpolated(poses: &[StampedPose], t: Stamp, longest_gap_s: f64) -> Option<nalgebra::Isometry3<f64>> {
    let after = poses.partition_point(|pose| pose.t <= t);
    let a = poses.get(after.checked_sub(1)?)?;
    let Some(b) = poses.get(after) else { return (a.t == t).then_some(a.world_from_body) };
    let step = b.t.seconds_since(a.t);
    let share = t.seconds_since(a.t) / step;
    let turn = so3::log(&(a.world_from_body.rotation.inverse() * b.world_from_body.rotation));
    let (from, to) = (a.world_from_body.translation.vector, b.world_from_body.translation.vector);
    (step <= longest_gap_s).then(|| {
        nalgebra::Isometry3::from_parts(
            (from + (to - from) * share).into(),
            a.world_from_body.rotation * so3::exp(&(turn * share)),
        )
    })
}

/// The gyro's running sum, to take means from.
struct GyroSum<'a> {
    samples: &'a [ImuSample],
    sums: Vec<Vector3<f64>>,
}

impl<'a> GyroSum<'a> {
    fn new(samples: &'a [ImuSample]) -> Self {
        let mut sum = Vector3::zeros();
        let mut sums = vec![sum];
        for sample in samples {
            sum += Vector3::from(sample.gyro);
            sums.push(sum);
        }
        Self { samples, sums }
    }

    /// The mean over [`MEAN_S`] around `t`.
    fn mean(&self, t: Stamp) -> Option<Vector3<f64>> {
        let at = |seconds| self.samples.partition_point(|s| s.t < t.plus_seconds(seconds));
        let (from, to) = (at(-0.5 * MEAN_S), at(0.5 * MEAN_S));
        (to > from && from > 0).then(|| (self.sums[to] - self.sums[from]) / (to - from) as f64)
    }
}

/// How much later the poses' clock is than the samples', whatever it is: the shift at which absolute rates agree best, to a tenth of a second, where one is clearly the best.
pub(crate) fn clock_offset(samples: &[ImuSample], poses: &[StampedPose], longest_gap_s: f64) -> Option<f64> {
    /// Of the grid's steps, one is compared.
    const EVERY: usize = 10;
    /// Steps that both must have in common.
    const LEAST: usize = 100;
    /// The best correlates by this, no other than its neighbours by as much less.
    const CLEAR: (f64, f64) = (0.8, 0.15);
    /// Neighbours of the best.
    const NEAR: i64 = 20;
    let (first, last) = (samples.first()?.t, samples.last()?.t);
    let published = published_rates(poses, longest_gap_s);
    let step_s = GRID_S * EVERY as f64;
    let gyro = GyroSum::new(samples);
    let ours: Vec<Option<f64>> = (0..(last.seconds_since(first) / step_s) as usize)
        .map(|i| Some(gyro.mean(first.plus_seconds(step_s * i as f64))?.norm()))
        .collect();
    let theirs: Vec<Option<f64>> =
        published.values.iter().step_by(EVERY).map(|rate| rate.map(|r| r.norm())).collect();
    let at = |lag: i64| {
        let (mut n, mut sums) = (0, [0.0; 5]);
        let from = usize::try_from(-lag).unwrap_or(0);
        let beside = theirs.get(usize::try_from(lag).unwrap_or(0)..).unwrap_or_default();
        for (a, b) in ours.iter().skip(from).zip(beside).filter_map(|(a, b)| a.zip(*b)) {
            n += 1;
            for (sum, add) in sums.iter_mut().zip([a, b, a * a, a * b, b * b]) {
                *sum += add;
            }
        }
        let [a, b, aa, ab, bb] = sums.map(|sum| sum / n as f64);
        (n >= LEAST).then(|| (ab - a * b) / ((aa - a * a) * (bb - b * b)).sqrt())
    };
    let lags = -(ours.len() as i64)..theirs.len() as i64;
    let all: Vec<(i64, f64)> = lags.filter_map(|lag| Some((lag, at(lag)?))).collect();
    let best = all.iter().copied().max_by(|a, b| a.1.total_cmp(&b.1))?;
    let is_other = |(lag, value): &(i64, f64)| (lag - best.0).abs() > NEAR && *value > best.1 - CLEAR.1;
    (best.1 > CLEAR.0 && !all.iter().any(is_other))
        .then(|| published.first.seconds_since(first) + step_s * best.0 as f64)
}

/// Pairs of rates (gyro's, published) with the published clock taken to be late by `delay_s`.
fn pairs(gyro: &GyroSum<'_>, published: &Rates, delay_s: f64) -> Vec<(Vector3<f64>, Vector3<f64>)> {
    let pair = |(i, rate): (usize, &Option<Vector3<f64>>)| {
        let t = published.first.plus_seconds(GRID_S * i as f64 - delay_s);
        Some((gyro.mean(t)?, (*rate)?))
    };
    published.values.iter().enumerate().filter_map(pair).collect()
}

/// Pearson's correlation of the absolute rates.
fn correlation(pairs: &[(Vector3<f64>, Vector3<f64>)]) -> f64 {
    let n = pairs.len() as f64;
    let norms = || pairs.iter().map(|(a, b)| (a.norm(), b.norm()));
    let (sum_a, sum_b) = norms().fold((0.0, 0.0), |(a, b), (x, y)| (a + x, b + y));
    let (mean_a, mean_b) = (sum_a / n, sum_b / n);
    let moments = norms().fold([0.0; 3], |[aa, ab, bb], (a, b)| {
        let (a, b) = (a - mean_a, b - mean_b);
        [aa + a * a, ab + a * b, bb + b * b]
    });
    if moments[0] > 0.0 && moments[2] > 0.0 { moments[1] / (moments[0] * moments[2]).sqrt() } else { 0.0 }
}

/// One of two vectors: turning or shift, of position or of rotation.
pub(crate) type PartOf = fn(&(Vector3<f64>, Vector3<f64>)) -> Vector3<f64>;

/// The first guess.
///
/// # Errors
/// Rates that agree nowhere; turning that agrees in size and not in direction; an accelerometer that does not read gravity.
pub(crate) fn guess(
    samples: &[ImuSample],
    poses: &[StampedPose],
    config: &TruthConfig,
) -> Result<Guess, TruthError> {
    let published = published_rates(poses, config.longest_gap_s);
    let gyro = GyroSum::new(samples);
    let here = pairs(&gyro, &published, 0.0);
    let square = |v: &Vector3<f64>| v.norm_squared();
    let rms =
        |part: PartOf| (here.iter().map(|p| square(&part(p))).sum::<f64>() / here.len().max(1) as f64).sqrt();
    let mut frames = Frames::identity();
    let mut found = None;
    if !here.is_empty() && rms(|p| p.0) > LEAST_TURNING {
        let steps = (config.longest_delay_s / GRID_S).round() as i64;
        let of = |i: i64| correlation(&pairs(&gyro, &published, GRID_S * i as f64));
        let (best, value) = (-steps..=steps)
            .map(|i| (i, of(i)))
            .fold((0, f64::MIN), |best, next| if next.1 > best.1 { next } else { best });
        let sure = rms(|p| p.0) > SURE_TURNING;
        if sure && value < LEAST_CORRELATION {
            return Err(TruthError::RatesDisagree {
                correlation: value,
                longest_delay_s: config.longest_delay_s,
            });
        }
        // The top of the parabola through the best and its neighbours.
        let (before, after) = (of(best - 1), of(best + 1));
        let bend = before - 2.0 * value + after;
        let shift = if bend < 0.0 { 0.5 * (before - after) / bend } else { 0.0 };
        let delay_s = GRID_S * (best as f64 + shift.clamp(-1.0, 1.0));
        match mount(&pairs(&gyro, &published, delay_s)) {
            Ok(mount) => {
                (frames.delay_s, frames.body_from_published_body) = (delay_s, mount);
                found = Some(value);
            }
            Err(_) if !sure => {}
            Err(error) => return Err(error),
        }
    }
    let tilt = up(samples, poses, &frames, config)?;
    frames.published_world_from_world = tilt;
    Ok(Guess { frames, correlation: found })
}

/// The rotation that takes published rates to the gyro's, offsets apart.
fn mount(pairs: &[(Vector3<f64>, Vector3<f64>)]) -> Result<UnitQuaternion<f64>, TruthError> {
    let n = pairs.len() as f64;
    let sums = pairs.iter().fold((Vector3::zeros(), Vector3::zeros()), |(a, b), p| (a + p.0, b + p.1));
    let means = (sums.0 / n, sums.1 / n);
    let mut cross = Matrix3::zeros();
    for (gyro, published) in pairs {
        cross += (gyro - means.0) * (published - means.1).transpose();
    }
    let rotation = UnitQuaternion::from_rotation_matrix(&nearest_orthogonal(&cross).0);
    // A correlation: noise of the published attitude makes its rates larger than the gyro's, and no worse a guide.
    let (mut along, mut squares) = (0.0, (0.0, 0.0));
    for (gyro, published) in pairs {
        let (gyro, published) = (gyro - means.0, rotation * (published - means.1));
        along += gyro.dot(&published);
        squares.0 += gyro.norm_squared();
        squares.1 += published.norm_squared();
    }
    let correlation = if along > 0.0 { along / (squares.0 * squares.1).sqrt() } else { 0.0 };
    if correlation < LEAST_CORRELATION {
        return Err(TruthError::AxesDisagree { share: correlation * correlation });
    }
    Ok(rotation)
}

/// `published_world_from_world`: where the mean specific force points in the published world.
fn up(
    samples: &[ImuSample],
    poses: &[StampedPose],
    frames: &Frames,
    config: &TruthConfig,
) -> Result<UnitQuaternion<f64>, TruthError> {
    let (mut sum, mut count) = (Vector3::zeros(), 0.0);
    for sample in samples {
        let t = sample.t.plus_seconds(frames.delay_s);
        if let Some(pose) = interpolated(poses, t, config.longest_gap_s) {
            sum += pose.rotation * frames.body_from_published_body.inverse() * Vector3::from(sample.accel);
            count += 1.0;
        }
    }
    if count == 0.0 {
        return Err(TruthError::no_overlap(poses, samples));
    }
    let mean: Vector3<f64> = sum / count;
    if (mean.norm() / GRAVITY - 1.0).abs() > 0.1 {
        return Err(TruthError::NotGravity { found: mean.norm() });
    }
    // Straight down has no shortest way up; half a turn about x is one.
    Ok(UnitQuaternion::rotation_between(&Vector3::z(), &mean)
        .unwrap_or_else(|| UnitQuaternion::from_scaled_axis(Vector3::x() * std::f64::consts::PI)))
}
