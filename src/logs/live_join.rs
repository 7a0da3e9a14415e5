//! Accelerometer and gyroscope that speak apart and now, joined on the gyroscope's stamps.

use crate::join::{APART_S, accel_at};
use dpn_core::{ImuSample, Sensor};
use std::collections::VecDeque;

/// Makes a sample as soon as the accelerometer has passed it. Neighbours may be [`APART_S`] apart, whatever their usual step.
#[derive(Debug, Default)]
pub(crate) struct LiveJoin {
    gyro: VecDeque<ImuSample>,
    /// The last one that every gyroscope's sample to come is behind, and what followed.
    accel: VecDeque<ImuSample>,
}

impl LiveJoin {
    /// Samples that one sensor may be ahead of the other: minutes.
    const MOST: usize = 1 << 16;

    /// Takes a sample of one of the sensors. One that goes back is passed over.
    pub(crate) fn take(&mut self, sensor: Sensor, sample: ImuSample) {
        let queue = match sensor {
            Sensor::Gyro => &mut self.gyro,
            Sensor::Accel => &mut self.accel,
        };
        if queue.back().is_none_or(|last| last.t < sample.t) {
            queue.push_back(sample);
        }
        // Of a sensor that fell silent nothing is made up.
        if queue.len() > Self::MOST {
            queue.pop_front();
        }
    }

    /// The next sample of both.
    pub(crate) fn next(&mut self) -> Option<ImuSample> {
        while let Some(&ImuSample { t, gyro, .. }) = self.gyro.front() {
            while self.accel.get(1).is_some_and(|second| second.t < t) {
                self.accel.pop_front();
            }
            let (first, second) = (self.accel.front()?, self.accel.get(1));
            let neighbours = if first.t < t { (Some(first), Some(second?)) } else { (None, Some(first)) };
            let accel = accel_at(t, neighbours, APART_S);
            self.gyro.pop_front();
            if let Some(accel) = accel {
                return Some(ImuSample { t, gyro, accel });
            }
        }
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::join::join;
    use dpn_core::{Samples, Stamp};

    fn at(ms: i64, value: f64) -> ImuSample {
        ImuSample { t: Stamp::from_ns(ms * 1_000_000), gyro: [value; 3], accel: [value; 3] }
    }

    #[test]
    fn what_is_joined_as_it_comes_is_what_is_joined_afterwards() {
        let gyro: Vec<ImuSample> = (0..200).map(|i| at(5 * i, -1.0)).collect();
        let mut accel: Vec<ImuSample> = (0..60).map(|i| at(13 + 16 * i, (i as f64).sin())).collect();
        accel.drain(20..40);
        let joined = join(&&gyro[..], &&accel[..]).unwrap();
        let expected = joined.samples.piece(0..joined.samples.len()).unwrap().into_owned();
        // One sensor a whole block behind the other, either way.
        for (one, other) in [(17, 5), (3, 11)] {
            let (mut live, mut found) = (LiveJoin::default(), Vec::new());
            let (mut gyro, mut accel) = (gyro.chunks(one), accel.chunks(other));
            loop {
                let (some, others) = (gyro.next(), accel.next());
                for sample in some.into_iter().flatten() {
                    live.take(Sensor::Gyro, *sample);
                }
                for sample in others.into_iter().flatten() {
                    live.take(Sensor::Accel, *sample);
                }
                found.extend(std::iter::from_fn(|| live.next()));
                if some.is_none() && others.is_none() {
                    break;
                }
            }
            assert_eq!(found, expected);
        }
    }
}
