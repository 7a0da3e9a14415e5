//! The topics of IMUs that speak now, and whose samples are handed on: the only one with both sensors, or two with one each, joined.
//!
//! A RealSense and its like write each sensor on a topic of its own, the other's values zero. So what says nothing of one sensor is held back until it is
//! known whether another topic speaks of that; afterwards it is what [`crate::read_log`] makes of the same bag, as far as that can be known before its end.

use crate::fields::Encoding;
use crate::live_join::LiveJoin;
use crate::topics::Speaks;
use dpn_core::{ImuSample, Sensor};
use std::collections::HashMap;

/// Samples of one sensor after which nobody waits for the other: two seconds at 200 Hz. A gyroscope at rest may read exactly zero.
const ALONE: usize = 400;

/// Several topics that could be meant.
#[derive(Debug)]
pub(crate) struct Several {
    pub(crate) one: String,
    pub(crate) topics: String,
    pub(crate) count: usize,
}

/// A topic.
#[derive(Debug)]
struct Source {
    name: String,
    encoding: Encoding,
    /// Of which sensors it speaks.
    speaks: Speaks,
    /// What is held back.
    held: Vec<ImuSample>,
}

/// Whose samples are handed on.
#[derive(Debug, Clone, Copy)]
enum Chosen {
    One(usize),
    Pair { gyro: usize, accel: usize },
}

/// The topics of IMUs.
#[derive(Debug, Default)]
pub(crate) struct LiveImus {
    all: Vec<Source>,
    numbers: HashMap<u32, usize>,
    chosen: Option<Chosen>,
    join: LiveJoin,
}

impl LiveImus {
    pub(crate) fn next_file(&mut self) {
        self.numbers.clear();
    }

    /// The number means another topic from here on.
    pub(crate) fn forget(&mut self, number: u32) {
        self.numbers.remove(&number);
    }

    pub(crate) fn declare(&mut self, number: u32, name: String, encoding: Encoding) {
        let known = self.all.iter().position(|source| source.name == name);
        let index = known.unwrap_or_else(|| {
            self.all.push(Source { name, encoding, speaks: Speaks::default(), held: Vec::new() });
            self.all.len() - 1
        });
        self.numbers.insert(number, index);
    }

    /// The topic of a number: its place, name and encoding.
    pub(crate) fn topic(&self, number: u32) -> Option<(usize, &str, Encoding)> {
        let &index = self.numbers.get(&number)?;
        let Source { name, encoding, .. } = &self.all[index];
        Some((index, name, *encoding))
    }

    pub(crate) fn is_chosen(&self) -> bool {
        self.chosen.is_some()
    }

    /// Takes a sample of the topic at `index`; returns those that are to be handed on now.
    ///
    /// # Errors
    /// Two topics could be meant.
    pub(crate) fn take(&mut self, index: usize, sample: ImuSample) -> Result<Vec<ImuSample>, Several> {
        self.all[index].speaks.hear(&sample);
        match self.chosen {
            Some(Chosen::One(one)) if one == index => Ok(vec![sample]),
            // Beside a topic that has both sensors, those with one are no choice.
            Some(Chosen::One(one)) if self.all[index].speaks.are_both() => Err(self.several(&[one, index])),
            Some(Chosen::One(_)) => Ok(Vec::new()),
            Some(Chosen::Pair { gyro, accel }) => {
                let sensor = match index {
                    _ if index == gyro => Sensor::Gyro,
                    _ if index == accel => Sensor::Accel,
                    _ => return Err(self.several(&[gyro, accel, index])),
                };
                Ok(self.joined(sensor, [sample]))
            }
            None => {
                self.all[index].held.push(sample);
                self.decide(index)
            }
        }
    }

    /// Nothing more comes: what is held back of an only topic is handed on.
    pub(crate) fn end(&mut self) -> Vec<ImuSample> {
        let held: Vec<usize> = (0..self.all.len()).filter(|&i| !self.all[i].held.is_empty()).collect();
        match (self.chosen, &held[..]) {
            (None, [only]) => self.alone(*only),
            _ => Vec::new(),
        }
    }

    /// Whether it is known by now who is to be heard, the topic at `index` having spoken.
    fn decide(&mut self, index: usize) -> Result<Vec<ImuSample>, Several> {
        let own = self.all[index].speaks.half();
        if self.all[index].speaks.are_both() {
            return Ok(self.alone(index));
        }
        let others = (0..self.all.len()).filter(|&i| i != index && !self.all[i].held.is_empty());
        let (mut same, mut counterpart) = (None, None);
        for other in others {
            match (own, self.all[other].speaks.half()) {
                (Some(own), Some(half)) if own == half => same = Some(other),
                (Some(_), Some(_)) => counterpart = Some(other),
                _ => {}
            }
        }
        if let Some(same) = same {
            return Err(self.several(&[same, index]));
        }
        if let (Some(sensor), Some(other)) = (own, counterpart) {
            let (gyro, accel) = if sensor == Sensor::Gyro { (index, other) } else { (other, index) };
            self.chosen = Some(Chosen::Pair { gyro, accel });
            let [gyro, accel] = [gyro, accel].map(|i| std::mem::take(&mut self.all[i].held));
            let mut samples = self.joined(Sensor::Gyro, gyro);
            samples.extend(self.joined(Sensor::Accel, accel));
            return Ok(samples);
        }
        Ok(if self.all[index].held.len() >= ALONE { self.alone(index) } else { Vec::new() })
    }

    fn alone(&mut self, index: usize) -> Vec<ImuSample> {
        self.chosen = Some(Chosen::One(index));
        std::mem::take(&mut self.all[index].held)
    }

    fn joined(&mut self, sensor: Sensor, samples: impl IntoIterator<Item = ImuSample>) -> Vec<ImuSample> {
        samples.into_iter().for_each(|sample| self.join.take(sensor, sample));
        std::iter::from_fn(|| self.join.next()).collect()
    }

    fn several(&self, which: &[usize]) -> Several {
        let names: Vec<&str> = which.iter().map(|&i| self.all[i].name.as_str()).collect();
        Several { one: names[0].to_owned(), topics: names.join(", "), count: names.len() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use dpn_core::Stamp;

    fn at(ms: i64, gyro: f64, accel: f64) -> ImuSample {
        ImuSample { t: Stamp::from_ns(ms * 1_000_000), gyro: [gyro; 3], accel: [accel; 3] }
    }

    fn of(names: &[&str]) -> LiveImus {
        let mut imus = LiveImus::default();
        for (number, name) in (0..).zip(names) {
            imus.declare(number, (*name).to_owned(), Encoding::Ros1);
        }
        imus
    }

    #[test]
    fn a_whole_imu_is_heard_at_once_and_another_one_is_a_choice() {
        let mut imus = of(&["/imu", "/other"]);
        assert_eq!(imus.take(0, at(0, 0.1, 9.8)).unwrap(), [at(0, 0.1, 9.8)]);
        assert_eq!(imus.take(1, at(1, 0.0, 9.8)).unwrap(), [], "half an IMU beside a whole one is none");
        let several = imus.take(1, at(2, 0.1, 9.8)).unwrap_err();
        assert_eq!((several.one.as_str(), several.topics.as_str()), ("/imu", "/imu, /other"));
    }

    #[test]
    fn two_halves_are_joined_in_either_order_and_nothing_that_came_before_is_lost() {
        for first in [0, 1] {
            let mut imus = of(&["/camera/gyro", "/camera/accel"]);
            let mut found = Vec::new();
            for k in 0..20 {
                for index in [first, 1 - first] {
                    let sample =
                        if index == 0 { at(5 * k, 0.1, 0.0) } else { at(5 * k, 0.0, k as f64 + 1.0) };
                    found.extend(imus.take(index, sample).unwrap());
                }
            }
            let expected: Vec<ImuSample> = (0..20).map(|k| at(5 * k, 0.1, k as f64 + 1.0)).collect();
            assert_eq!(found, expected);
        }
    }

    #[test]
    fn who_stays_alone_is_heard_after_a_while_and_two_of_a_kind_are_a_choice() {
        let mut imus = of(&["/imu"]);
        let heard: Vec<ImuSample> = (0..500).flat_map(|k| imus.take(0, at(k, 0.0, 9.8)).unwrap()).collect();
        assert_eq!(heard.len(), 500);
        let mut imus = of(&["/a/gyro", "/b/gyro"]);
        assert_eq!(imus.take(0, at(0, 0.1, 0.0)).unwrap(), []);
        assert_eq!(imus.take(1, at(1, 0.1, 0.0)).unwrap_err().count, 2);
        let mut imus = of(&["/short"]);
        assert_eq!(imus.take(0, at(0, 0.0, 9.8)).unwrap(), []);
        assert_eq!((imus.end(), imus.is_chosen()), (vec![at(0, 0.0, 9.8)], true));
    }
}
