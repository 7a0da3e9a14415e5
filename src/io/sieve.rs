//! Keeps of somebody's samples what a recording may hold, and counts what it leaves out.
//!
//! The readers of this crate refuse a log with one bad row: what is trained on or judged must be whole. A tool that looks at anybody's
//! log must say what is wrong with it and go on. A sample is left out when a value of it is not finite or not between [`TINY`] and
//! [`ABSURD`] nor zero, when its stamp is that of the sample before, or when its stamp goes back.

use super::sample_store::SampleStore;
use dpn_core::Samples;
use dpn_core::imu::ImuSample;
use serde::Serialize;
use std::io;

/// Values beyond are no measurement in any unit, raw counts of 32 bits included; their squares would drown all others.
pub const ABSURD: f64 = 1e12;

/// Values nearer to zero are no measurement either: their squares are no numbers any more.
pub const TINY: f64 = 1e-150;

/// Samples left out for one reason.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize)]
pub struct LeftOut {
    /// How many.
    pub count: usize,
    /// Where the first was: a line of a text file, a message of a bag, both from 1.
    pub first: Option<u64>,
}

impl LeftOut {
    pub(super) fn add(&mut self, place: u64) {
        self.count += 1;
        self.first.get_or_insert(place);
    }
}

/// What of a log was left out, by reason.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize)]
pub struct Sieved {
    /// Samples with the stamp of the one before.
    pub repeated: LeftOut,
    /// Samples whose stamp goes back.
    pub backward: LeftOut,
    /// Samples with a value that is not finite.
    pub not_finite: LeftOut,
    /// Samples with a value beyond [`ABSURD`] or within [`TINY`] of zero.
    pub absurd: LeftOut,
}

impl Sieved {
    /// All that were left out.
    pub fn count(&self) -> usize {
        self.repeated.count + self.backward.count + self.not_finite.count + self.absurd.count
    }
}

fn is_absurd(sample: &ImuSample) -> bool {
    sample.gyro.iter().chain(&sample.accel).any(|v| v.abs() > ABSURD || (*v != 0.0 && v.abs() < TINY))
}

/// Takes samples as they come.
#[derive(Debug, Default)]
pub struct Sieve {
    kept: SampleStore,
    sieved: Sieved,
}

impl Sieve {
    /// Takes one sample that stands at `place` (see [`LeftOut::first`]); whether it is kept.
    pub fn push(&mut self, sample: ImuSample, place: u64) -> bool {
        let left = match self.kept.last() {
            _ if !sample.is_finite() => &mut self.sieved.not_finite,
            _ if is_absurd(&sample) => &mut self.sieved.absurd,
            Some(last) if sample.t == last => &mut self.sieved.repeated,
            Some(last) if sample.t < last => &mut self.sieved.backward,
            _ => {
                self.kept.push(sample);
                return true;
            }
        };
        left.add(place);
        false
    }

    /// Counts a sample that could not even be made, for a value that is not finite.
    pub fn not_finite(&mut self, place: u64) {
        self.sieved.not_finite.add(place);
    }

    /// Whether none was kept yet.
    pub fn is_empty(&self) -> bool {
        self.kept.is_empty()
    }

    /// The samples kept, in increasing time and finite, and what was left out.
    ///
    /// # Errors
    /// A temporary file that could not be written.
    pub fn done(self) -> io::Result<(SampleStore, Sieved)> {
        Ok((self.kept.done()?, self.sieved))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use dpn_core::time::Stamp;

    #[test]
    fn each_fault_is_counted_under_its_name_and_the_rest_is_a_recording() {
        let mut sieve = Sieve::default();
        let mut push = |t: i64, value: f64, place: u64| {
            sieve.push(ImuSample { t: Stamp::from_ns(t), gyro: [0.0; 3], accel: [value; 3] }, place);
        };
        for (place, (t, value)) in [
            (5, 1.0),
            (10, 1.0),
            (10, 2.0),
            (7, 1.0),
            (15, f64::NAN),
            (15, 3.0),
            (15, 4.0),
            (20, 1e30),
            (20, -5e-324),
        ]
        .into_iter()
        .enumerate()
        {
            push(t, value, place as u64 + 1);
        }
        let (samples, sieved) = sieve.done().unwrap();
        let samples = samples.piece(0..samples.len()).unwrap().into_owned();
        assert_eq!(samples.iter().map(|s| s.t.ns()).collect::<Vec<_>>(), [5, 10, 15]);
        assert_eq!(samples[2].accel, [3.0; 3]);
        assert_eq!(sieved.repeated, LeftOut { count: 2, first: Some(3) });
        assert_eq!(sieved.backward, LeftOut { count: 1, first: Some(4) });
        assert_eq!(sieved.not_finite, LeftOut { count: 1, first: Some(5) });
        assert_eq!(sieved.absurd, LeftOut { count: 2, first: Some(8) });
        assert!(dpn_core::imu::ImuRecording::new(samples).is_ok());
    }
}
