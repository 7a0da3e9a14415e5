//! Accelerometer and gyroscope that were recorded apart, joined on the gyroscope's stamps.
//!
//! The accelerometer is interpolated linearly between its two neighbours. That averages its noise: of white noise two thirds of the power are
//! left where the rates have no common divisor, so a deviation reads up to 18 % low; [`Joined::remark`] says so.

use dpn_core::ImuSample;
use dpn_core::signal::stats::upper_median;

/// Between neighbours further apart than so many of their usual steps nothing is made up.
const STEPS: f64 = 5.0;
/// Nor further apart than this, where that is more \[s\].
const APART_S: f64 = 0.1;

/// Six axes.
#[derive(Debug)]
pub(crate) struct Joined {
    pub(crate) samples: Vec<ImuSample>,
    /// Gyroscope samples without an accelerometer's on both sides, near enough.
    pub(crate) left_out: usize,
    gyro_hz: f64,
    accel_hz: f64,
}

fn step(samples: &[ImuSample]) -> f64 {
    upper_median(samples.windows(2).map(|w| w[1].t.seconds_since(w[0].t))).unwrap_or(f64::INFINITY)
}

/// Takes the gyroscope's axes from the one and the accelerometer's from the other, both in increasing time.
pub(crate) fn join(gyro: &[ImuSample], accel: &[ImuSample]) -> Joined {
    let (gyro_step, accel_step) = (step(gyro), step(accel));
    let apart = (STEPS * accel_step).max(APART_S);
    let mut samples = Vec::with_capacity(gyro.len());
    let mut next = 0;
    for sample in gyro {
        while accel.get(next).is_some_and(|a| a.t < sample.t) {
            next += 1;
        }
        let interpolated = match (next.checked_sub(1).map(|before| &accel[before]), accel.get(next)) {
            (_, Some(after)) if after.t == sample.t => Some(after.accel),
            (Some(before), Some(after)) => {
                let gap = after.t.seconds_since(before.t);
                let share = sample.t.seconds_since(before.t) / gap;
                let between = |axis: usize| before.accel[axis] * (1.0 - share) + after.accel[axis] * share;
                (gap <= apart).then(|| std::array::from_fn(between))
            }
            _ => None,
        };
        samples.extend(interpolated.map(|accel| ImuSample { t: sample.t, gyro: sample.gyro, accel }));
    }
    let left_out = gyro.len() - samples.len();
    Joined { samples, left_out, gyro_hz: 1.0 / gyro_step, accel_hz: 1.0 / accel_step }
}

impl Joined {
    /// What was done, in one line.
    pub(crate) fn remark(&self, gyro: &str, accel: &str) -> String {
        let Self { gyro_hz, accel_hz, .. } = self;
        format!(
            "accelerometer from {accel} ({accel_hz:.1} Hz), interpolated onto the stamps of {gyro} ({gyro_hz:.1} Hz): \
             its white noise reads up to 18 % low"
        )
    }

    /// What was left out, where something was.
    pub(crate) fn left_out(&self) -> Option<String> {
        (self.left_out > 0).then(|| {
            format!("left out: {} gyroscope sample(s) with no accelerometer beside them", self.left_out)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use dpn_core::Stamp;

    fn at(ms: i64, value: f64) -> ImuSample {
        ImuSample { t: Stamp::from_ns(ms * 1_000_000), gyro: [value; 3], accel: [value; 3] }
    }

    #[test]
    fn values_lie_on_the_line_between_neighbours_and_nothing_is_made_up_outside_or_in_holes() {
        let gyro: Vec<ImuSample> = (0..200).map(|i| at(5 * i, -1.0)).collect();
        let mut accel: Vec<ImuSample> =
            (0..60).map(|i| at(13 + 16 * i, 0.5 * (13 + 16 * i) as f64)).collect();
        let whole = join(&gyro, &accel);
        assert_eq!(whole.samples.len() + whole.left_out, 200);
        for s in &whole.samples {
            assert!((s.accel[1] - 0.5 * s.t.ns() as f64 * 1e-6).abs() < 1e-9 && s.gyro == [-1.0; 3]);
        }
        assert_eq!((whole.samples[0].t.ns(), whole.left_out), (15_000_000, 3 + 8));
        // A hole of 20 steps.
        accel.drain(20..40);
        let holed = join(&gyro, &accel);
        assert!((holed.left_out as f64 - 11.0 - 21.0 * 16.0 / 5.0).abs() < 2.0, "{}", holed.left_out);
        assert!(join(&gyro, &[]).samples.is_empty() && join(&[], &accel).samples.is_empty());
    }
}
