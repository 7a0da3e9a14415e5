//! Whether what an estimator says of a second at a time can be the noise, by the spectrum of many.
//!
//! Nothing that looks at one second sees through a low pass, and a network may be off where it was not trained. The mean spectrum of many seconds tells both: where it falls as
//! behind a low pass, what the noise is between; where it is flat, what it is. A stream sees the last half to whole minute, a recording all of it.

use super::{Fall, LowPassSight, MOTION_HZ, Seen};
use crate::imu::{ImuSample, Sensor};
use crate::noise::ImuNoise;
use crate::signal::Welch;
use crate::time::SampleRate;

/// Within this factor of an interval an answer agrees with it.
const AGREES: f64 = 1.15;
/// An answer that is further than this factor from a flat spectrum says another noise.
const APART: f64 = 1.25;
/// Rates of fewer times [`MOTION_HZ`] hold too little above motion: a flight's figure at 100 Hz is twice the same at 200, at 50 Hz ten times. Motion may pass for a flat
/// spectrum there, so that less than it is no contradiction.
pub const SLOWEST: f64 = 3.5;
/// Seconds in each of the two halves that a stream looks back on, from one look to the next, and before the first.
const HALF: usize = 30;
const EVERY: usize = 10;
const LEAST: usize = 10;

/// Why an answer is not known to be the noise.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Doubt {
    /// The sensor.
    pub sensor: Sensor,
    /// What was said: the deviation of one sample, of the loudest axis or of the one that is furthest off.
    pub said: f64,
    /// Why.
    pub why: Why,
}

/// What speaks against an answer. The noise is between two deviations of one sample, where the spectrum tells.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Why {
    /// The spectrum falls as behind a low pass.
    Falls {
        /// Which.
        fall: Fall,
        /// What the noise is between.
        between: [f64; 2],
    },
    /// It is as flat as noise, and of another level.
    Flat {
        /// What the noise is between.
        between: [f64; 2],
    },
    /// The rate leaves too little of it above motion, so that nothing confirms an answer.
    Slow {
        /// The rate \[Hz\].
        rate_hz: f64,
    },
}

impl Doubt {
    /// What `seen` has against deviations of one sample, x, y, z, at `rate`; none where they agree, or where it tells nothing.
    pub fn of(sensor: Sensor, said: [f64; 3], seen: &Seen, rate: SampleRate) -> Option<Self> {
        let root = rate.hz().sqrt();
        let slow = rate.hz() < SLOWEST * MOTION_HZ;
        let loudest = said.into_iter().fold(0.0, f64::max);
        match seen {
            Seen::Untold | Seen::Flat { density: None, .. } => {
                slow.then_some(Self { sensor, said: loudest, why: Why::Slow { rate_hz: rate.hz() } })
            }
            Seen::Falls(fall) => {
                let between = fall.between.map(|density| density * root);
                let agrees = (between[0] / AGREES..between[1] * AGREES).contains(&loudest);
                let why = Why::Falls { fall: *fall, between };
                (fall.density.is_none() || !agrees).then_some(Self { sensor, said: loudest, why })
            }
            Seen::Flat { density: Some(density), apart: [less, more] } => {
                let off = |axis: usize| {
                    let between = [less, more].map(|by| by * density[axis] * root);
                    let [under, over] = [between[0] / said[axis], said[axis] / between[1]];
                    // Where motion may be in it, what is seen is the most that the noise can be.
                    let by = if slow { said[axis] / (density[axis] * root) } else { over.max(under) };
                    (by, Self { sensor, said: said[axis], why: Why::Flat { between } })
                };
                let (by, doubt) = [off(0), off(1), off(2)].into_iter().max_by(|a, b| a.0.total_cmp(&b.0))?;
                (by > APART).then_some(doubt)
            }
        }
    }

    /// For people, of what `who` says.
    pub fn words(&self, who: &str) -> String {
        let (sensor, said, unit) = (self.sensor, two(self.said), self.sensor.unit());
        let says = format!("{who} says {said} {unit} a sample");
        let between = |[low, high]: [f64; 2]| format!("the noise is between {} and {}", two(low), two(high));
        let told = match &self.why {
            Why::Falls { fall, between: ends } => format!(
                "the {sensor}'s spectrum above {MOTION_HZ:.0} Hz falls as behind {}, which no second of it tells: {says}, and {}",
                fall.words(),
                between(*ends)
            ),
            Why::Flat { between: ends } => format!(
                "the {sensor}'s spectrum above {MOTION_HZ:.0} Hz is as flat as noise: {says}, and {}",
                between(*ends)
            ),
            Why::Slow { rate_hz } => format!(
                "the {sensor}'s {rate_hz:.0} Hz do not tell noise from motion: {says}, and it may be several times less"
            ),
        };
        format!(
            "NOT KNOWN: {told}; add ten seconds at rest to the log, or run the odometry (dpn run --noise self)"
        )
    }
}

/// Two significant digits, plain where that is short.
pub fn two(value: f64) -> String {
    let text = format!("{value:.1e}");
    let rounded: f64 = text.parse().expect("a number as Rust writes it is one that Rust reads");
    if (1e-3..1e4).contains(&rounded.abs()) || rounded == 0.0 { rounded.to_string() } else { text }
}

/// Seconds of one sensor added up.
#[derive(Debug, Clone, Default)]
struct Sum {
    seconds: usize,
    /// Of densities, an axis each.
    spectra: [Vec<f64>; 3],
    /// Of the squares of what was said.
    said: [f64; 3],
}

impl Sum {
    fn add(&mut self, other: &Self) {
        self.seconds += other.seconds;
        for axis in 0..3 {
            self.spectra[axis].resize(other.spectra[axis].len().max(self.spectra[axis].len()), 0.0);
            self.spectra[axis].iter_mut().zip(&other.spectra[axis]).for_each(|(sum, more)| *sum += more);
            self.said[axis] += other.said[axis];
        }
    }

    fn doubt(&self, sensor: Sensor, sight: &LowPassSight, rate: SampleRate) -> Option<Doubt> {
        let n = self.seconds as f64;
        let means = self.spectra.each_ref().map(|sum| sum.iter().map(|sum| sum / n).collect::<Vec<_>>());
        let seen = sight.seen(means.each_ref().map(Vec::as_slice), [0.0; 3], self.seconds);
        Doubt::of(sensor, self.said.map(|sum| (sum / n).sqrt()), &seen, rate)
    }
}

/// Holds what is said of samples against their spectrum.
pub struct Watch {
    rate: SampleRate,
    sight: LowPassSight,
    welch: Welch,
    /// The second that is not full yet.
    second: Vec<ImuSample>,
    /// Seconds in a half; none where all are one.
    half: Option<usize>,
    /// The half before and the present one, accelerometer and gyroscope.
    halves: [[Sum; 2]; 2],
    seconds: usize,
    doubts: [Option<Doubt>; 2],
}

impl std::fmt::Debug for Watch {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Watch")
            .field("seconds", &self.seconds)
            .field("doubts", &self.doubts)
            .finish_non_exhaustive()
    }
}

impl Watch {
    /// Of a stream at `rate`: it looks back on the last half to whole minute; none where too little of the spectrum is above motion.
    pub fn new(rate: SampleRate) -> Option<Self> {
        let second = (rate.hz().round() as usize).max(2);
        let (sight, welch) = (LowPassSight::new(rate, second)?, Welch::new(second).ok()?);
        Some(Self {
            rate,
            sight,
            welch,
            second: Vec::with_capacity(second),
            half: Some(HALF),
            halves: Default::default(),
            seconds: 0,
            doubts: [None; 2],
        })
    }

    /// Of a recording, which is looked at once, at its [end](Self::at_end).
    pub fn whole(rate: SampleRate) -> Option<Self> {
        Some(Self { half: None, ..Self::new(rate)? })
    }

    /// Takes a sample and what was said of it; none where nothing is known yet.
    pub fn feed(&mut self, sample: &ImuSample, said: Option<&ImuNoise>) {
        let Some(said) = said.filter(|_| sample.is_finite()) else { return self.second.clear() };
        self.second.push(*sample);
        if self.second.len() < self.sight.second() {
            return;
        }
        for (present, sensor) in self.halves[1].iter_mut().zip(Sensor::ALL) {
            let of = |axis: usize| {
                let signal: Vec<f64> = self.second.iter().map(|sample| sample.of(sensor)[axis]).collect();
                self.welch.spectrum(&signal, self.rate).map_or_else(|_| Vec::new(), |s| s.density().to_vec())
            };
            let said = said.of(sensor).map(|sigma| sigma * sigma);
            present.add(&Sum { seconds: 1, spectra: [of(0), of(1), of(2)], said });
        }
        self.second.clear();
        self.seconds += 1;
        let Some(half) = self.half else { return };
        // One sensor at a time, so that a look is short.
        for (k, after) in [(0, 0), (1, EVERY / 2)] {
            if self.seconds >= LEAST + after && self.seconds % EVERY == after {
                self.look(k);
            }
        }
        if self.halves[1][0].seconds >= half {
            self.halves.swap(0, 1);
            self.halves[1] = Default::default();
        }
    }

    fn look(&mut self, sensor: usize) {
        let mut both = self.halves[0][sensor].clone();
        both.add(&self.halves[1][sensor]);
        self.doubts[sensor] = both.doubt(Sensor::ALL[sensor], &self.sight, self.rate);
    }

    /// What speaks against what was said of the accelerometer and of the gyroscope.
    pub fn doubts(&self) -> [Option<Doubt>; 2] {
        self.doubts
    }

    /// The same of all that was fed; none of less than ten seconds.
    pub fn at_end(mut self) -> [Option<Doubt>; 2] {
        if self.seconds >= LEAST {
            self.look(0);
            self.look(1);
        }
        self.doubts
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Stream;
    use crate::time::Stamp;
    use rand::Rng;
    use rand_distr::StandardNormal;

    /// A hundred seconds of white noise, the accelerometer behind one pole at 20 Hz in all but its first twenty, held against the true deviations times `off`.
    fn doubts(off: f64) -> Vec<[Option<Doubt>; 2]> {
        let mut rng = Stream::new(8).named("watch").rng();
        let mut watch = Watch::new(SampleRate::HZ_200).unwrap();
        let said = ImuNoise::from_values([0.1 * off; 3], [0.01 * off; 3]).unwrap();
        let mut held = [0.0; 3];
        (0..20_000)
            .map(|i| {
                let mut white = |by: f64| [0; 3].map(|_| by * rng.sample::<f64, _>(StandardNormal));
                let (now, gyro) = (white(0.1), white(0.01));
                for axis in 0..3 {
                    held[axis] += 0.47 * (now[axis] - held[axis]);
                }
                let accel = if i < 4000 { now } else { held };
                watch.feed(
                    &ImuSample { t: Stamp::from_ns(5_000_000 * i), accel, gyro },
                    (i > 100).then_some(&said),
                );
                watch.doubts()
            })
            .collect()
    }

    #[test]
    fn a_low_pass_that_begins_is_seen_and_a_right_answer_to_white_noise_is_not_doubted() {
        let right = doubts(1.0);
        assert!(right[..4000].iter().flatten().all(Option::is_none));
        assert!(right.iter().all(|[_, gyro]| gyro.is_none()));
        // Twice the noise, behind a filter or not, is none; nor is half of it.
        for off in [2.0, 0.5] {
            let [accel, gyro] = doubts(off)[19_999];
            let (accel, gyro) = (accel.unwrap(), gyro.unwrap());
            let Why::Falls { between: [low, high], .. } = accel.why else { panic!("{accel:?}") };
            assert!(low < 0.1 && high > 0.1, "{accel:?}");
            let Why::Flat { between: [low, high] } = gyro.why else { panic!("{gyro:?}") };
            assert!(low > 0.006 && low < 0.01 && high > 0.01 && high < 0.015, "{gyro:?}");
            assert!(
                gyro.words("x").starts_with(
                    "NOT KNOWN: the gyro's spectrum above 35 Hz is as flat as noise: x says 0.0"
                )
            );
        }
    }

    #[test]
    fn before_an_answer_and_within_ten_seconds_nothing_is_doubted() {
        assert!(doubts(3.0)[..2000].iter().flatten().all(Option::is_none));
        assert!(doubts(3.0)[3999].iter().all(Option::is_some));
        assert!(Watch::new(SampleRate::from_hz(20.0).unwrap()).is_none());
        let at_100 =
            Doubt::of(Sensor::Accel, [0.1; 3], &Seen::Untold, SampleRate::from_hz(100.0).unwrap()).unwrap();
        assert!(
            at_100.words("x").contains("100 Hz do not tell noise from motion: x says 0.1 m/s^2 a sample")
        );
        assert_eq!(Doubt::of(Sensor::Accel, [0.1; 3], &Seen::Untold, SampleRate::HZ_200), None);
    }
}
