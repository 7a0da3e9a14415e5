//! The adjustment: keys along the IMU's samples, tied to each other by pre-integrated samples and to the published poses beside them.

use crate::chain::{Chain, ChainCovariance};
use crate::components::{ByAxis, Found, Group, Levels};
use crate::layout::{
    BLUR, CONSTANTS, DELAY, ERROR_RATE, Frames, KEY_DIM, Key, LEVER, MOUNT, POSITION_ERROR, ROTATION_ERROR,
    TILT,
};
use crate::near::Near;
use crate::published::{Bend, POSE_ROWS, PoseTerm, pose_term};
use dpn_core::geometry::so3;
use dpn_core::noise::units::BadNoise;
use dpn_core::noise::{AccelBiasWalkDensity, GyroBiasWalkDensity};
use dpn_core::trajectory::StampedPose;
use dpn_core::{ImuNoise, ImuSample};
use dpn_vio::factors::inertial::{inertial_jacobians, inertial_residual, sqrt_information};
use dpn_vio::preint::{ImuCov, NoisySample, Preintegration, PreintegrationConfig};
use dpn_vio::state::{ACCEL_BIAS, GYRO_BIAS, POSITION, ROTATION, STATE_DIM, VELOCITY};
use nalgebra::{SMatrix, SVector, Vector2, Vector3};

/// A residual beyond this many deviations pulls as if it were there (Huber).
const HUBER: f64 = 3.0;
/// What is known of the constants beforehand, as deviations: enough that none is free, too little to be felt.
const PRIOR: [(usize, usize, f64); 5] =
    [(DELAY, 1, 0.1), (MOUNT, 3, 1.0), (LEVER, 3, 0.1), (TILT, 2, 1.0), (BLUR, 1, 0.01)];
/// A constant that is held moves by no more than this.
const HELD: f64 = 1e-8;
/// The same of the first key of a stretch: place, offset, deviation.
const START: [(usize, f64); 5] =
    [(POSITION, 1e3), (ROTATION, 10.0), (VELOCITY, 100.0), (ACCEL_BIAS, 1.0), (GYRO_BIAS, 0.3)];

/// A published pose and what becomes of it.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Published {
    /// As published.
    pub(crate) pose: StampedPose,
    /// What becomes of it.
    pub(crate) role: Role,
}

/// What becomes of a published pose.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Role {
    /// The adjustment hears of it.
    Used,
    /// Kept out to be predicted.
    KeptOut,
    /// It does not belong to the rest.
    LeftOut,
    /// Another is nearer to the key, and one is enough.
    Beside,
}

/// The poses beside a key, each kind as their mean.
#[derive(Debug, Clone)]
pub(crate) struct Blocks {
    /// Those the adjustment hears of.
    pub(crate) used: Option<PoseTerm>,
    /// Those kept out.
    pub(crate) kept_out: Option<PoseTerm>,
}

/// Everything that is estimated.
#[derive(Debug, Clone)]
pub(crate) struct Estimate {
    /// In order of time.
    pub(crate) keys: Vec<Key>,
    /// One for all.
    pub(crate) frames: Frames,
}

/// What the estimate is held against.
#[derive(Debug, Clone)]
pub(crate) struct Problem<'a> {
    /// The readings.
    pub(crate) samples: &'a [ImuSample],
    /// The poses.
    pub(crate) published: Vec<Published>,
    /// Whether key k + 1 follows key k without a gap in the samples.
    pub(crate) linked: Vec<bool>,
    /// Between two keys \[s\].
    pub(crate) interval_s: f64,
    /// The most white noise that the accelerometer's and the gyro's spectra allow.
    pub(crate) ceilings: [f64; 2],
    /// Whether the IMU's levels are asked for axis by axis.
    pub(crate) by_axis: Option<ByAxis>,
    /// Places of the groups of constants that are held where they are.
    pub(crate) held: Vec<usize>,
}

/// Two keys and the samples between: 15 inertial rows, 9 of the slow errors, white with variance 1.
pub(crate) struct Link {
    pub(crate) residual: SVector<f64, KEY_DIM>,
    pub(crate) by_first: SMatrix<f64, KEY_DIM, KEY_DIM>,
    pub(crate) by_second: SMatrix<f64, KEY_DIM, KEY_DIM>,
    /// Logarithm of the determinant of what made them white.
    log_weight: f64,
}

/// The group of each row of a link.
fn link_group(row: usize) -> Group {
    match row {
        0..3 | 6..9 => Group::Accel,
        3..6 => Group::Gyro,
        9..12 => Group::AccelWalk,
        12..15 => Group::GyroWalk,
        15..18 | 21..24 => Group::SlowPosition,
        _ => Group::SlowRotation,
    }
}

/// Accelerometer 0 or gyro 1, and the axis, that a row is of: over an interval the body turns little.
fn link_axis(row: usize) -> Option<(usize, usize)> {
    match row {
        0..3 | 6..9 => Some((0, row % 3)),
        3..6 => Some((1, row % 3)),
        _ => None,
    }
}

/// Adds `a' b` where it belongs.
pub(crate) fn add<const R: usize, const A: usize, const B: usize>(
    into: &mut SMatrix<f64, A, B>,
    a: &SMatrix<f64, R, A>,
    b: &SMatrix<f64, R, B>,
) {
    into.gemm_tr(1.0, a, b, 1.0);
}

impl Problem<'_> {
    /// The samples from key k to the next, integrated with the first key's bias.
    pub(crate) fn between(
        &self,
        estimate: &Estimate,
        k: usize,
        levels: &Levels,
    ) -> Result<Preintegration, BadNoise> {
        self.between_of(estimate, k, levels, &|sample| *sample)
    }

    /// The same of samples that `of` makes of those read.
    fn between_of(
        &self,
        estimate: &Estimate,
        k: usize,
        levels: &Levels,
        of: &dyn Fn(&ImuSample) -> ImuSample,
    ) -> Result<Preintegration, BadNoise> {
        let (first, second) = (&estimate.keys[k], &estimate.keys[k + 1]);
        let [accel, gyro] = levels.sample_stds();
        let noise = ImuNoise::from_values(accel, gyro)?;
        let config = PreintegrationConfig {
            imu_cov: ImuCov::Exact,
            accel_bias_walk: AccelBiasWalkDensity::new(levels.accel_bias_walk)?,
            gyro_bias_walk: GyroBiasWalkDensity::new(levels.gyro_bias_walk)?,
        };
        let noisy = |sample: &ImuSample| NoisySample { sample: of(sample), noise };
        let mut preint = Preintegration::new(config, first.state.bias, noisy(&self.samples[first.sample]));
        for sample in &self.samples[first.sample + 1..=second.sample] {
            preint.push(noisy(sample));
        }
        Ok(preint)
    }

    /// What whitens the inertial rows of link k.
    ///
    /// # Panics
    /// Where the link is broken.
    pub(crate) fn root(
        &self,
        estimate: &Estimate,
        k: usize,
        levels: &Levels,
    ) -> SMatrix<f64, STATE_DIM, STATE_DIM> {
        let preint = self.between(estimate, k, levels).expect("levels are positive and finite");
        sqrt_information(&preint).expect("a key is three samples or more from the next, and no level is zero")
    }

    /// The inertial rows of link k, not whitened, for samples that `of` makes of those read.
    pub(crate) fn rows_with(
        &self,
        estimate: &Estimate,
        k: usize,
        levels: &Levels,
        of: &dyn Fn(&ImuSample) -> ImuSample,
    ) -> SVector<f64, STATE_DIM> {
        let preint = self.between_of(estimate, k, levels, of).expect("levels are positive and finite");
        inertial_residual(&preint, &estimate.keys[k].state, &estimate.keys[k + 1].state)
    }

    pub(crate) fn link(&self, estimate: &Estimate, k: usize, levels: &Levels) -> Option<Link> {
        if !self.linked[k] {
            return None;
        }
        let (first, second) = (&estimate.keys[k], &estimate.keys[k + 1]);
        let preint = self.between(estimate, k, levels).expect("levels are positive and finite");
        let root = sqrt_information(&preint)
            .expect("a key is three samples or more from the next, and no level is zero");
        let (residual, by_first, by_second) = inertial_jacobians(&preint, &first.state, &second.state);
        let log_of = |diagonal: &[f64]| diagonal.iter().map(|v| v.ln()).sum::<f64>();
        let mut link = Link {
            residual: SVector::zeros(),
            by_first: SMatrix::zeros(),
            by_second: SMatrix::zeros(),
            log_weight: log_of(root.diagonal().as_slice()),
        };
        link.residual.fixed_rows_mut::<STATE_DIM>(0).copy_from(&(root * residual));
        link.by_first.fixed_view_mut::<STATE_DIM, STATE_DIM>(0, 0).copy_from(&(root * by_first));
        link.by_second.fixed_view_mut::<STATE_DIM, STATE_DIM>(0, 0).copy_from(&(root * by_second));
        let span = preint.duration();
        let (course, root) = levels.position_course(span);
        let by_first = root * course;
        let phi = levels.persistence(span);
        let weight = 1.0 / (levels.slow_rotation_std * (1.0 - phi * phi).sqrt());
        link.log_weight += 3.0 * (log_of(root.diagonal().as_slice()) + weight.ln());
        for axis in 0..3 {
            let (error, rate, turn) = (POSITION_ERROR + axis, ERROR_RATE + axis, ROTATION_ERROR + axis);
            let e = Vector2::new(first.position_error[axis], first.error_rate[axis]);
            let next = Vector2::new(second.position_error[axis], second.error_rate[axis]);
            let residual = root * (next - course * e);
            for (i, row) in [error, rate].into_iter().enumerate() {
                link.residual[row] = residual[i];
                for (j, column) in [error, rate].into_iter().enumerate() {
                    link.by_first[(row, column)] = -by_first[(i, j)];
                    link.by_second[(row, column)] = root[(i, j)];
                }
            }
            link.residual[turn] = weight * (second.rotation_error[axis] - phi * first.rotation_error[axis]);
            link.by_first[(turn, turn)] = -weight * phi;
            link.by_second[(turn, turn)] = weight;
        }
        // A published trajectory that limps now and then is not one that is bad throughout, and no noise of the IMU's.
        for rows in [&[15, 16, 17, 21, 22, 23][..], &[18, 19, 20]] {
            let far = rows.iter().map(|row| link.residual[*row].powi(2)).sum::<f64>().sqrt();
            let usual = HUBER * (rows.len() as f64 / 3.0).sqrt();
            let weight = if far > usual { (usual / far).sqrt() } else { 1.0 };
            for row in rows {
                link.residual[*row] *= weight;
                link.by_first.row_mut(*row).scale_mut(weight);
                link.by_second.row_mut(*row).scale_mut(weight);
            }
        }
        Some(link)
    }

    /// The key next to an instant, in seconds since the first sample.
    fn nearest(&self, estimate: &Estimate, at: f64) -> usize {
        let time = |k: usize| self.seconds(estimate.keys[k].sample);
        let after = estimate.keys.partition_point(|key| self.seconds(key.sample) < at);
        if after == 0 {
            0
        } else if after == estimate.keys.len() || at - time(after - 1) < time(after) - at {
            after - 1
        } else {
            after
        }
    }

    /// Of a sample, since the first.
    fn seconds(&self, sample: usize) -> f64 {
        self.samples[sample].t.seconds_since(self.samples[0].t)
    }

    /// How the motion bends at every key, by its neighbours' estimates: by the readings themselves their noise would be taken for motion.
    fn bends(&self, estimate: &Estimate) -> Vec<Bend> {
        let keys = &estimate.keys;
        let still = Bend {
            accel_in_world: Vector3::zeros(),
            rate_in_body: Vector3::zeros(),
            angular_accel_in_body: Vector3::zeros(),
        };
        // The ends are taken to bend as the keys beside them.
        let last = keys.len() - 1;
        let at = |k: usize| {
            let k = k.clamp(1, last.max(2) - 1);
            if last < 2 || !(self.linked[k - 1] && self.linked[k]) {
                return still;
            }
            let (a, b, c) = (&keys[k - 1], &keys[k], &keys[k + 1]);
            let half = 0.5 * (self.seconds(c.sample) - self.seconds(a.sample));
            let turn = |from: &Key, to: &Key| {
                so3::log(&(from.state.world_from_body.rotation.inverse() * to.state.world_from_body.rotation))
            };
            let (before, after) = (turn(a, b) / half, turn(b, c) / half);
            Bend {
                accel_in_world: (c.state.vel_in_world - a.state.vel_in_world) / (2.0 * half),
                rate_in_body: 0.5 * (before + after),
                angular_accel_in_body: (after - before) / half,
            }
        };
        (0..keys.len()).map(at).collect()
    }

    /// Leaves the nearest of the used poses at every key. A mean of many is of the motion over an interval, whose random walk has 2/3 of the steps' variance: what is reconciled
    /// gains by it, the IMU's levels would be too small.
    pub(crate) fn leave_nearest(&mut self, estimate: &Estimate) {
        let mut nearest: Vec<Option<(f64, usize)>> = vec![None; estimate.keys.len()];
        for (i, published) in self.published.iter_mut().enumerate().filter(|(_, p)| p.role == Role::Used) {
            published.role = Role::Beside;
            let at = published.pose.t.plus_seconds(-estimate.frames.delay_s).seconds_since(self.samples[0].t);
            let after = estimate
                .keys
                .partition_point(|key| self.samples[key.sample].t.seconds_since(self.samples[0].t) < at);
            for k in [after.checked_sub(1), Some(after)].into_iter().flatten() {
                let Some(key) = estimate.keys.get(k) else { continue };
                let far = (self.samples[key.sample].t.seconds_since(self.samples[0].t) - at).abs();
                if nearest[k].is_none_or(|(least, _)| far < least) {
                    nearest[k] = Some((far, i));
                }
            }
        }
        for (_, i) in nearest.into_iter().flatten().filter(|(far, _)| *far <= 0.5 * self.interval_s) {
            self.published[i].role = Role::Used;
        }
    }

    /// Every published pose with its key and term, those not used too.
    pub(crate) fn terms(&self, estimate: &Estimate) -> Vec<(usize, PoseTerm)> {
        let bends = self.bends(estimate);
        let terms = self.published.iter().map(|published| {
            let t = published.pose.t.plus_seconds(-estimate.frames.delay_s);
            let at = t.seconds_since(self.samples[0].t);
            let k = self.nearest(estimate, at);
            let near = Near::new(self.samples, &estimate.keys[k], t);
            // Between the keys the bend is taken as linear.
            let beside = if near.tau >= 0.0 { (k + 1).min(bends.len() - 1) } else { k.saturating_sub(1) };
            let share = (near.tau.abs() / self.interval_s).min(1.0);
            let mix = |a: Vector3<f64>, b: Vector3<f64>| a + (b - a) * share;
            let bend = Bend {
                rate_in_body: mix(bends[k].rate_in_body, bends[beside].rate_in_body),
                accel_in_world: mix(bends[k].accel_in_world, bends[beside].accel_in_world),
                angular_accel_in_body: mix(
                    bends[k].angular_accel_in_body,
                    bends[beside].angular_accel_in_body,
                ),
            };
            (k, pose_term(&published.pose.world_from_body, &estimate.keys[k], &near, &bend, &estimate.frames))
        });
        terms.collect()
    }

    /// The poses beside every key as one: their errors go together in ways nobody knows, and only their mean is asked how noisy it is.
    pub(crate) fn blocks(&self, terms: &[(usize, PoseTerm)]) -> Vec<Blocks> {
        let keys = self.linked.len() + 1;
        let mut out: Vec<Blocks> = (0..keys).map(|_| Blocks { used: None, kept_out: None }).collect();
        let mut counts = vec![[0.0; 2]; keys];
        for (published, (k, term)) in self.published.iter().zip(terms) {
            let (mean, count) = match published.role {
                Role::Used => (&mut out[*k].used, &mut counts[*k][0]),
                Role::KeptOut => (&mut out[*k].kept_out, &mut counts[*k][1]),
                Role::LeftOut | Role::Beside => continue,
            };
            *count += 1.0;
            match mean {
                None => *mean = Some(term.clone()),
                Some(mean) => mean.take_in(term, *count),
            }
        }
        out
    }

    /// The normal equations at `estimate`.
    pub(crate) fn linearise(&self, estimate: &Estimate, levels: &Levels) -> Chain<KEY_DIM, CONSTANTS> {
        let keys = estimate.keys.len();
        let mut chain = Chain::<KEY_DIM, CONSTANTS>::zeros(keys);
        for k in 0..keys - 1 {
            let Some(link) = self.link(estimate, k, levels) else { continue };
            add(&mut chain.diagonal[k], &link.by_first, &link.by_first);
            add(&mut chain.diagonal[k + 1], &link.by_second, &link.by_second);
            add(&mut chain.next[k], &link.by_second, &link.by_first);
            add(&mut chain.gradient[k], &link.by_first, &link.residual);
            add(&mut chain.gradient[k + 1], &link.by_second, &link.residual);
        }
        for k in 0..keys {
            if k > 0 && self.linked[k - 1] {
                continue;
            }
            for (at, std) in START {
                for axis in 0..3 {
                    chain.diagonal[k][(at + axis, at + axis)] += 1.0 / (std * std);
                }
            }
            for axis in 0..3 {
                for (at, std, error) in [
                    (POSITION_ERROR, levels.slow_position_std, estimate.keys[k].position_error),
                    (ROTATION_ERROR, levels.slow_rotation_std, estimate.keys[k].rotation_error),
                    (
                        ERROR_RATE,
                        levels.slow_position_std / levels.slow_position_s,
                        estimate.keys[k].error_rate,
                    ),
                ] {
                    chain.diagonal[k][(at + axis, at + axis)] += 1.0 / (std * std);
                    chain.gradient[k][at + axis] += error[axis] / (std * std);
                }
            }
        }
        for (k, blocks) in self.blocks(&self.terms(estimate)).iter().enumerate() {
            if let Some(term) = &blocks.used {
                let white = whitened(term, levels);
                add(&mut chain.diagonal[k], &white.by_key, &white.by_key);
                add(&mut chain.border[k], &white.by_constants, &white.by_key);
                add(&mut chain.corner, &white.by_constants, &white.by_constants);
                add(&mut chain.gradient[k], &white.by_key, &white.residual);
                add(&mut chain.gradient_of_constants, &white.by_constants, &white.residual);
            }
        }
        let frames = &estimate.frames;
        for (at, count, std) in PRIOR {
            for i in 0..count {
                let std = if self.held.contains(&at) { HELD } else { std };
                chain.corner[(at + i, at + i)] += 1.0 / (std * std);
                // Those whose zero means something are held to it; the others to where they are.
                chain.gradient_of_constants[at + i] += match at {
                    LEVER => frames.lever_in_body[i],
                    BLUR => frames.blur_s2,
                    _ => 0.0,
                } / (std * std);
            }
        }
        chain
    }

    /// Twice the negative logarithm of the restricted likelihood, but for what no level changes; none where it is singular.
    pub(crate) fn unlikelihood(&self, estimate: &Estimate, levels: &Levels) -> Option<f64> {
        let mut sum = self.linearise(estimate, levels).factor().ok()?.log_determinant();
        let slow_rate = levels.slow_position_std / levels.slow_position_s;
        let slow = [levels.slow_position_std, levels.slow_rotation_std, slow_rate];
        for k in 0..estimate.keys.len() {
            if let Some(link) =
                (k + 1 < estimate.keys.len()).then(|| self.link(estimate, k, levels)).flatten()
            {
                sum += link.residual.norm_squared() - 2.0 * link.log_weight;
            }
            if k == 0 || !self.linked[k - 1] {
                let key = &estimate.keys[k];
                let first = [key.position_error, key.rotation_error, key.error_rate];
                sum += slow
                    .iter()
                    .zip(first)
                    .map(|(s, e)| e.norm_squared() / (s * s) + 6.0 * s.ln())
                    .sum::<f64>();
            }
        }
        for term in self.blocks(&self.terms(estimate)).iter().filter_map(|blocks| blocks.used.as_ref()) {
            let levels_of = 6.0 * (levels.position_std.ln() + levels.rotation_std.ln());
            sum += whitened(term, levels).residual.norm_squared() + levels_of;
        }
        Some(sum)
    }

    /// What the residuals at `estimate` say of the levels.
    pub(crate) fn found(
        &self,
        estimate: &Estimate,
        levels: &Levels,
        covariance: &ChainCovariance<KEY_DIM, CONSTANTS>,
    ) -> Found {
        let mut found = Found { interval_s: self.interval_s, ..Found::default() };
        for k in 0..estimate.keys.len() - 1 {
            let Some(link) = self.link(estimate, k, levels) else { continue };
            let mixed =
                link.by_first * covariance.keys[k] + 2.0 * link.by_second * covariance.next[k].transpose();
            let second_own = link.by_second * covariance.keys[k + 1];
            for row in 0..KEY_DIM {
                let leverage = mixed.row(row).dot(&link.by_first.row(row))
                    + second_own.row(row).dot(&link.by_second.row(row));
                found.add(link_group(row), link.residual[row].powi(2), leverage);
                if let Some((sensor, axis)) = link_axis(row) {
                    found.add_axis(sensor, axis, link.residual[row].powi(2), leverage);
                }
            }
            let (first, second) = (&estimate.keys[k], &estimate.keys[k + 1]);
            let trace = |block: &SMatrix<f64, KEY_DIM, KEY_DIM>, at: usize| {
                (at..at + 3).map(|i| block[(i, i)]).sum::<f64>()
            };
            let (own, next) = (&covariance.keys[k], &covariance.next[k]);
            let position = [
                first.error_rate.norm_squared() + trace(own, ERROR_RATE),
                first.position_error.norm_squared() + trace(own, POSITION_ERROR),
            ];
            let rotation = [
                first.rotation_error.dot(&second.rotation_error) + trace(next, ROTATION_ERROR),
                first.rotation_error.norm_squared() + trace(own, ROTATION_ERROR),
            ];
            for i in 0..2 {
                found.position_moments[i] += position[i];
                found.rotation_moments[i] += rotation[i];
            }
        }
        for (k, blocks) in self.blocks(&self.terms(estimate)).iter().enumerate() {
            let Some(term) = &blocks.used else { continue };
            let white = whitened(term, levels);
            let spread = white.spread(covariance, k);
            for row in 0..POSE_ROWS {
                let group = if row < 3 { Group::Position } else { Group::Rotation };
                found.add(group, white.residual[row].powi(2), spread[row]);
            }
        }
        found
    }
}

impl PoseTerm {
    /// One more in a mean of now `count`.
    fn take_in(&mut self, other: &Self, count: f64) {
        self.residual += (other.residual - self.residual) / count;
        self.by_key += (other.by_key - self.by_key) / count;
        self.by_constants += (other.by_constants - self.by_constants) / count;
    }

    /// The variance of each row that comes from the estimate.
    pub(crate) fn spread(
        &self,
        covariance: &ChainCovariance<KEY_DIM, CONSTANTS>,
        k: usize,
    ) -> SVector<f64, POSE_ROWS> {
        let by_key = self.by_key * covariance.keys[k]
            + 2.0 * self.by_constants * covariance.with_constants[k].transpose();
        let by_constants = self.by_constants * covariance.constants;
        SVector::from_fn(|row, _| {
            by_key.row(row).dot(&self.by_key.row(row))
                + by_constants.row(row).dot(&self.by_constants.row(row))
        })
    }
}

/// A published pose's rows with variance 1, those far out weighed down.
fn whitened(term: &PoseTerm, levels: &Levels) -> PoseTerm {
    let mut out = term.clone();
    for (from, std) in [(0, levels.position_std), (3, levels.rotation_std)] {
        let far = term.residual.fixed_rows::<3>(from).norm() / std;
        let weight = if far > HUBER { (HUBER / far).sqrt() } else { 1.0 } / std;
        out.residual.fixed_rows_mut::<3>(from).scale_mut(weight);
        out.by_key.fixed_rows_mut::<3>(from).scale_mut(weight);
        out.by_constants.fixed_rows_mut::<3>(from).scale_mut(weight);
    }
    out
}
