//! Samples waiting for their frame, cut at the instants of images.

use crate::preint::NoisySample;
use dpn_core::{ImuSample, Stamp};
use std::collections::VecDeque;

/// Samples are kept so long for a frame that may come \[s\]; while no camera speaks, memory does not grow.
const KEPT_S: f64 = 600.0;

/// Samples since the last frame, the first of them at its very instant.
#[derive(Debug, Clone, Default)]
pub(crate) struct ImuBuffer {
    samples: VecDeque<NoisySample>,
    /// Whether the first of them was made by a cut, between two readings.
    made: bool,
    /// The last reading before it.
    before: Option<Stamp>,
}

/// What a cut gives.
#[derive(Debug, Clone)]
pub(crate) struct Interval {
    /// From the last frame's instant to this one's, both included.
    pub(crate) samples: Vec<NoisySample>,
    /// The longest step between two readings of which it holds a part \[s\].
    pub(crate) longest_step: f64,
}

impl ImuBuffer {
    pub(crate) fn newest(&self) -> Option<Stamp> {
        self.samples.back().map(|s| s.sample.t)
    }

    pub(crate) fn oldest(&self) -> Option<Stamp> {
        self.samples.front().map(|s| s.sample.t)
    }

    /// Appends a sample later than all others. Those more than ten minutes before it go: what is then cut has a step as long as they were.
    pub(crate) fn push(&mut self, sample: NoisySample) {
        let old = |first: &NoisySample| sample.sample.t.seconds_since(first.sample.t) > KEPT_S;
        while self.samples.front().is_some_and(old) {
            self.samples.pop_front();
            self.made = false;
        }
        self.samples.push_back(sample);
    }

    /// Cuts at `t`, which must lie within the samples; between two of them values are interpolated, the noise is the later one's.
    pub(crate) fn cut(&mut self, t: Stamp) -> Interval {
        let mut samples = Vec::with_capacity(24);
        let mut longest_step: f64 = 0.0;
        while let Some(next) = self.samples.front() {
            if next.sample.t > t {
                break;
            }
            if !std::mem::take(&mut self.made) {
                let step = self.before.map_or(0.0, |before| next.sample.t.seconds_since(before));
                longest_step = longest_step.max(step);
                self.before = Some(next.sample.t);
            }
            samples.push(*next);
            self.samples.pop_front();
        }
        if let (Some(last), Some(next)) = (samples.last(), self.samples.front())
            && last.sample.t < t
        {
            samples.push(between(last, next, t));
            let step = self.before.map_or(0.0, |before| next.sample.t.seconds_since(before));
            longest_step = longest_step.max(step);
            self.made = true;
        }
        if let Some(end) = samples.last() {
            self.samples.push_front(*end);
            if !self.made {
                // A reading at the very instant comes again, as the first of the next interval.
                self.before = Some(end.sample.t);
            }
        }
        Interval { samples, longest_step }
    }
}

fn between(a: &NoisySample, b: &NoisySample, t: Stamp) -> NoisySample {
    let share = t.seconds_since(a.sample.t) / b.sample.t.seconds_since(a.sample.t);
    let mix = |a: [f64; 3], b: [f64; 3]| std::array::from_fn(|k| a[k] + share * (b[k] - a[k]));
    NoisySample {
        sample: ImuSample {
            t,
            gyro: mix(a.sample.gyro, b.sample.gyro),
            accel: mix(a.sample.accel, b.sample.accel),
        },
        noise: b.noise,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use dpn_core::ImuNoise;

    fn sample(t: i64) -> NoisySample {
        let v = t as f64;
        NoisySample {
            sample: ImuSample { t: Stamp::from_ns(t), gyro: [v; 3], accel: [10.0 * v; 3] },
            noise: ImuNoise::baseline(),
        }
    }

    #[test]
    fn samples_that_no_frame_asks_for_go_after_ten_minutes_and_leave_a_step_as_long() {
        let mut buffer = ImuBuffer::default();
        let second = 1_000_000_000;
        (0..10).for_each(|t| buffer.push(sample(t * second)));
        buffer.cut(Stamp::from_ns(9 * second / 2));
        (10..2_000).for_each(|t| buffer.push(sample(t * second)));
        assert_eq!(buffer.oldest(), Some(Stamp::from_ns(1_399 * second)));
        assert_eq!(buffer.cut(Stamp::from_ns(1_500 * second)).longest_step, 1_395.0);
        assert_eq!(buffer.cut(Stamp::from_ns(1_501 * second)).longest_step, 1.0);
    }

    #[test]
    fn intervals_meet_at_the_frame_and_lose_no_sample() {
        let mut buffer = ImuBuffer::default();
        for t in [0, 5, 10, 15, 20] {
            buffer.push(sample(t));
        }
        let stamps = |i: &Interval| i.samples.iter().map(|s| s.sample.t.ns()).collect::<Vec<_>>();
        let first = buffer.cut(Stamp::from_ns(12));
        assert_eq!(stamps(&first), [0, 5, 10, 12]);
        assert_eq!(first.samples[3].sample.accel, [120.0; 3]);
        assert_eq!(first.longest_step, 5e-9);
        assert_eq!(second_step(&mut buffer.clone()), 5e-9);
        let second = buffer.cut(Stamp::from_ns(20));
        assert_eq!(stamps(&second), [12, 15, 20]);
        assert_eq!(buffer.oldest(), Some(Stamp::from_ns(20)));
    }

    fn second_step(buffer: &mut ImuBuffer) -> f64 {
        buffer.cut(Stamp::from_ns(20)).longest_step
    }

    #[test]
    fn a_hole_is_seen_whole_by_every_interval_that_holds_a_part_of_it() {
        let mut buffer = ImuBuffer::default();
        for t in [0, 5, 45, 50] {
            buffer.push(sample(t));
        }
        assert_eq!(buffer.cut(Stamp::from_ns(10)).longest_step, 40e-9);
        assert_eq!(buffer.cut(Stamp::from_ns(20)).longest_step, 40e-9);
        assert_eq!(buffer.cut(Stamp::from_ns(45)).longest_step, 40e-9);
        assert_eq!(buffer.cut(Stamp::from_ns(50)).longest_step, 5e-9);
    }

    #[test]
    fn a_frame_on_a_sample_needs_no_interpolation() {
        let mut buffer = ImuBuffer::default();
        for t in [0, 5, 10] {
            buffer.push(sample(t));
        }
        let first = buffer.cut(Stamp::from_ns(5));
        assert_eq!(first.samples.len(), 2);
        assert_eq!(buffer.cut(Stamp::from_ns(10)).samples.len(), 2);
    }
}
