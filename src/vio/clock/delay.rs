//! How late a camera's stamps are, from its turns and the gyroscope's.
//!
//! What a camera turned between two frames stamped `a` and `b` the gyroscope turned between `a + d` and `b + d`, `d` being what has to be added to the
//! camera's stamps. Over pairs of frames, with the turns as rotation vectors in the camera's axes, `T = b - a`,
//!
//! ```text
//! r(d, u) = turn_of_camera - cam_from_body log(gyro(a + d, b + d)) + u T,   dr/dd = -cam_from_body (w(b + d) - w(a + d)),
//! ```
//!
//! is small, `u` taking the gyroscope's bias. The cost is that of the better three quarters of the pairs, each by its own information, over all `d`
//! of a grid; from its least place Gauss-Newton goes on with Geman and McClure's weights. The deviation is that of least squares with the residuals' own
//! spread. Two places that fit alike (a body that shakes to and fro) are no answer.
//! Source: the regression of E. Mair et al., "Spatio-temporal initialization for IMU to camera registration", ROBIO 2011, with correlation as its start.

use super::flow_turn::FlowTurn;
use super::gyro_course::GyroCourse;
use dpn_core::geometry::so3;
use nalgebra::{Matrix3, Matrix5, SMatrix, UnitQuaternion, Vector3, Vector5};

/// An offset is looked for so far to both sides of a stamp \[s\].
pub const REACH_S: f64 = 0.25;
/// Step of the grid \[s\].
const GRID_S: f64 = 0.005;
/// Share of the pairs that a cost is of.
const TRIMMED: f64 = 0.75;
/// Errors of the camera's turns are alike over so many pairs: the same points at the same distances, followed on.
pub(crate) const ALIKE_PAIRS: f64 = 3.0;
/// Another place so far away that fits nearly as well makes an answer none \[s\].
const APART_S: f64 = 0.04;
/// Steps of Gauss-Newton.
const STEPS: usize = 5;
/// A drift is one where it is so many deviations from none.
const SURE_DRIFT: f64 = 3.0;
/// No clock is faster than this \[s/s\].
const FASTEST_DRIFT: f64 = 0.03;

/// An answer.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Delay {
    /// What has to be added to the camera's stamps at the last pair \[s\].
    pub(crate) offset_s: f64,
    /// Its deviation \[s\].
    pub(crate) std_s: f64,
    /// How fast that grows \[s/s\]; 0 where no drift shows.
    pub(crate) drift: f64,
    drift_std: f64,
    /// Share of the camera's turning that the gyroscope explains then.
    pub(crate) explained: f64,
    /// The cost there, as a share of the least one elsewhere; 0 where nobody looked.
    pub(crate) of_elsewhere: f64,
}

/// Turns of a camera, and the gyroscope's beside them.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Turns<'a> {
    pub(crate) course: &'a GyroCourse,
    /// Those whose time the course covers up to [`REACH_S`] to both sides.
    pub(crate) pairs: &'a [FlowTurn],
    pub(crate) cam_from_body: UnitQuaternion<f64>,
}

/// What is left of a pair: residual without bias, seconds, information, its slope by the offset.
#[derive(Debug, Clone, Copy)]
struct Row {
    left: Vector3<f64>,
    seconds: f64,
    since_last: f64,
    information: Matrix3<f64>,
    slope: Vector3<f64>,
}

impl Row {
    /// The sum of squares with the bias `u`.
    fn squares(&self, u: &Vector3<f64>) -> f64 {
        let r = self.left + u * self.seconds;
        r.dot(&(self.information * r))
    }
}

impl Turns<'_> {
    /// The best offset within reach, found anew; `None` where the equations have no solution.
    pub(crate) fn delay(&self) -> Option<Delay> {
        let steps = (REACH_S / GRID_S).round() as i32;
        let costs: Vec<(f64, f64)> = (-steps..=steps)
            .filter_map(|k| {
                let offset = f64::from(k) * GRID_S;
                Some((offset, cost(&self.rows(offset, 0.0)?)?.0))
            })
            .collect();
        let best = costs.iter().min_by(|a, b| a.1.total_cmp(&b.1))?;
        let mut found = self.near(best.0, false)?;
        let elsewhere = costs.iter().filter(|(offset, _)| (offset - found.offset_s).abs() > APART_S);
        let elsewhere = elsewhere.map(|(_, cost)| *cost).fold(f64::INFINITY, f64::min);
        found.of_elsewhere = cost(&self.rows(found.offset_s, found.drift)?)?.0 / elsewhere;
        Some(found)
    }

    /// The best offset next to `start`, with the drift where it may have one and one shows.
    pub(crate) fn near(&self, start: f64, may_drift: bool) -> Option<Delay> {
        if may_drift {
            let drifting = self.fitted(start, true)?;
            if drifting.drift.abs() > SURE_DRIFT * drifting.drift_std {
                return Some(drifting);
            }
        }
        self.fitted(start, false)
    }

    /// Gauss-Newton from `start`: the offset at the last pair, the drift where it may be any, the bias.
    fn fitted(&self, start: f64, drifts: bool) -> Option<Delay> {
        let (mut offset, mut drift) = (start, 0.0);
        let mut variances = [f64::INFINITY; 2];
        for _ in 0..STEPS {
            let rows = self.rows(offset, drift)?;
            let (_, bias, scale) = cost(&rows)?;
            let (mut normal, mut right) = (Matrix5::<f64>::zeros(), Vector5::<f64>::zeros());
            let (mut squares, mut weights) = (0.0, 0.0);
            for row in &rows {
                let weight = weight(row.squares(&bias), scale);
                let mut slope = SMatrix::<f64, 3, 5>::zeros();
                slope.set_column(0, &row.slope);
                slope.set_column(1, &(row.slope * row.since_last));
                slope.fixed_view_mut::<3, 3>(0, 2).fill_diagonal(row.seconds);
                let weighted = slope.transpose() * row.information * weight;
                normal += weighted * slope;
                right -= weighted * (row.left + bias * row.seconds);
                squares += weight * row.squares(&bias);
                weights += 3.0 * weight;
            }
            if !drifts {
                // One that is known to be none.
                normal[(1, 1)] += normal[(0, 0)] * 1e12;
            }
            let inverse = normal.try_inverse()?;
            let spread = squares / (weights - 5.0).max(1.0);
            variances = [0, 1].map(|k| inverse[(k, k)] * spread * ALIKE_PAIRS);
            let step = inverse * right;
            offset = (offset + step[0]).clamp(-REACH_S, REACH_S);
            drift = (drift + step[1]).clamp(-FASTEST_DRIFT, FASTEST_DRIFT);
        }
        let here = cost(&self.rows(offset, drift)?)?.0;
        let alone: Vec<Row> =
            self.pairs.iter().map(|pair| self.row(pair, pair.turn, Vector3::zeros())).collect();
        let [std_s, drift_std] = variances.map(f64::sqrt);
        Some(Delay {
            offset_s: offset,
            std_s,
            drift: if drifts { drift } else { 0.0 },
            drift_std,
            explained: 1.0 - here / cost(&alone)?.0,
            of_elsewhere: 0.0,
        })
        // At the end of the reach it may be anywhere beyond.
        .filter(|delay| delay.offset_s.abs() < REACH_S && delay.std_s.is_finite())
    }

    /// Where the stamps need `offset` at the last pair, and `drift` of the time since less before.
    fn rows(&self, offset: f64, drift: f64) -> Option<Vec<Row>> {
        let row = |pair: &FlowTurn| {
            let offset = offset + drift * self.since_last(pair);
            let (a, b) = (pair.from.plus_seconds(offset), pair.to.plus_seconds(offset));
            let gyro = self.cam_from_body * so3::log(&self.course.turn(a, b)?);
            let slope = self.cam_from_body * (self.course.rate(b)? - self.course.rate(a)?);
            Some(self.row(pair, pair.turn - gyro, -slope))
        };
        self.pairs.iter().map(row).collect()
    }

    /// From the last pair to this one, not above zero \[s\].
    fn since_last(&self, pair: &FlowTurn) -> f64 {
        self.pairs.last().map_or(0.0, |last| pair.to.seconds_since(last.to))
    }

    fn row(&self, pair: &FlowTurn, left: Vector3<f64>, slope: Vector3<f64>) -> Row {
        let since_last = self.since_last(pair);
        Row { left, seconds: pair.seconds(), since_last, information: pair.information, slope }
    }
}

/// Geman and McClure's weight of a sum of squares where `scale` is usual.
pub(crate) fn weight(squares: f64, scale: f64) -> f64 {
    (1.0 + squares / (9.0 * scale)).powi(-2)
}

/// The mean of the better squares with the best bias, that bias, and the usual square.
fn cost(rows: &[Row]) -> Option<(f64, Vector3<f64>, f64)> {
    let mut bias = Vector3::zeros();
    let mut scale = f64::INFINITY;
    let mut squares: Vec<f64> = Vec::new();
    let kept = (TRIMMED * rows.len() as f64) as usize;
    for _ in 0..3 {
        let (mut normal, mut right) = (Matrix3::zeros(), Vector3::zeros());
        for row in rows {
            let weight = if scale.is_finite() { weight(row.squares(&bias), scale) } else { 1.0 };
            normal += row.information * (weight * row.seconds * row.seconds);
            right -= row.information * row.left * (weight * row.seconds);
        }
        bias = normal.cholesky()?.solve(&right);
        squares = rows.iter().map(|row| row.squares(&bias)).collect();
        squares.sort_by(f64::total_cmp);
        scale = squares.get(rows.len() / 2)?.max(f64::MIN_POSITIVE);
    }
    (kept > 0).then(|| (squares[..kept].iter().sum::<f64>() / kept as f64, bias, scale))
}

#[cfg(test)]
mod tests {
    use super::*;
    use dpn_core::random::Stream;
    use dpn_core::{ImuSample, Stamp};
    use rand::Rng;
    use rand_distr::StandardNormal;

    const START_NS: i64 = 1_000_000_000;

    /// Rates of a body that is turned by hand \[rad/s\].
    fn rate(seed: u64, s: f64) -> Vector3<f64> {
        Vector3::from_fn(|axis, _| {
            let waves = (1..6).map(|k| {
                let phase = (seed as f64 + 1.3 * axis as f64) * f64::from(k) * 2.7;
                0.3 * (2.0 * std::f64::consts::PI * (0.23 * f64::from(k)) * s + phase).sin()
            });
            waves.sum()
        })
    }

    /// A gyroscope with a bias, and the turns of a camera whose stamps need `offset_s`; a tenth of them are wrong.
    fn case(seed: u64, offset_s: f64, pairs: usize) -> (GyroCourse, Vec<FlowTurn>) {
        let mut rng = Stream::new(seed).named("delay").rng();
        let mut normal = move || -> f64 { rng.sample(StandardNormal) };
        let (mut course, mut truth) = (GyroCourse::default(), GyroCourse::default());
        for k in 0..(200 * (pairs as i64 / 10 + 2)) {
            let t = Stamp::from_ns(START_NS + 5_000_000 * k);
            let gyro = rate(seed, 0.005 * k as f64);
            let noisy = gyro + Vector3::new(0.02, -0.05, 0.01) + Vector3::from_fn(|_, _| 0.016 * normal());
            let sample = |gyro: Vector3<f64>| ImuSample { t, gyro: gyro.into(), accel: [0.0; 3] };
            truth.push(&sample(gyro));
            course.push(&sample(noisy));
        }
        let flows = (0..pairs).map(|k| {
            let at = |k: usize| Stamp::from_ns(START_NS + 600_000_000 + 100_000_000 * k as i64);
            let (from, to) = (at(k), at(k + 1));
            let turn = truth.turn(from.plus_seconds(offset_s), to.plus_seconds(offset_s)).unwrap();
            let std = if k % 10 == 3 { 0.05 } else { 0.002 };
            let turn = so3::log(&turn) + Vector3::from_fn(|_, _| std * normal());
            FlowTurn {
                from,
                to,
                turn,
                information: Matrix3::identity() / (0.001 * 0.001),
                path: Vector3::x(),
            }
        });
        (course, flows.collect())
    }

    #[test]
    fn offsets_are_found_within_a_millisecond_or_two_and_are_known_as_well_as_they_say() {
        let (mut squares, mut count) = (0.0, 0.0);
        for seed in 0..6 {
            for offset_s in [-0.2, -0.036, 0.0, 0.0013, 0.1] {
                let (course, pairs) = case(seed, offset_s, 60);
                let turns =
                    Turns { course: &course, pairs: &pairs, cam_from_body: UnitQuaternion::identity() };
                let found = turns.delay().unwrap();
                let off = found.offset_s - offset_s;
                assert!(off.abs() < 0.003 && found.explained > 0.98, "{offset_s}: {found:?}");
                assert!(found.of_elsewhere < 0.3, "{found:?}");
                squares += (off / found.std_s).powi(2);
                count += 1.0;
                let near = turns.near(offset_s + 0.004, false).unwrap();
                assert!((near.offset_s - found.offset_s).abs() < 1e-3, "{near:?} {found:?}");
            }
        }
        // Here errors are white: the deviation allows for three that are alike.
        let mean: f64 = squares / count;
        assert!((0.1..1.0).contains(&mean), "{mean}");
    }

    #[test]
    fn a_body_that_shakes_to_and_fro_has_other_places_that_fit_as_well() {
        let mut course = GyroCourse::default();
        let shake = |s: f64| Vector3::z() * (2.0 * std::f64::consts::PI * 5.0 * s).sin();
        for k in 0..2_000 {
            let t = Stamp::from_ns(START_NS + 5_000_000 * k);
            course.push(&ImuSample { t, gyro: shake(0.005 * k as f64).into(), accel: [0.0; 3] });
        }
        let pairs: Vec<FlowTurn> = (0..60)
            .map(|k| {
                let at = |k: i64| Stamp::from_ns(START_NS + 600_000_000 + 70_000_000 * k);
                let turn = so3::log(&course.turn(at(k), at(k + 1)).unwrap());
                let turn = turn.add_scalar(0.002 * (1.0 + k as f64).sin());
                FlowTurn {
                    from: at(k),
                    to: at(k + 1),
                    turn,
                    information: Matrix3::identity() * 1e6,
                    path: Vector3::x(),
                }
            })
            .collect();
        let turns = Turns { course: &course, pairs: &pairs, cam_from_body: UnitQuaternion::identity() };
        assert!(turns.delay().unwrap().of_elsewhere > 0.9);
    }
}
