//! The answers along a log.

use super::{LogNoiseError, Plan};
use dpn_core::{ImuNoise, ImuSample, NoiseModel, Recorded, Sensor, Stamp};
use dpn_io::{Row, Store};
use dpn_noise::Judged;
use dpn_pronet::model::RangeCount;
use rayon::prelude::*;
use std::io;
use std::ops::Range;
use std::sync::atomic::{AtomicUsize, Ordering};

/// Answers a piece of work gives.
const PIECE: usize = 2000;
/// Pieces whose answers are held at a time.
const PIECES: usize = 16;
/// Answers from one word to who watches to the next.
const TOLD_EVERY: usize = 500;
/// Beyond this a sample squared is no `f32` any more, and a network may keep an older answer than its window.
const ABSURD: f64 = 1e15;

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

/// Stamp, deviations of accelerometer and gyroscope, counts of both.
impl Row for Answer {
    const BYTES: usize = 11 * 8;

    fn write(&self, bytes: &mut Vec<u8>) {
        bytes.extend(self.t.ns().to_le_bytes());
        for sensor in Sensor::ALL {
            bytes.extend(self.noise.of(sensor).iter().flat_map(|v| v.to_le_bytes()));
        }
        for count in Sensor::ALL.map(|sensor| self.judged.of(sensor)) {
            bytes.extend([count.windows, count.outside].iter().flat_map(|n| n.to_le_bytes()));
        }
    }

    fn read(words: &[[u8; 8]]) -> Self {
        let sigma = |first: usize| [0, 1, 2].map(|axis| f64::from_le_bytes(words[first + axis]));
        let count = |first: usize| {
            let [windows, outside] = [0, 1].map(|at| u64::from_le_bytes(words[first + at]));
            RangeCount { windows, outside }
        };
        Self {
            t: Stamp::from_ns(i64::from_le_bytes(words[0])),
            noise: ImuNoise::from_values(sigma(1), sigma(4)).expect("a noise was written"),
            judged: Judged { accel: count(7), gyro: count(9) },
        }
    }
}

/// The answers along a log: at the first sample, and every so many from there, oldest first.
#[derive(Debug)]
pub struct Track {
    answers: Store<Answer>,
}

impl Track {
    /// Number of answers.
    pub fn len(&self) -> usize {
        self.answers.len()
    }

    /// Never: a recording has a first sample.
    pub fn is_empty(&self) -> bool {
        self.answers.is_empty()
    }

    /// Hands every answer to `take`.
    ///
    /// # Errors
    /// A temporary file that cannot be read, and `take`'s own.
    pub fn each(&self, take: impl FnMut(&Answer) -> io::Result<()>) -> io::Result<()> {
        self.answers.each(take)
    }
}

/// Asks `plan` along a log. The answers are those of one [`Feed`](dpn_noise::Feed) from its first sample to its last, to the bit, whatever the
/// number of threads: a network remembers one window, so the log is cut into pieces and each piece begins a little earlier.
///
/// # Errors
/// As [`Plan::feed`]; a temporary file that cannot be read or written.
pub fn track(plan: &Plan<'_>, recording: &dyn Recorded) -> Result<Track, LogNoiseError> {
    track_watched(plan, recording, &|_| ())
}

/// As [`track`]; `watch` is told now and then how large a share of the answers is there, from whatever thread has it.
pub(super) fn track_watched(
    plan: &Plan<'_>,
    recording: &dyn Recorded,
    watch: &(dyn Fn(f64) + Sync),
) -> Result<Track, LogNoiseError> {
    let rows = recording.len().div_ceil(plan.every());
    let made = AtomicUsize::new(0);
    let count = || {
        let made = made.fetch_add(1, Ordering::Relaxed) + 1;
        if made.is_multiple_of(TOLD_EVERY) {
            watch(made as f64 / rows as f64);
        }
    };
    let mut answers = Store::default();
    let mut absurd = false;
    if plan.noise.memory().is_some() && rows > PIECE {
        let is_absurd = |s: &ImuSample| s.gyro.iter().chain(&s.accel).any(|v| v.abs() > ABSURD);
        recording.each(0..recording.len(), &mut |s| absurd |= is_absurd(s))?;
    }
    let Some(memory) = plan.noise.memory().filter(|_| rows > PIECE && !absurd) else {
        piece(plan, recording, 0..rows, 0, |answer| {
            answers.push(answer);
            count();
        })?;
        return Ok(Track { answers: answers.done()? });
    };
    // A feed asks at whole hops from its first sample, so a piece may begin at any whole number of them.
    let step = plan.hop() * plan.noise.block();
    let pieces: Vec<Range<usize>> =
        (0..rows).step_by(PIECE).map(|from| from..(from + PIECE).min(rows)).collect();
    for pieces in pieces.chunks(PIECES) {
        let answered = pieces
            .into_par_iter()
            .map(|rows| {
                // The row before counts from its own last question on.
                let first = (rows.start * plan.every()).saturating_sub(plan.every() + memory + 2 * step);
                let mut answers = Vec::with_capacity(rows.len());
                piece(plan, recording, rows.clone(), first - first % step, |answer| {
                    answers.push(answer);
                    count();
                })?;
                Ok(answers)
            })
            .collect::<Result<Vec<_>, LogNoiseError>>()?;
        answered.into_iter().flatten().for_each(|answer| answers.push(answer));
    }
    Ok(Track { answers: answers.done()? })
}

/// Hands over `rows`, by a feed that begins with sample `first`.
fn piece(
    plan: &Plan<'_>,
    recording: &dyn Recorded,
    rows: Range<usize>,
    first: usize,
    mut take: impl FnMut(Answer),
) -> Result<(), LogNoiseError> {
    let every = plan.every();
    let mut feed = plan.feed()?;
    let mut before = feed.judged();
    let last = ((rows.end - 1) * every + 1).min(recording.len());
    let mut index = first;
    recording.each(first..last, &mut |sample| {
        let noise = feed.feed(sample);
        if index.is_multiple_of(every) {
            let judged = feed.judged();
            if index / every >= rows.start {
                take(Answer { t: sample.t, noise, judged: judged.since(&before) });
            }
            before = judged;
        }
        index += 1;
    })?;
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use dpn_core::estimate::NoiseSpec;
    use dpn_core::random::Stream;
    use dpn_core::{ImuRecording, SampleRate};
    use dpn_noise::CausalError;
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
        let mut answers = Vec::new();
        piece(plan, recording, 0..recording.len().div_ceil(plan.every()), 0, |a| answers.push(a)).unwrap();
        answers
    }

    #[test]
    fn who_watches_hears_shares_up_to_the_whole() {
        let recording = recording(5000, 5_000_000);
        let networks = [];
        let plan = Plan::new(&"diff2".parse().unwrap(), recording.rate(), 1, &networks).unwrap();
        let heard = std::sync::Mutex::new(Vec::new());
        let watched = track_watched(&plan, &recording, &|share| heard.lock().unwrap().push(share)).unwrap();
        let mut heard = heard.into_inner().unwrap();
        heard.sort_by(f64::total_cmp);
        assert_eq!(heard.len(), watched.len() / TOLD_EVERY);
        assert!(heard[0] > 0.0 && *heard.last().unwrap() <= 1.0, "{heard:?}");
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
            let (mut answers, mut judged) = (Vec::new(), Judged::default());
            whole
                .each(|answer| {
                    answers.push(*answer);
                    judged = judged.plus(&answer.judged);
                    Ok(())
                })
                .unwrap();
            assert!(answers == fed(&plan, &recording), "{hz} {every}");
            assert!(judged.accel.windows > 0 && judged.accel.windows == judged.gyro.windows);
        }
    }

    #[test]
    fn what_is_not_causal_or_of_another_rate_is_refused() {
        let networks = load_all(&Path::new(env!("CARGO_MANIFEST_DIR")).join("../../models")).unwrap();
        let plan = |spec: &str, hz: f64| {
            Plan::new(&spec.parse().unwrap(), SampleRate::from_hz(hz).unwrap(), 10, &networks)
                .map(|p| p.noise.block())
        };
        assert_eq!(plan("dualpronet", 199.4).unwrap(), 1);
        assert_eq!(plan("dualpronet", 1000.0).unwrap(), 5);
        assert_eq!(plan("diff2", 37.0).unwrap(), 1);
        assert!(matches!(plan("dualpronet", 40.0), Err(LogNoiseError::Noise(CausalError::Rate { .. }))));
        assert_eq!(plan("dualpronet", 300.0).unwrap(), 1);
        // Slower logs have networks of their own.
        assert_eq!([100.0, 50.0].map(|hz| plan("dualpronet", hz).unwrap()), [1, 1]);
        for spec in ["oracle", "mean(x1)", "shuffled(diff2)", "file(a.csv)"] {
            assert!(
                matches!(plan(spec, 200.0), Err(LogNoiseError::Noise(CausalError::NotCausal { .. }))),
                "{spec}"
            );
        }
    }
}
