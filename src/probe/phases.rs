//! At rest, motors on, moving: what a log does, second by second, from its samples alone.
//!
//! Two things are looked at. *Shaking*: how much second differences scatter, over their gain, which motion hardly reaches. *Moving*: means over
//! a quarter of a second, in which vibration averages out: a turn of more than .05 rad/s over the bias, or a specific force that changes by
//! more than .3 m/s^2. A second that neither moves nor shakes is at rest; one that shakes on the spot has its motors on. What lasts less than
//! two seconds between two stretches of one kind is taken for theirs.

use dpn_core::signal::stats::{self, Ddof};
use dpn_core::{ImuSample, Recorded, Sensor, named};
use serde::Serialize;
use std::io;

/// Turning over the bias that is motion \[rad/s\].
const TURN: f64 = 0.05;
/// Change of the specific force within two seconds that is motion \[m/s^2\].
const FORCE: f64 = 0.3;
/// Shaking below these is rest with any sensor \[m/s^2, rad/s\]; above [`MOST`] it is rest with none.
const LEAST: [f64; 2] = [0.1, 0.01];
const MOST: [f64; 2] = [0.25, 0.04];
/// Of its samples' own length a second of them may last so much, holes included.
const HOLE: f64 = 10.0;
/// Shortest stretch \[s\].
const SHORTEST: usize = 2;

named!(
    /// What a vehicle does.
    #[derive(PartialOrd, Ord, Serialize)]
    #[serde(rename_all = "snake_case")]
    pub enum Phase {
        /// Nothing moves.
        Rest = "at rest",
        /// It shakes on the spot.
        Motors = "motors on",
        /// It moves.
        Moving = "moving",
    }
);

/// A stretch of one phase.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Stretch {
    /// What happens.
    pub phase: Phase,
    /// From the log's begin \[s\].
    pub from_s: f64,
    /// To \[s\].
    pub to_s: f64,
}

impl Stretch {
    /// How long it lasts \[s\].
    pub fn length_s(&self) -> f64 {
        self.to_s - self.from_s
    }
}

/// The phase `t` seconds after the log's begin.
pub(crate) fn phase_at(stretches: &[Stretch], t: f64) -> Option<Phase> {
    stretches.get(stretches.partition_point(|s| s.to_s <= t)).map(|s| s.phase)
}

/// The last of the longest rests.
pub(crate) fn longest_rest(stretches: &[Stretch]) -> Option<&Stretch> {
    let rests = stretches.iter().filter(|s| s.phase == Phase::Rest);
    rests.max_by(|a, b| a.length_s().total_cmp(&b.length_s()))
}

/// What is known of a second.
struct Second {
    from_s: f64,
    to_s: f64,
    /// Shaking of accelerometer and gyroscope.
    shakes: [f64; 2],
    /// Means over quarters; of a second of few samples there are more.
    gyro: Box<[[f64; 3]]>,
    force: [f64; 3],
}

/// The phases of a log from its first sample to its last, without a hole but where the log has one of many seconds.
///
/// # Errors
/// As [`Samples::piece`](dpn_core::Samples::piece).
pub fn phases(recording: &dyn Recorded) -> io::Result<Vec<Stretch>> {
    let [start, end] = recording.span();
    let block = (recording.rate().hz().round() as usize).clamp(8, recording.len().max(8));
    let longest_s = HOLE * block as f64 * recording.rate().period();
    let mut seconds: Vec<Second> = Vec::new();
    recording.pieces(0..recording.len(), block, &mut |chunk| {
        let from_s = chunk[0].t.seconds_since(start);
        // Each lasts to the one behind it, be that a second or what is left over; a hole is no phase.
        if let Some(before) = seconds.last_mut().filter(|s| s.to_s.is_nan()) {
            before.to_s = from_s.min(before.from_s + longest_s);
        }
        if chunk.len() >= 8 || recording.len() < 8 {
            seconds.push(second(chunk, from_s));
        }
        Ok(())
    })?;
    match seconds.last_mut() {
        Some(last) if last.to_s.is_nan() => last.to_s = end.seconds_since(start).min(last.from_s + longest_s),
        Some(_) => {}
        None => return Ok(Vec::new()),
    }
    let bias = bias(&seconds);
    let limits: [f64; 2] = std::array::from_fn(|k| {
        let all: Vec<f64> = seconds.iter().map(|s| s.shakes[k]).collect();
        (3.0 * stats::quantile(&all, 0.05)).clamp(LEAST[k], MOST[k])
    });
    let mut kinds: Vec<Phase> = (0..seconds.len())
        .map(|i| {
            let s = &seconds[i];
            let turns = s.gyro.iter().any(|w| far(w, &bias) > TURN);
            let near = [i.saturating_sub(1), (i + 1).min(seconds.len() - 1)];
            let pushed = near.iter().any(|&j| far(&seconds[j].force, &s.force) > FORCE);
            if turns || pushed {
                Phase::Moving
            } else if (0..2).any(|k| s.shakes[k] > limits[k]) {
                Phase::Motors
            } else {
                Phase::Rest
            }
        })
        .collect();
    settle(&mut kinds);
    let mut stretches: Vec<Stretch> = Vec::new();
    for (kind, s) in kinds.into_iter().zip(&seconds) {
        match stretches.last_mut() {
            Some(last) if last.phase == kind && last.to_s == s.from_s => last.to_s = s.to_s,
            _ => stretches.push(Stretch { phase: kind, from_s: s.from_s, to_s: s.to_s }),
        }
    }
    if let Some(last) = stretches.last_mut() {
        last.to_s = recording.length_s().min(last.to_s + longest_s);
    }
    Ok(stretches)
}

/// What is known of a second but its end.
fn second(chunk: &[ImuSample], from_s: f64) -> Second {
    let shakes = Sensor::ALL.map(|sensor| {
        (0..3)
            .map(|axis| {
                let signal: Vec<f64> = chunk.iter().map(|s| s.of(sensor)[axis]).collect();
                stats::deviation(&stats::differences(&signal, 2), Ddof::Zero) / stats::difference_gain(2)
            })
            .fold(0.0, f64::max)
    });
    let quarter = (chunk.len() / 4).max(1);
    Second {
        from_s,
        to_s: f64::NAN,
        shakes,
        gyro: chunk.chunks_exact(quarter).map(|q| mean(q, Sensor::Gyro)).collect(),
        force: mean(chunk, Sensor::Accel),
    }
}

fn mean(chunk: &[ImuSample], sensor: Sensor) -> [f64; 3] {
    std::array::from_fn(|axis| chunk.iter().map(|s| s.of(sensor)[axis]).sum::<f64>() / chunk.len() as f64)
}

fn far(a: &[f64; 3], b: &[f64; 3]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt()
}

/// The gyroscope's bias: median of the means over the fifth of the seconds in which it changes least.
fn bias(seconds: &[Second]) -> [f64; 3] {
    let spread = |s: &Second| s.gyro.windows(2).map(|w| far(&w[0], &w[1])).fold(0.0, f64::max);
    let mut by_spread: Vec<&Second> = seconds.iter().collect();
    by_spread.sort_by(|a, b| spread(a).total_cmp(&spread(b)));
    by_spread.truncate(seconds.len().div_ceil(5));
    std::array::from_fn(|axis| {
        let values: Vec<f64> = by_spread.iter().flat_map(|s| s.gyro.iter().map(|w| w[axis])).collect();
        stats::median(&values)
    })
}

/// Takes short stretches between two of one kind for theirs.
fn settle(kinds: &mut [Phase]) {
    let mut begin = 0;
    while begin < kinds.len() {
        let kind = kinds[begin];
        let end = begin + kinds[begin..].iter().take_while(|k| **k == kind).count();
        if end - begin < SHORTEST && begin > 0 && end < kinds.len() && kinds[begin - 1] == kinds[end] {
            let around = kinds[end];
            kinds[begin..end].fill(around);
        }
        begin = end;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::doctor::values::tests::level;
    use dpn_core::ImuRecording;

    #[test]
    fn a_hole_of_years_is_no_rest() {
        let mut samples = level(60);
        for s in &mut samples[7000..] {
            s.t = s.t.plus_seconds(1e8);
        }
        let found = phases(&ImuRecording::new(samples).unwrap()).unwrap();
        let rest: f64 = found.iter().map(Stretch::length_s).sum();
        assert!(found.len() == 2 && (60.0..75.0).contains(&rest), "{found:?}");
    }

    #[test]
    fn rest_motors_and_flight_are_told_apart_and_a_knock_is_no_phase() {
        let mut samples = level(60);
        for (i, s) in samples.iter_mut().enumerate() {
            let t = s.t.ns() as f64 * 1e-9;
            let shake = (2.0 * std::f64::consts::PI * 87.0 * t).sin();
            s.gyro[2] += 0.04;
            if (20.0..40.0).contains(&t) {
                s.accel[0] += 1.2 * shake;
            }
            if t >= 40.0 {
                s.accel[0] += 1.2 * shake;
                s.gyro[0] += 0.6 * (2.0 * t).sin();
            }
            if (2010..2030).contains(&i) {
                s.accel[1] += 2.0;
            }
        }
        let found = phases(&ImuRecording::new(samples).unwrap()).unwrap();
        let said: Vec<(Phase, f64, f64)> =
            found.iter().map(|s| (s.phase, s.from_s.round(), s.to_s.round())).collect();
        assert_eq!(
            said,
            [(Phase::Rest, 0.0, 20.0), (Phase::Motors, 20.0, 40.0), (Phase::Moving, 40.0, 60.0)]
        );
    }
}
