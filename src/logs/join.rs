//! Accelerometer and gyroscope that were recorded apart, joined on the gyroscope's stamps.
//!
//! The accelerometer is interpolated linearly between its two neighbours. That averages its noise: of white noise two thirds of the power are
//! left where the rates have no common divisor, so a deviation reads up to 18 % low; [`Joined::remark`] says so.

use dpn_core::signal::ranks::{Column, Level, levels};
use dpn_core::{ImuSample, Samples, Stamp};
use dpn_io::SampleStore;
use std::io;

/// Between neighbours further apart than so many of their usual steps nothing is made up.
const STEPS: f64 = 5.0;
/// Nor further apart than this, where that is more \[s\].
pub(crate) const APART_S: f64 = 0.1;

/// Six axes.
#[derive(Debug)]
pub(crate) struct Joined {
    pub(crate) samples: SampleStore,
    /// Gyroscope samples without an accelerometer's on both sides, near enough.
    pub(crate) left_out: usize,
    gyro_hz: f64,
    accel_hz: f64,
}

/// The usual step \[s\]; infinite where there is none.
fn step(samples: &dyn Samples) -> io::Result<f64> {
    let count = samples.len().saturating_sub(1);
    let step = levels(&[Column { count, levels: &[Level::UpperMedian] }], |take| {
        samples.pairs(&mut |a, b| take(0, b.t.seconds_since(a.t)))
    })?;
    Ok(if count == 0 { f64::INFINITY } else { step[0][0] })
}

/// One sample after the other.
struct Walk<'a> {
    samples: &'a dyn Samples,
    piece: Vec<ImuSample>,
    /// Place of the piece's first, and of the next one.
    first: usize,
    next: usize,
}

impl Walk<'_> {
    /// Samples read at a time.
    const MANY: usize = 4096;

    fn peek(&mut self) -> io::Result<Option<ImuSample>> {
        if self.next >= self.first + self.piece.len() && self.next < self.samples.len() {
            let end = (self.next + Self::MANY).min(self.samples.len());
            self.piece = self.samples.piece(self.next..end)?.into_owned();
            self.first = self.next;
        }
        Ok(self.piece.get(self.next - self.first).copied())
    }
}

/// The accelerometer at `t` from its neighbours before and at or behind that, no further apart than `apart_s`.
pub(crate) fn accel_at(
    t: Stamp,
    (before, after): (Option<&ImuSample>, Option<&ImuSample>),
    apart_s: f64,
) -> Option<[f64; 3]> {
    match (before, after) {
        (_, Some(after)) if after.t == t => Some(after.accel),
        (Some(before), Some(after)) => {
            let gap = after.t.seconds_since(before.t);
            let share = t.seconds_since(before.t) / gap;
            let between = |axis: usize| before.accel[axis] * (1.0 - share) + after.accel[axis] * share;
            (gap <= apart_s).then(|| std::array::from_fn(between))
        }
        _ => None,
    }
}

/// Takes the gyroscope's axes from the one and the accelerometer's from the other, both in increasing time.
///
/// # Errors
/// A temporary file that cannot be read or written.
pub(crate) fn join(gyro: &dyn Samples, accel: &dyn Samples) -> io::Result<Joined> {
    let (gyro_step, accel_step) = (step(gyro)?, step(accel)?);
    let apart = (STEPS * accel_step).max(APART_S);
    let mut samples = SampleStore::default();
    let mut walk = Walk { samples: accel, piece: Vec::new(), first: 0, next: 0 };
    let mut before: Option<ImuSample> = None;
    gyro.pieces(0..gyro.len(), Walk::MANY, &mut |piece| {
        for sample in piece {
            while let Some(passed) = walk.peek()?.filter(|a| a.t < sample.t) {
                before = Some(passed);
                walk.next += 1;
            }
            if let Some(accel) = accel_at(sample.t, (before.as_ref(), walk.peek()?.as_ref()), apart) {
                samples.push(ImuSample { t: sample.t, gyro: sample.gyro, accel });
            }
        }
        Ok(())
    })?;
    let samples = samples.done()?;
    let left_out = gyro.len() - samples.len();
    Ok(Joined { samples, left_out, gyro_hz: 1.0 / gyro_step, accel_hz: 1.0 / accel_step })
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

    fn at(ms: i64, value: f64) -> ImuSample {
        ImuSample { t: Stamp::from_ns(ms * 1_000_000), gyro: [value; 3], accel: [value; 3] }
    }

    #[test]
    fn values_lie_on_the_line_between_neighbours_and_nothing_is_made_up_outside_or_in_holes() {
        let gyro: Vec<ImuSample> = (0..200).map(|i| at(5 * i, -1.0)).collect();
        let mut accel: Vec<ImuSample> =
            (0..60).map(|i| at(13 + 16 * i, 0.5 * (13 + 16 * i) as f64)).collect();
        let join = |gyro: &[ImuSample], accel: &[ImuSample]| {
            let joined = super::join(&gyro, &accel).unwrap();
            let samples = joined.samples.piece(0..joined.samples.len()).unwrap().into_owned();
            (samples, joined.left_out)
        };
        let (samples, left_out) = join(&gyro, &accel);
        assert_eq!(samples.len() + left_out, 200);
        for s in &samples {
            assert!((s.accel[1] - 0.5 * s.t.ns() as f64 * 1e-6).abs() < 1e-9 && s.gyro == [-1.0; 3]);
        }
        assert_eq!((samples[0].t.ns(), left_out), (15_000_000, 3 + 8));
        // A hole of 20 steps.
        accel.drain(20..40);
        let (_, left_out) = join(&gyro, &accel);
        assert!((left_out as f64 - 11.0 - 21.0 * 16.0 / 5.0).abs() < 2.0, "{left_out}");
        assert!(join(&gyro, &[]).0.is_empty() && join(&[], &accel).0.is_empty());
    }
}
