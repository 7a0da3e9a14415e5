//! Keeps of somebody's samples what a recording may hold, and counts what it leaves out.
//!
//! The readers of this crate refuse a log with one bad row: what is trained on or judged must be whole. A tool that looks at anybody's
//! log must say what is wrong with it and go on. A sample is left out when a value of it is not finite or not between [`TINY`] and
//! [`ABSURD`] nor zero, when its stamp is that of the sample before, or when its stamp goes back.
//!
//! Where stamps go back and go on from there, a clock was set, a counter began anew, or two publishers wrote into one log. Each is a [`Part`] with
//! increasing stamps: a sample goes to the part whose last one it follows by no more than [`HOLE`] of its steps. What comes behind a hole waits
//! ([`PENDING`]) until it is known whether what was before goes on as well.

use super::sample_store::SampleStore;
use dpn_core::imu::ImuSample;
use dpn_core::{Samples, Stamp};
use serde::Serialize;
use std::{io, mem};

/// Steps of a part beyond which a sample may belong to another.
const HOLE: f64 = 5.0;
/// Samples from which a part is no stray.
const SETTLED: usize = 16;
/// Samples behind a hole after which nothing from before it is waited for.
const PENDING: usize = 64;
/// Parts that are told apart.
const MOST: usize = 64;
/// Share of the samples from which a part is named; those of smaller ones are left out.
const SHARE: f64 = 0.01;

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

/// Samples with increasing stamps.
#[derive(Debug, Default)]
pub struct Part {
    /// The samples.
    pub samples: SampleStore,
    /// Places of the first and the last in the log (see [`LeftOut::first`]).
    pub places: [u64; 2],
}

impl Part {
    /// Whether it was written while `other` was, not before or after it.
    pub fn is_among(&self, other: &Self) -> bool {
        self.places[0] < other.places[1] && other.places[0] < self.places[1]
    }
}

/// What a sieve keeps, and what it leaves out.
#[derive(Debug, Default)]
pub struct Sifted {
    /// The longest part.
    pub part: Part,
    /// The others, in the order of the log.
    pub others: Vec<Part>,
    /// Samples that belong to none.
    pub sieved: Sieved,
}

impl Sifted {
    /// The same with other samples in the longest part's place, and that alone.
    #[must_use]
    pub fn with(self, samples: SampleStore) -> Self {
        Self { part: Part { samples, ..self.part }, others: Vec::new(), ..self }
    }
}

/// A part that is being read.
#[derive(Debug, Default)]
struct Run {
    part: Part,
    /// What came behind a hole, with its places, while it may be another's.
    pending: Vec<(ImuSample, u64)>,
    /// Usual step \[ns\]; 0 while there is none.
    step: f64,
    /// Samples, pending ones too.
    count: usize,
}

impl Run {
    /// Stamps that a sample may follow: the last one, and the one before the hole.
    fn tails(&self) -> [Option<Stamp>; 2] {
        let kept = self.part.samples.last();
        match self.pending.last() {
            Some((last, _)) => [Some(last.t), kept],
            None => [kept, None],
        }
    }

    /// How far `t` is behind `tail` \[ns\], where that is a step of this part.
    fn step_to(&self, tail: Option<Stamp>, t: Stamp) -> Option<f64> {
        let step = t.ns().checked_sub(tail?.ns()).filter(|step| *step > 0)? as f64;
        (self.step == 0.0 || step <= HOLE * self.step).then_some(step)
    }

    fn add(&mut self, sample: ImuSample, place: u64) {
        if let Some(step) = self.step_to(self.tails()[0], sample.t) {
            let usual = if self.step == 0.0 { step } else { self.step };
            self.step = usual + (step - usual) / 16.0;
        }
        self.count += 1;
        if self.pending.is_empty() {
            self.keep(sample, place);
        } else {
            self.pending.push((sample, place));
            if self.pending.len() >= PENDING {
                self.settle();
            }
        }
    }

    fn keep(&mut self, sample: ImuSample, place: u64) {
        let places = &mut self.part.places;
        *places = if self.part.samples.is_empty() { [place; 2] } else { [places[0], place] };
        self.part.samples.push(sample);
    }

    /// What is behind the hole is this part's.
    fn settle(&mut self) {
        for (sample, place) in mem::take(&mut self.pending) {
            self.keep(sample, place);
        }
    }

    /// What is behind the hole as a part of its own.
    fn split(&mut self) -> Self {
        let mut other = Self { step: self.step, ..Self::default() };
        for (sample, place) in mem::take(&mut self.pending) {
            other.add(sample, place);
        }
        self.count -= other.count;
        other
    }
}

/// Takes samples as they come.
#[derive(Debug, Default)]
pub struct Sieve {
    runs: Vec<Run>,
    /// The one that the last sample went to.
    current: usize,
    sieved: Sieved,
}

impl Sieve {
    /// Takes one sample that stands at `place` (see [`LeftOut::first`]); whether it is kept.
    pub fn push(&mut self, sample: ImuSample, place: u64) -> bool {
        let left = if !sample.is_finite() {
            &mut self.sieved.not_finite
        } else if is_absurd(&sample) {
            &mut self.sieved.absurd
        } else {
            let run = self.runs.get_mut(self.current);
            if let Some(run) =
                run.filter(|r| r.count >= SETTLED && r.step_to(r.tails()[0], sample.t).is_some())
            {
                run.add(sample, place);
                return true;
            }
            return self.place(sample, place);
        };
        left.add(place);
        false
    }

    /// Finds the part of a sample that does not simply follow the one before it.
    fn place(&mut self, sample: ImuSample, place: u64) -> bool {
        let t = sample.t;
        let tails = || {
            let of = |(at, run): (usize, &Run)| run.tails().map(|tail| (at, tail));
            self.runs.iter().enumerate().flat_map(of).filter_map(|(at, tail)| Some((at, tail?)))
        };
        if tails().any(|(_, tail)| tail == t) {
            self.sieved.repeated.add(place);
            return false;
        }
        let nearest = |found: Option<(usize, Stamp)>, (at, tail)| match found {
            Some((_, best)) if best >= tail => found,
            _ => Some((at, tail)),
        };
        let follows = tails().filter(|(at, tail)| self.runs[*at].step_to(Some(*tail), t).is_some());
        if let Some((at, tail)) = follows.fold(None, nearest) {
            self.go_to(at, tail, |run| run.add(sample, place));
            return true;
        }
        // Behind a hole: of the part at hand, where that is no stray, else of the nearest.
        let own =
            tails().filter(|(at, tail)| *at == self.current && *tail < t && self.runs[*at].count >= SETTLED);
        if let Some((at, tail)) = own.chain(tails().filter(|(_, tail)| *tail < t)).reduce(|best, next| {
            let is_own = |at: usize| at == self.current && self.runs[at].count >= SETTLED;
            if is_own(best.0) || next.1 <= best.1 { best } else { next }
        }) {
            self.go_to(at, tail, |run| {
                run.settle();
                run.pending.push((sample, place));
                run.count += 1;
            });
            return true;
        }
        let mut run = Run { step: self.runs.get(self.current).map_or(0.0, |run| run.step), ..Run::default() };
        run.add(sample, place);
        let is_room = self.begin(run);
        if is_room {
            self.current = self.runs.len() - 1;
        }
        is_room
    }

    /// Goes on with the part at `at` behind its `tail`; where that is the one before its hole, what came behind that is another part.
    fn go_to(&mut self, at: usize, tail: Stamp, add: impl FnOnce(&mut Run)) {
        self.current = at;
        let run = &mut self.runs[at];
        let other = (run.tails()[1] == Some(tail)).then(|| run.split());
        add(run);
        if let Some(other) = other {
            self.begin(other);
        }
    }

    /// Takes another part in, in the place of a stray where there are too many; whether there was room, else it is left out.
    fn begin(&mut self, run: Run) -> bool {
        if self.runs.len() >= MOST {
            let strays =
                self.runs.iter().enumerate().filter(|(at, run)| *at != self.current && run.count < SETTLED);
            // Of several as short the last.
            let Some((at, _)) = strays.rev().min_by_key(|(_, run)| run.count) else {
                self.leave_out(&run);
                return false;
            };
            let stray = self.runs.remove(at);
            self.current -= usize::from(self.current > at);
            self.leave_out(&stray);
        }
        self.runs.push(run);
        true
    }

    fn leave_out(&mut self, run: &Run) {
        let first = run.pending.first().map(|(_, place)| *place).into_iter();
        let first = first.chain((!run.part.samples.is_empty()).then_some(run.part.places[0])).min();
        let backward = &mut self.sieved.backward;
        backward.count += run.count;
        backward.first = backward.first.into_iter().chain(first).min();
    }

    /// Counts a sample that could not even be made, for a value that is not finite.
    pub fn not_finite(&mut self, place: u64) {
        self.sieved.not_finite.add(place);
    }

    /// Whether none was kept yet.
    pub fn is_empty(&self) -> bool {
        self.runs.is_empty()
    }

    /// The samples kept, in increasing time and finite, and what was left out.
    ///
    /// # Errors
    /// A temporary file that could not be written.
    pub fn done(mut self) -> io::Result<Sifted> {
        let runs = mem::take(&mut self.runs);
        let all: usize = runs.iter().map(|run| run.count).sum();
        // Of several as long the first.
        let longest = runs.iter().enumerate().rev().max_by_key(|(_, run)| run.count).map(|(at, _)| at);
        let mut sifted = Sifted::default();
        for (at, mut run) in runs.into_iter().enumerate() {
            let is_longest = longest == Some(at);
            if !is_longest && (run.count < SETTLED || (run.count as f64) < SHARE * all as f64) {
                self.leave_out(&run);
                continue;
            }
            run.settle();
            let part = Part { samples: run.part.samples.done()?, ..run.part };
            if is_longest { sifted.part = part } else { sifted.others.push(part) }
        }
        sifted.others.sort_by_key(|part| part.places);
        Ok(Sifted { sieved: self.sieved, ..sifted })
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
        let Sifted { part, others, sieved } = sieve.done().unwrap();
        assert!(others.is_empty());
        let samples = part.samples.all().unwrap().into_owned();
        assert_eq!(samples.iter().map(|s| s.t.ns()).collect::<Vec<_>>(), [5, 10, 15]);
        assert_eq!(samples[2].accel, [3.0; 3]);
        assert_eq!(sieved.repeated, LeftOut { count: 2, first: Some(3) });
        assert_eq!(sieved.backward, LeftOut { count: 1, first: Some(4) });
        assert_eq!(sieved.not_finite, LeftOut { count: 1, first: Some(5) });
        assert_eq!(sieved.absurd, LeftOut { count: 2, first: Some(8) });
        assert!(dpn_core::imu::ImuRecording::new(samples).is_ok());
    }

    fn stamps(part: &Part) -> Vec<i64> {
        part.samples.all().unwrap().iter().map(|s| s.t.ns()).collect()
    }

    fn sifted(stamps: &[i64]) -> Sifted {
        let mut sieve = Sieve::default();
        for (place, t) in stamps.iter().enumerate() {
            let sample = ImuSample { t: Stamp::from_ns(*t), gyro: [0.0; 3], accel: [1.0; 3] };
            sieve.push(sample, place as u64);
        }
        sieve.done().unwrap()
    }

    #[test]
    fn stamps_that_cycle_are_parts_and_two_publishers_are_told_apart() {
        let cycle: Vec<i64> = (0..400).map(|i| 5_000 * i).collect();
        let found = sifted(&[&cycle[..], &cycle, &cycle[..300]].concat());
        assert_eq!(stamps(&found.part), cycle);
        assert_eq!(found.others.iter().map(|part| stamps(part).len()).collect::<Vec<_>>(), [400, 300]);
        assert!(!found.others[0].is_among(&found.part) && found.sieved == Sieved::default());
        // The second one's stamps are 355 ms ahead, and it begins later.
        let (mut all, mut first, mut second) = (cycle[..100].to_vec(), cycle[..100].to_vec(), Vec::new());
        for (i, t) in cycle.iter().enumerate().skip(100) {
            all.push(*t);
            first.push(*t);
            if i % 3 != 0 {
                all.push(t + 355_123);
                second.push(t + 355_123);
            }
        }
        let found = sifted(&all);
        assert_eq!(stamps(&found.part), first);
        assert_eq!(found.others.iter().map(stamps).collect::<Vec<_>>(), [second]);
        assert!(found.others[0].is_among(&found.part));
    }

    proptest::proptest! {
        /// Any jitter, holes and bursts: what increases is one part, whole; a swapped pair costs one sample.
        #[test]
        fn increasing_stamps_are_kept_as_they_are(
            steps in proptest::collection::vec(proptest::prop_oneof![1..20_000i64, 4_990..5_010i64, 1..90_000_000i64], 2..400),
            swap in 0..300usize,
        ) {
            let mut all: Vec<i64> = steps.iter().scan(0, |t, step| { *t += step; Some(*t) }).collect();
            let found = sifted(&all);
            proptest::prop_assert_eq!(stamps(&found.part), all.clone());
            proptest::prop_assert!(found.others.is_empty() && found.sieved == Sieved::default());
            if swap + 1 < all.len() {
                all.swap(swap, swap + 1);
                let found = sifted(&all);
                let kept = found.part.samples.len() + found.others.iter().map(|part| part.samples.len()).sum::<usize>();
                proptest::prop_assert_eq!(kept + found.sieved.backward.count, all.len());
                proptest::prop_assert!(stamps(&found.part).windows(2).all(|w| w[0] < w[1]));
            }
        }

        /// Whatever comes, every sample is kept once or counted, and every part's stamps increase.
        #[test]
        fn no_sample_is_lost_whatever_the_order(all in proptest::collection::vec(0..2_000i64, 0..600)) {
            let found = sifted(&all);
            let parts: Vec<&Part> = found.others.iter().chain([&found.part]).collect();
            let kept: usize = parts.iter().map(|part| part.samples.len()).sum();
            proptest::prop_assert_eq!(kept + found.sieved.count(), all.len());
            proptest::prop_assert!(parts.iter().all(|part| stamps(part).windows(2).all(|w| w[0] < w[1])));
        }
    }
}
