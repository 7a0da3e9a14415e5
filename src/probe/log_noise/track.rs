//! The answers along a log.

use super::{LogNoiseError, Plan};
use dpn_core::noise::TrackError;
use dpn_core::{ImuNoise, ImuRecording, ImuSample, NoiseTrack, Sensor, Stamp};
use dpn_pronet::model::RangeCount;
use rayon::prelude::*;
use serde::Serialize;

/// Answers a piece of work gives.
const PIECE: usize = 2000;
/// Beyond this a sample squared is no `f32` any more, and a network may keep an older answer than its window.
const ABSURD: f64 = 1e15;

/// Windows of one sensor, an axis each.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize)]
pub struct Count {
    /// Windows judged.
    pub windows: u64,
    /// Of these, unlike every window of the training.
    pub outside: u64,
}

impl From<RangeCount> for Count {
    fn from(count: RangeCount) -> Self {
        Self { windows: count.windows, outside: count.outside }
    }
}

/// Windows of both sensors.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize)]
pub struct Judged {
    /// The accelerometer's.
    pub accel: Count,
    /// The gyroscope's.
    pub gyro: Count,
}

impl Judged {
    /// One sensor's.
    pub fn of(&self, sensor: Sensor) -> Count {
        match sensor {
            Sensor::Accel => self.accel,
            Sensor::Gyro => self.gyro,
        }
    }

    /// What came between `before` and this.
    #[must_use]
    pub fn since(&self, before: &Self) -> Self {
        let of = |now: Count, then: Count| Count {
            windows: now.windows - then.windows,
            outside: now.outside - then.outside,
        };
        Self { accel: of(self.accel, before.accel), gyro: of(self.gyro, before.gyro) }
    }

    /// Both together.
    pub(super) fn plus(&self, other: &Self) -> Self {
        let of =
            |a: Count, b: Count| Count { windows: a.windows + b.windows, outside: a.outside + b.outside };
        Self { accel: of(self.accel, other.accel), gyro: of(self.gyro, other.gyro) }
    }
}

/// One row of a track.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Answer {
    /// The sample's stamp.
    pub t: Stamp,
    /// The noise in force at it.
    pub noise: ImuNoise,
    /// Windows judged since the row before.
    pub judged: Judged,
}

/// The answers along a log: at the first sample, and every so many from there.
#[derive(Debug, Clone, PartialEq)]
pub struct Track {
    /// Oldest first.
    pub answers: Vec<Answer>,
}

impl Track {
    /// Stamps and noises, as other commands read them from a file.
    ///
    /// # Errors
    /// None for a track of a recording, whose stamps increase.
    pub fn noise(&self) -> Result<NoiseTrack, TrackError> {
        let stamps = self.answers.iter().map(|a| a.t).collect();
        NoiseTrack::new(stamps, self.answers.iter().map(|a| a.noise).collect())
    }

    /// All windows judged.
    pub fn judged(&self) -> Judged {
        self.answers.iter().fold(Judged::default(), |sum, a| sum.plus(&a.judged))
    }
}

/// Asks `plan` along a log. The answers are those of one [`Feed`](super::Feed) from its first sample to its last, to the bit, whatever the
/// number of threads: a network remembers one window, so the log is cut into pieces and each piece begins a little earlier.
///
/// # Errors
/// As [`Plan::feed`].
pub fn track(plan: &Plan<'_>, recording: &ImuRecording) -> Result<Track, LogNoiseError> {
    let samples = recording.samples();
    let rows = samples.len().div_ceil(plan.every());
    let absurd = |s: &ImuSample| s.gyro.iter().chain(&s.accel).any(|v| v.abs() > ABSURD);
    let Some(memory) = plan.memory().filter(|_| rows > PIECE && !samples.iter().any(absurd)) else {
        return Ok(Track { answers: piece(plan, samples, 0, rows, 0)? });
    };
    // A feed asks at whole hops from its first sample, so a piece may begin at any whole number of them.
    let step = plan.hop() * plan.thin();
    let pieces: Vec<(usize, usize)> =
        (0..rows).step_by(PIECE).map(|from| (from, (from + PIECE).min(rows))).collect();
    let answers = pieces
        .into_par_iter()
        .map(|(from, to)| {
            // The row before counts from its own last question on.
            let first = (from * plan.every()).saturating_sub(plan.every() + memory + 2 * step);
            piece(plan, samples, from, to, first - first % step)
        })
        .collect::<Result<Vec<_>, _>>()?;
    Ok(Track { answers: answers.concat() })
}

/// Rows `from..to`, by a feed that begins with sample `first`.
fn piece(
    plan: &Plan<'_>,
    samples: &[ImuSample],
    from: usize,
    to: usize,
    first: usize,
) -> Result<Vec<Answer>, LogNoiseError> {
    let every = plan.every();
    let mut feed = plan.feed()?;
    let mut answers = Vec::with_capacity(to - from);
    let mut before = feed.judged();
    let last = ((to - 1) * every + 1).min(samples.len());
    for (index, sample) in samples[..last].iter().enumerate().skip(first) {
        let noise = feed.feed(sample);
        if !index.is_multiple_of(every) {
            continue;
        }
        let judged = feed.judged();
        if index / every >= from {
            answers.push(Answer { t: sample.t, noise, judged: judged.since(&before) });
        }
        before = judged;
    }
    Ok(answers)
}

#[cfg(test)]
mod tests {
    use super::*;
    use dpn_core::SampleRate;
    use dpn_core::estimate::NoiseSpec;
    use dpn_core::random::Stream;
    use dpn_pronet::network::load_all;
    use rand::Rng;
    use std::path::Path;

    fn recording(samples: usize, period_ns: i64) -> ImuRecording {
        let mut rng = Stream::new(5).named("log-noise").rng();
        let mut axes = |about: f64, width: f64| [0; 3].map(|_| about + width * (rng.random::<f64>() - 0.5));
        let samples = (0..samples as i64).map(|i| {
            // Loud and quiet by turns, so that answers differ from place to place.
            let width = 0.1 + 0.1 * (i as f64 * 1e-3).sin();
            ImuSample {
                t: Stamp::from_ns(i * period_ns),
                gyro: axes(0.0, 0.1 * width),
                accel: axes(9.8, width),
            }
        });
        ImuRecording::new(samples.collect()).unwrap()
    }

    /// What one feed says from the first sample to the last.
    fn fed(plan: &Plan<'_>, recording: &ImuRecording) -> Vec<Answer> {
        piece(plan, recording.samples(), 0, recording.len().div_ceil(plan.every()), 0).unwrap()
    }

    #[test]
    fn pieces_on_many_threads_say_what_one_feed_says_to_the_bit() {
        let networks = load_all(&Path::new(env!("CARGO_MANIFEST_DIR")).join("../../models")).unwrap();
        let spec: NoiseSpec = "dualpronet".parse().unwrap();
        // At the networks' rate, at twice it with an odd number of samples between answers, and one answer a sample.
        for (hz, every, samples) in
            [(200.0, 10, 3 * PIECE * 10 + 7), (400.0, 9, 2 * PIECE * 9 + 3), (200.0, 1, PIECE + 400)]
        {
            let recording = recording(samples, (1e9 / hz) as i64);
            let plan = Plan::new(&spec, SampleRate::from_hz(hz).unwrap(), every, &networks).unwrap();
            let whole = track(&plan, &recording).unwrap();
            assert!(whole.answers == fed(&plan, &recording), "{hz} {every}");
            let judged = whole.judged();
            assert!(judged.accel.windows > 0 && judged.accel.windows == judged.gyro.windows);
        }
    }

    #[test]
    fn what_is_not_causal_or_of_another_rate_is_refused() {
        let networks = load_all(&Path::new(env!("CARGO_MANIFEST_DIR")).join("../../models")).unwrap();
        let plan = |spec: &str, hz: f64| {
            Plan::new(&spec.parse().unwrap(), SampleRate::from_hz(hz).unwrap(), 10, &networks)
                .map(|p| p.thin())
        };
        assert_eq!(plan("dualpronet", 199.4).unwrap(), 1);
        assert_eq!(plan("dualpronet", 1000.0).unwrap(), 5);
        assert_eq!(plan("diff2", 37.0).unwrap(), 1);
        assert!(matches!(plan("dualpronet", 100.0), Err(LogNoiseError::Rate { .. })));
        assert!(matches!(plan("dualpronet", 300.0), Err(LogNoiseError::Rate { .. })));
        for spec in ["oracle", "mean(x1)", "shuffled(diff2)", "file(a.csv)"] {
            assert!(matches!(plan(spec, 200.0), Err(LogNoiseError::NotCausal { .. })), "{spec}");
        }
    }
}
