//! How far the body turned between two images, from gyroscope samples.

use dpn_core::geometry::so3;
use dpn_core::{ImuSample, Stamp};
use nalgebra::{UnitQuaternion, Vector3};
use std::collections::VecDeque;

/// Samples may end this long before an image \[s\]; the last is held until then. EuRoC's come every .005 s.
const HELD_S: f64 = 0.02;
/// Samples are kept so long for an image that may come \[s\]; while no camera speaks, memory does not grow.
const KEPT_S: f64 = 600.0;

/// Gyroscope samples between images, integrated from image to image.
///
/// Rates are joined linearly between samples, `last_from_cur = Exp(w_1 dt_1) Exp(w_2 dt_2) ...` with the mean of neighbouring rates.
/// Samples are kept until [`forget_before`](Self::forget_before) says that none will need them, ten minutes at most.
#[derive(Debug, Clone, Default)]
pub(crate) struct GyroTurn {
    samples: VecDeque<(Stamp, Vector3<f64>)>,
    from: Option<Stamp>,
}

impl GyroTurn {
    /// Nothing yet.
    pub(crate) fn new() -> Self {
        Self::default()
    }

    /// Takes a sample; one that is not later than the last, or holds no number, is passed over.
    pub(crate) fn feed(&mut self, sample: &ImuSample) {
        let later = self.samples.back().is_none_or(|(t, _)| *t < sample.t);
        if later && sample.is_finite() {
            while self.samples.front().is_some_and(|(t, _)| sample.t.seconds_since(*t) > KEPT_S) {
                self.samples.pop_front();
            }
            self.samples.push_back((sample.t, Vector3::from(sample.gyro)));
        }
    }

    /// The turn from the image before to the one at `t`, `body_last_from_body_cur`, the gyroscope's bias in it.
    ///
    /// `None` at the first image, after one that is not later than the one before, and where samples do not cover the time between.
    pub(crate) fn until(&mut self, t: Stamp) -> Option<UnitQuaternion<f64>> {
        let from = self.from.filter(|from| *from < t);
        self.from = Some(self.from.map_or(t, |from| from.max(t)));
        from.and_then(|from| self.integrate(from, t))
    }

    /// Takes the last image to have been at another instant by this much: its clock was found to be off.
    pub(crate) fn move_last(&mut self, seconds: f64) {
        self.from = self.from.map(|from| from.plus_seconds(seconds));
    }

    /// How the body turned while an image at `t` was read out: `body_at_t_from_body_then` at evenly spaced instants of `readout_s` about `t`.
    /// `None` where samples do not cover it.
    pub(crate) fn over<const N: usize>(&self, t: Stamp, readout_s: f64) -> Option<[UnitQuaternion<f64>; N]> {
        let mut turns = [UnitQuaternion::identity(); N];
        for (k, turn) in turns.iter_mut().enumerate() {
            let then = t.plus_seconds(readout_s * (k as f64 / (N - 1) as f64 - 0.5));
            *turn = if then < t { self.integrate(then, t)?.inverse() } else { self.integrate(t, then)? };
        }
        Some(turns)
    }

    /// Forgets samples that no turn from `t` on needs: all before the last that is not after it.
    pub(crate) fn forget_before(&mut self, t: Stamp) {
        while self.samples.get(1).is_some_and(|(second, _)| *second <= t) {
            self.samples.pop_front();
        }
    }

    /// The turn `body_at_from_from_body_at_to`, the gyroscope's bias in it; `None` where samples do not cover it.
    pub(crate) fn integrate(&self, from: Stamp, to: Stamp) -> Option<UnitQuaternion<f64>> {
        let (first, last) = (self.samples.front()?, self.samples.back()?);
        if first.0 > from || to.seconds_since(last.0) > HELD_S {
            return None;
        }
        let mut turn = UnitQuaternion::identity();
        let mut step = |a: (Stamp, Vector3<f64>), b: (Stamp, Vector3<f64>)| {
            turn *= so3::exp(&(0.5 * (a.1 + b.1) * b.0.seconds_since(a.0)));
        };
        let mut at = (from, self.rate(from)?);
        for sample in self.samples.iter().filter(|(t, _)| (from..to).contains(t)) {
            step(at, *sample);
            at = *sample;
        }
        step(at, (to, self.rate(to)?));
        Some(turn)
    }

    /// The rate at `t`, between two samples or held after the last.
    fn rate(&self, t: Stamp) -> Option<Vector3<f64>> {
        let next = self.samples.partition_point(|(sample, _)| *sample <= t);
        let before = self.samples.get(next.checked_sub(1)?)?;
        let Some(after) = self.samples.get(next) else { return Some(before.1) };
        let share = t.seconds_since(before.0) / after.0.seconds_since(before.0);
        Some(before.1 + share * (after.1 - before.1))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sample(ns: i64, gyro: [f64; 3]) -> ImuSample {
        ImuSample { t: Stamp::from_ns(ns), gyro, accel: [0.0, 0.0, 9.81] }
    }

    #[test]
    fn turns_add_up_to_the_body_s_rotation() {
        // A steady turn about a tilted axis.
        let axis = Vector3::new(0.6, -0.9, 1.7);
        let mut gyro = GyroTurn::new();
        let mut sum = UnitQuaternion::identity();
        let mut image = 3_000_000;
        for i in 0..400i64 {
            gyro.feed(&sample(5_000_000 * i, axis.into()));
            // Images 47.3 ms apart, between samples, each asked for two samples later.
            if 5_000_000 * i > image + 10_000_000 {
                let turn = gyro.until(Stamp::from_ns(image));
                assert_eq!(turn.is_none(), image == 3_000_000);
                sum *= turn.unwrap_or_else(UnitQuaternion::identity);
                gyro.forget_before(Stamp::from_ns(image));
                image += 47_300_000;
            }
        }
        let seconds = (image - 47_300_000 - 3_000_000) as f64 * 1e-9;
        assert!(seconds > 1.8 && sum.angle_to(&so3::exp(&(axis * seconds))) < 1e-12);
        assert!(gyro.samples.len() < 16, "{}", gyro.samples.len());
    }

    #[test]
    fn rates_between_samples_are_joined_linearly() {
        let mut gyro = GyroTurn::new();
        for i in 0..21i64 {
            gyro.feed(&sample(5_000_000 * i, [0.0, 0.0, 0.01 * i as f64]));
        }
        assert_eq!(gyro.until(Stamp::from_ns(7_500_000)), None);
        let turn = gyro.until(Stamp::from_ns(92_500_000)).unwrap();
        // The rate is 2 t: the angle is t1^2 - t0^2.
        assert!((so3::log(&turn).z - (0.0925f64.powi(2) - 0.0075f64.powi(2))).abs() < 1e-12);
    }

    #[test]
    fn samples_wait_for_images_however_late_and_go_when_none_will_need_them() {
        let turned = |ahead: i64| {
            let mut gyro = GyroTurn::new();
            let mut turns = Vec::new();
            let samples = |i: i64| sample(5_000_000 * i, [0.001 * (i % 97) as f64; 3]);
            (0..ahead).for_each(|i| gyro.feed(&samples(i)));
            for i in 0..10_000 {
                gyro.feed(&samples(i.max(ahead)));
                if i % 10 == 0 {
                    turns.push(gyro.until(Stamp::from_ns(5_000_000 * i - 2_000_000)));
                }
            }
            turns
        };
        assert_eq!(turned(0), turned(9_999), "50 s of samples before the first image");
        let mut gyro = GyroTurn::new();
        for i in 0..10_000 {
            gyro.feed(&sample(5_000_000 * i, [0.1; 3]));
            gyro.forget_before(Stamp::from_ns(5_000_000 * i - 2_000_000));
        }
        assert_eq!(gyro.samples.len(), 2);
    }

    #[test]
    fn samples_wait_ten_minutes_for_an_image_and_no_longer() {
        let mut gyro = GyroTurn::new();
        let at = |s: i64| Stamp::from_ns(1_000_000_000 * s);
        gyro.feed(&sample(0, [0.0; 3]));
        assert_eq!(gyro.until(at(0)), None);
        (1..=500).for_each(|s| gyro.feed(&sample(at(s).ns(), [0.0; 3])));
        assert!(gyro.until(at(500)).is_some());
        (501..5_000).for_each(|s| gyro.feed(&sample(at(s).ns(), [0.0; 3])));
        assert_eq!(gyro.samples.len(), 601);
        assert_eq!(gyro.until(at(4_999)), None, "its beginning is gone");
    }

    #[test]
    fn the_turns_of_a_readout_join_to_the_turn_over_it() {
        let mut gyro = GyroTurn::new();
        for i in 0..40i64 {
            gyro.feed(&sample(5_000_000 * i, [0.3, -0.1 * i as f64, 1.2]));
        }
        let t = Stamp::from_ns(101_000_000);
        let turns: [_; 7] = gyro.over(t, 0.03).unwrap();
        assert_eq!(turns[3], UnitQuaternion::identity());
        let all = gyro.integrate(t.plus_seconds(-0.015), t.plus_seconds(0.015)).unwrap();
        assert!((turns[0].inverse() * turns[6]).angle_to(&all) < 1e-4 && all.angle() > 0.03);
        assert_eq!(gyro.over::<7>(Stamp::from_ns(5_000_000), 0.03), None, "samples begin later");
    }

    #[test]
    fn time_without_samples_has_no_turn() {
        let mut gyro = GyroTurn::new();
        let at = |ms: i64| Stamp::from_ns(1_000_000 * ms);
        assert_eq!(gyro.until(at(0)), None);
        for ms in (5..100).step_by(5) {
            gyro.feed(&sample(1_000_000 * ms, [0.1; 3]));
        }
        gyro.feed(&sample(50_000_000, [f64::NAN; 3]));
        assert_eq!(gyro.until(at(50)), None, "the first sample is later than the first image");
        assert!(gyro.until(at(100)).is_some(), "held for 5 ms");
        assert_eq!(gyro.until(at(90)), None, "back in time");
        assert_eq!(gyro.until(at(200)), None, "105 ms without a sample");
    }
}
