//! The longest stretch at rest as even series: single lost samples bridged, rows that repeat a sensor's last value left out.

use crate::phases::{Phase, Stretch, phase_at};
use crate::rates::{self, Part};
use dpn_core::signal::stats::{self, Ddof};
use dpn_core::{ImuSample, Recorded, SampleRate, Sensor};
use serde::Serialize;
use std::io;
use std::ops::Range;

/// Rows that are looked at: they tell a density to some thousandths, and a day at rest need not be held.
const MOST: usize = 1 << 18;
/// Samples lost in a row that a straight line stands in for.
pub(crate) const BRIDGED: usize = 3;
/// Share of bridged samples beyond which the log is no even series.
pub(crate) const MOST_BRIDGED: f64 = 0.05;
/// Share of steps within a quarter of the period from which stamps tell what was lost; else they are times of arrival.
const EVEN: f64 = 0.9;
/// Share of rows that repeat a sensor's last values from which its values are held.
const HELD: f64 = 0.05;
/// A sensor that is held repeats all axes together; steps of a coarse converter repeat one or another.
const TOGETHER: f64 = 0.8;

/// Samples lost in a step of so many periods.
pub(crate) fn lost_in(step: f64) -> usize {
    (step.round() as usize).saturating_sub(1)
}

/// Whether a step is of one period, so many of which it has.
pub(crate) fn is_even(step: f64) -> bool {
    (step - 1.0).abs() < 0.25
}

/// Whether stamps tell of loss, `even` of whose steps are: those that were made when a queue was emptied do not.
pub(crate) fn tell_of_loss(even: usize, steps: usize) -> bool {
    even as f64 >= EVEN * (1.0 - MOST_BRIDGED) * steps as f64
}

/// The rows of a stretch.
#[derive(Debug, Clone)]
pub(super) struct Rows {
    /// In the recording.
    pub(super) range: Range<usize>,
    /// From the log's begin \[s\].
    pub(super) from_s: f64,
    /// To \[s\].
    pub(super) to_s: f64,
    /// Rows that so many lost ones go before, from the range's first.
    holes: Vec<(usize, usize)>,
    /// By sensor: whether a row is a value of its own, where its values are held.
    fresh: [Option<Vec<bool>>; 2],
}

/// A stretch that is being read.
struct Open {
    range: Range<usize>,
    span: [f64; 2],
    holes: Vec<(usize, usize)>,
}

impl Open {
    fn serves(&self, least_s: f64) -> bool {
        let lost: usize = self.holes.iter().map(|hole| hole.1).sum();
        self.span[1] - self.span[0] >= least_s && lost as f64 <= MOST_BRIDGED * self.range.len() as f64
    }
}

/// Parts of a rest that are held against each other \[s\], and the power over their median, and over what nine of ten stay below, from which somebody knocked.
const BLOCK_S: f64 = 0.25;
const KNOCK: [f64; 2] = [16.0, 6.0];

impl Open {
    /// The longest part that nobody knocks at; none where none lasts for `least_s`.
    fn between_knocks(self, recording: &dyn Recorded, least_s: f64) -> io::Result<Option<Self>> {
        let rows = ((recording.rate().hz() * BLOCK_S).round() as usize).max(4);
        let start = recording.span()[0];
        let blocks = self.range.len() / rows;
        let mut powers: [Vec<f64>; 6] = Default::default();
        let mut spans: Vec<[f64; 2]> = Vec::with_capacity(blocks);
        recording.pieces(self.range.start..self.range.start + blocks * rows, rows, &mut |block| {
            let at = |sample: &ImuSample| sample.t.seconds_since(start);
            spans.push([at(&block[0]), at(&block[block.len() - 1])]);
            let axes = Sensor::ALL.into_iter().flat_map(|sensor| (0..3).map(move |axis| (sensor, axis)));
            for ((sensor, axis), powers) in axes.zip(&mut powers) {
                let values: Vec<f64> = block.iter().map(|sample| sample.of(sensor)[axis]).collect();
                powers.push(stats::variance(&values, Ddof::Zero));
            }
            Ok(())
        })?;
        let mut knocked = vec![false; blocks];
        for powers in &powers {
            let limit = (KNOCK[0] * stats::median(powers)).max(KNOCK[1] * stats::quantile(powers, 0.9));
            // Steps of a coarse converter may be rare.
            if limit > 0.0 {
                knocked.iter_mut().zip(powers).for_each(|(knocked, power)| *knocked |= *power > limit);
            }
        }
        if !knocked.contains(&true) {
            return Ok(Some(self));
        }
        // What rings on after a knock is not louder than the limit.
        let is_still = |k: usize| !knocked[k] && (k == 0 || !knocked[k - 1]);
        let (mut longest, mut from) = (0..0, None);
        for k in 0..=blocks {
            if k < blocks && is_still(k) {
                from.get_or_insert(k);
            } else if let Some(begun) = from.take()
                && k - begun > longest.len()
            {
                longest = begun..k;
            }
        }
        if longest.is_empty() {
            return Ok(None);
        }
        let span = [spans[longest.start][0], spans[longest.end - 1][1]];
        let inside = longest.start * rows..longest.end * rows;
        let holes = self.holes.into_iter().filter(|hole| hole.0 > inside.start && hole.0 < inside.end);
        let holes = holes.map(|(at, lost)| (at - inside.start, lost)).collect();
        let range = self.range.start + inside.start..self.range.start + inside.end;
        let part = Self { range, span, holes };
        Ok(part.serves(least_s).then_some(part))
    }
}

/// Values of a sensor that stand on several rows.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Held {
    /// Rate of the rows \[Hz\].
    pub rows_hz: f64,
    /// Rate of values \[Hz\].
    pub values_hz: f64,
}

impl Rows {
    /// The longest stretch at rest without a hole that cannot be bridged; none where nothing rests for `least_s`.
    pub(super) fn longest(
        recording: &dyn Recorded,
        stretches: &[Stretch],
        parts: &[Part],
        least_s: f64,
    ) -> io::Result<Option<Self>> {
        let period = recording.rate().period();
        let start = recording.span()[0];
        let one_rate = rates::longest(parts).map_or([0.0, f64::INFINITY], |part| part.span_s);
        let mut even = 0;
        recording.pairs(&mut |a, b| even += usize::from(is_even(b.t.seconds_since(a.t) / period)))?;
        let tells = tell_of_loss(even, recording.len() - 1);
        let (mut best, mut open): (Option<Open>, Option<Open>) = (None, None);
        let close = |open: &mut Option<Open>, best: &mut Option<Open>| {
            let Some(done) = open.take().filter(|done| done.serves(least_s)) else { return };
            if best.as_ref().is_none_or(|best| best.range.len() < done.range.len()) {
                *best = Some(done);
            }
        };
        let mut index = 0;
        recording.each(0..recording.len(), &mut |sample| {
            let t = sample.t.seconds_since(start);
            let rests =
                phase_at(stretches, t) == Some(Phase::Rest) && (one_rate[0]..one_rate[1]).contains(&t);
            let lost = match &open {
                Some(open) if tells => lost_in((t - open.span[1]) / period),
                _ => 0,
            };
            if !rests || lost > BRIDGED {
                close(&mut open, &mut best);
            }
            if rests {
                let fresh = || Open { range: index..index, span: [t, t], holes: Vec::new() };
                let open = open.get_or_insert_with(fresh);
                // Of one that is full the last stamp stays behind, and nothing is lost.
                if open.range.len() < MOST {
                    if (1..=BRIDGED).contains(&lost) {
                        open.holes.push((index - open.range.start, lost));
                    }
                    (open.range.end, open.span[1]) = (index + 1, t);
                }
            }
            index += 1;
        })?;
        close(&mut open, &mut best);
        let Some(best) = best else { return Ok(None) };
        let Some(best) = best.between_knocks(recording, least_s)? else { return Ok(None) };
        let Open { range, span: [from_s, to_s], holes } = best;
        let fresh = [held(recording, &range, Sensor::Accel)?, held(recording, &range, Sensor::Gyro)?];
        Ok(Some(Self { range, from_s, to_s, holes, fresh }))
    }

    /// Lost samples that were bridged.
    pub(super) fn bridged(&self) -> usize {
        self.holes.iter().map(|hole| hole.1).sum()
    }

    fn fresh(&self, sensor: Sensor) -> Option<&Vec<bool>> {
        match sensor {
            Sensor::Accel => self.fresh[0].as_ref(),
            Sensor::Gyro => self.fresh[1].as_ref(),
        }
    }

    /// Rate of the rows \[Hz\]: their number over their time.
    fn rows_hz(&self) -> f64 {
        (self.range.len() + self.bridged() - 1) as f64 / (self.to_s - self.from_s)
    }

    /// Whether the sensor's values stand on several rows.
    pub(super) fn held(&self, sensor: Sensor) -> Option<Held> {
        let fresh = self.fresh(sensor)?;
        let share = fresh.iter().filter(|f| **f).count() as f64 / fresh.len() as f64;
        Some(Held { rows_hz: self.rows_hz(), values_hz: share * self.rows_hz() })
    }

    /// Values of one axis, evenly spaced, and their rate; none where there is no rate.
    pub(super) fn series(
        &self,
        recording: &dyn Recorded,
        sensor: Sensor,
        axis: usize,
    ) -> io::Result<Option<(Vec<f64>, SampleRate)>> {
        let mut values = recording.signal(self.range.clone(), sensor, axis)?;
        let mut hz = self.rows_hz();
        if let (Some(fresh), Some(held)) = (self.fresh(sensor), self.held(sensor)) {
            // What is lost among held rows is mostly a value's second row.
            let mut fresh = fresh.iter();
            values.retain(|_| *fresh.next().expect("a mark a row"));
            hz = held.values_hz;
        } else if !self.holes.is_empty() {
            let mut even = Vec::with_capacity(values.len() + self.bridged());
            let mut holes = self.holes.iter().peekable();
            for (i, value) in values.iter().enumerate() {
                if let Some((_, lost)) = holes.next_if(|hole| hole.0 == i) {
                    let before = values[i - 1];
                    let part = |k: usize| before + (value - before) * k as f64 / (lost + 1) as f64;
                    even.extend((1..=*lost).map(part));
                }
                even.push(*value);
            }
            values = even;
        }
        Ok(SampleRate::from_hz(hz).map(|rate| (values, rate)))
    }
}

/// Which rows of a sensor are values of their own; none where its values are not held.
fn held(recording: &dyn Recorded, range: &Range<usize>, sensor: Sensor) -> io::Result<Option<Vec<bool>>> {
    let mut fresh = Vec::with_capacity(range.len());
    let mut same = [0_usize; 3];
    let mut before: Option<[f64; 3]> = None;
    recording.each(range.clone(), &mut |sample| {
        let now = sample.of(sensor);
        let equal = before.map_or([false; 3], |before| std::array::from_fn(|axis| now[axis] == before[axis]));
        for (count, equal) in same.iter_mut().zip(equal) {
            *count += usize::from(equal);
        }
        fresh.push(equal != [true; 3]);
        before = Some(now);
    })?;
    let repeated = fresh.iter().filter(|f| !**f).count() as f64;
    // A dead axis repeats always, and tells nothing.
    let alive: Vec<f64> =
        same.into_iter().filter(|count| *count + 1 < range.len()).map(|count| count as f64).collect();
    let least = alive.iter().copied().reduce(f64::min).unwrap_or(0.0);
    // Axes that hardly leave a coarse step repeat by themselves, each on its own, and now and then all: as often as chance has it.
    let all = range.len() as f64;
    let by_chance = all * alive.iter().map(|count| count / all).product::<f64>();
    let is_together = alive.len() < 2 || repeated > f64::midpoint(by_chance, least);
    // Nor does a dead sensor.
    let is_alive = fresh.iter().filter(|f| **f).count() > 1;
    let is_held = is_alive && is_together && repeated > HELD * all && repeated > TOGETHER * least;
    Ok(is_held.then_some(fresh))
}
