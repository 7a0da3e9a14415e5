//! What no IMU says while it works: values that stand still while stamps go on, and values that are no numbers.
//!
//! A sensor at rest flickers in its last bits: of the recordings that this was held against, none has all six values of the sample before more than once in a row,
//! but where a slower sensor is held on quicker rows. Samples that say what the one before said are held back until another comes, and after [`STILL_S`]
//! passed over: for the odometry it is a sensor that stopped, and no pose is made of it.

use dpn_core::{ImuSample, Stamp};

/// Equal samples over so long \[s\], and so many of them, are none.
const STILL_S: f64 = 1.0;
const FEWEST: usize = 10;
/// Samples without numbers, one after another, that are said while they come.
const SAID: usize = 50;

/// Samples on their way to the odometry.
#[derive(Debug, Default)]
pub(crate) struct Still {
    /// The first of equal ones, which went on, and those behind it.
    first: Option<ImuSample>,
    held: Vec<ImuSample>,
    stands: bool,
    /// The first that says something else, while it stands still: one alone is a bad reading.
    other: Option<ImuSample>,
    /// Those that are no numbers: how many, when the first came, and how many since the last that is.
    bad: usize,
    bad_from: Option<Stamp>,
    bad_since: usize,
    all: usize,
    words: Option<String>,
}

impl Still {
    /// Counts a sample that is no numbers.
    pub(crate) fn refuse(&mut self, t: Stamp) {
        self.bad_from.get_or_insert(t);
        (self.all, self.bad, self.bad_since) = (self.all + 1, self.bad + 1, self.bad_since + 1);
        if self.bad_since == SAID {
            self.words = self.trouble();
        }
    }

    /// Takes a sample of numbers; those that may go on before it, and whether it may.
    pub(crate) fn take(&mut self, sample: ImuSample) -> (Vec<ImuSample>, bool) {
        (self.all, self.bad_since) = (self.all + 1, 0);
        let says_the_same = |first: &ImuSample| (first.gyro, first.accel) == (sample.gyro, sample.accel);
        let Some(first) = self.first.filter(says_the_same) else {
            if self.stands && self.other.is_none() {
                self.other = Some(sample);
                return (Vec::new(), false);
            }
            self.first = Some(sample);
            return (self.end(), true);
        };
        self.other = None;
        self.held.push(sample);
        let for_s = sample.t.seconds_since(first.t);
        if self.stands || for_s >= STILL_S && self.held.len() >= FEWEST {
            self.held.clear();
            if !std::mem::replace(&mut self.stands, true) {
                self.words = self.trouble();
            }
        }
        (Vec::new(), false)
    }

    /// What is held back, where it is no sensor that stopped.
    pub(crate) fn end(&mut self) -> Vec<ImuSample> {
        self.stands = false;
        self.other.take().into_iter().chain(std::mem::take(&mut self.held)).collect()
    }

    /// What keeps samples from the odometry now.
    pub(crate) fn trouble(&self) -> Option<String> {
        if self.stands {
            return self.first.map(|first| {
                format!(
                    "the IMU's values stand still since {}: six that do not even flicker are no measurement, and no pose is made of them; look at its driver, bus and power",
                    first.t
                )
            });
        }
        (self.bad_since >= SAID).then(|| self.bad_words()).flatten()
    }

    /// How many samples were no numbers, once all have come.
    pub(crate) fn bad_words(&self) -> Option<String> {
        let Self { bad, all, .. } = *self;
        self.bad_from.map(|from| {
            format!(
                "{bad} of {all} IMU samples have NaN or infinite values, first at {from}: they are passed over; look at the driver, a failed read should be no sample"
            )
        })
    }

    /// What is to be said, once.
    pub(crate) fn take_words(&mut self) -> Option<String> {
        self.words.take()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sample(t_ms: i64, value: f64) -> ImuSample {
        ImuSample { t: Stamp::from_ns(t_ms * 1_000_000), gyro: [0.0; 3], accel: [0.0, value, 9.81] }
    }

    /// Stamps of what goes on, in milliseconds.
    fn through(still: &mut Still, samples: impl IntoIterator<Item = ImuSample>) -> Vec<i64> {
        let mut on = Vec::new();
        for sample in samples {
            let (before, goes) = still.take(sample);
            on.extend(before.into_iter().chain(goes.then_some(sample)).map(|s| s.t.ns() / 1_000_000));
        }
        on
    }

    #[test]
    fn values_that_stand_still_do_not_go_on_and_rows_that_hold_a_slower_sensor_do() {
        let mut still = Still::default();
        let held = (0..2000).step_by(5).map(|t| sample(t, f64::from((t / 900) as i32)));
        assert_eq!(through(&mut still, held), (0..1800).step_by(5).chain([1800]).collect::<Vec<_>>());
        assert_eq!((still.take_words(), still.trouble()), (None, None));
        let frozen = (2000..6000).step_by(5).map(|t| sample(t, 7.0));
        assert_eq!(
            through(&mut still, frozen),
            (1800..2000).step_by(5).skip(1).chain([2000]).collect::<Vec<_>>()
        );
        let words = still.take_words().unwrap();
        assert!(words.starts_with("the IMU's values stand still since 2000000000 ns: "), "{words}");
        assert_eq!((still.take_words(), still.trouble()), (None, Some(words)));
        // One that is wrong while it stands still does not end that.
        assert_eq!(through(&mut still, [sample(6000, 99.0), sample(6005, 7.0)]), [0; 0]);
        assert!(still.trouble().is_some());
        assert_eq!(through(&mut still, [sample(6010, 1.0), sample(6015, 1.1)]), [6010, 6015]);
        assert_eq!((still.trouble(), still.end()), (None, vec![]));
        // Few samples are no sign of it.
        let slow = (0..4).map(|k| sample(7000 + 500 * k, 3.0));
        assert_eq!(through(&mut still, slow), [7000]);
        assert_eq!(still.end().len(), 3);
    }

    #[test]
    fn samples_that_are_no_numbers_are_counted_and_said_while_nothing_else_comes() {
        let mut still = Still::default();
        (0..3).for_each(|t| still.refuse(Stamp::from_ns(t)));
        through(&mut still, [sample(1, 1.0)]);
        assert_eq!((still.take_words(), still.trouble()), (None, None));
        (5..205).for_each(|t| still.refuse(Stamp::from_ns(t)));
        assert!(still.take_words().unwrap().starts_with("53 of 54 IMU samples have NaN"));
        assert!(still.trouble().unwrap().starts_with("203 of 204 IMU samples have NaN"));
    }
}
