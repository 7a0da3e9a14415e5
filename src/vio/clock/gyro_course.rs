//! The body's orientation as the gyroscope integrates it, to be asked for the turn between any two instants of the last seconds.

use dpn_core::geometry::so3;
use dpn_core::{ImuSample, Stamp};
use nalgebra::{UnitQuaternion, Vector3};
use std::collections::VecDeque;

/// A step between two samples longer than this has no turn \[s\].
const LONGEST_STEP_S: f64 = 0.05;

/// Rates are compared over so many parts of a span.
const PARTS: usize = 6;
/// A rate that changes by less is that of a body at rest, on idle rotors too \[rad/s\].
const LEAST_CHANGE: f64 = 0.03;

#[derive(Debug, Clone, Copy)]
struct Knot {
    t: Stamp,
    rate: Vector3<f64>,
    /// Integral of the rate since the first knot there ever was \[rad\].
    angle: Vector3<f64>,
    /// To the frame of the first knot there ever was.
    first_from_body: UnitQuaternion<f64>,
    /// From here on there is no gap up to this knot.
    whole_since: Stamp,
}

/// Orientations at samples; rates are joined linearly between them.
#[derive(Debug, Clone, Default)]
pub(crate) struct GyroCourse {
    knots: VecDeque<Knot>,
}

impl GyroCourse {
    /// Takes a sample; one that is not later than the last is passed over.
    pub(crate) fn push(&mut self, sample: &ImuSample) {
        let (t, rate) = (sample.t, Vector3::from(sample.gyro));
        let knot = match self.knots.back() {
            None => Knot {
                t,
                rate,
                angle: Vector3::zeros(),
                first_from_body: UnitQuaternion::identity(),
                whole_since: t,
            },
            Some(last) if t > last.t => {
                let seconds = t.seconds_since(last.t);
                let turn = so3::exp(&(0.5 * (last.rate + rate) * seconds));
                let whole_since = if seconds > LONGEST_STEP_S { t } else { last.whole_since };
                // Renormalised: the course is as long as the recording.
                let first_from_body =
                    UnitQuaternion::new_normalize((last.first_from_body * turn).into_inner());
                let angle = last.angle + 0.5 * (last.rate + rate) * seconds;
                Knot { t, rate, angle, first_from_body, whole_since }
            }
            Some(_) => return,
        };
        self.knots.push_back(knot);
    }

    /// Forgets what no turn from `t` on needs.
    pub(crate) fn forget_before(&mut self, t: Stamp) {
        while self.knots.get(1).is_some_and(|second| second.t <= t) {
            self.knots.pop_front();
        }
    }

    /// The turn `body_a_from_body_b`; none where samples do not cover it.
    pub(crate) fn turn(&self, a: Stamp, b: Stamp) -> Option<UnitQuaternion<f64>> {
        let (from, to) = (self.at(a)?, self.at(b)?);
        (to.whole_since <= a).then(|| from.first_from_body.inverse() * to.first_from_body)
    }

    /// The mean rate between two instants \[rad/s\], of a gyroscope in whatever unit; none where samples do not cover it.
    pub(crate) fn mean_rate(&self, a: Stamp, b: Stamp) -> Option<Vector3<f64>> {
        let (from, to) = (self.at(a)?, self.at(b)?);
        (to.whole_since <= a).then(|| (to.angle - from.angle) / b.seconds_since(a))
    }

    /// Whether the rate is another at some time between two instants than at others: where it is not, a turn says nothing of when it was.
    pub(crate) fn varies(&self, a: Stamp, b: Stamp) -> bool {
        let part_s = b.seconds_since(a) / PARTS as f64;
        let at = |k: usize| a.plus_seconds(k as f64 * part_s);
        let rates: Vec<_> = (0..PARTS).filter_map(|k| self.mean_rate(at(k), at(k + 1))).collect();
        let mean = rates.iter().sum::<Vector3<f64>>() / rates.len().max(1) as f64;
        rates.iter().any(|rate| (rate - mean).norm() > LEAST_CHANGE)
    }

    /// The rate at `t` \[rad/s\].
    pub(crate) fn rate(&self, t: Stamp) -> Option<Vector3<f64>> {
        Some(self.at(t)?.rate)
    }

    /// What would stand in a knot at `t`.
    fn at(&self, t: Stamp) -> Option<Knot> {
        let next = self.knots.partition_point(|knot| knot.t <= t);
        let before = self.knots.get(next.checked_sub(1)?)?;
        let seconds = t.seconds_since(before.t);
        if seconds <= 0.0 {
            return Some(*before);
        }
        let after = self.knots.get(next)?;
        if after.whole_since == after.t {
            return None;
        }
        let share = seconds / after.t.seconds_since(before.t);
        let rate = before.rate + share * (after.rate - before.rate);
        let turned = 0.5 * (before.rate + rate) * seconds;
        Some(Knot {
            t,
            rate,
            angle: before.angle + turned,
            first_from_body: before.first_from_body * so3::exp(&turned),
            whole_since: before.whole_since,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn turns_are_those_of_the_rate_between_any_instants_and_none_goes_across_a_gap() {
        let rate = Vector3::new(0.6, -0.9, 1.7);
        let mut course = GyroCourse::default();
        let sample = |ms: i64| ImuSample {
            t: Stamp::from_ns(ms * 1_000_000),
            gyro: rate.into(),
            accel: [0.0, 0.0, 9.81],
        };
        (0..200).step_by(5).chain((400..600).step_by(5)).for_each(|ms| course.push(&sample(ms)));
        let at = |ms: f64| Stamp::from_ns((ms * 1e6) as i64);
        let turn = course.turn(at(12.3), at(187.7)).unwrap();
        assert!(turn.angle_to(&so3::exp(&(rate * 0.1754))) < 1e-12);
        assert!((course.rate(at(433.0)).unwrap() - rate).norm() < 1e-12);
        // Within a gap, across it, before all and after all.
        let gap = [(100.0, 300.0), (100.0, 450.0), (-1.0, 10.0), (590.0, 596.0), (300.0, 450.0)];
        assert!(gap.iter().all(|(a, b)| course.turn(at(*a), at(*b)).is_none()));
        assert!(course.turn(at(400.0), at(595.0)).is_some());
        course.forget_before(at(500.0));
        assert!(course.turn(at(500.0), at(595.0)).is_some() && course.turn(at(490.0), at(595.0)).is_none());
    }
}
