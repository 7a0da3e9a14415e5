//! Sensors whose values stand still for a while, to the last digit, and go on.
//!
//! A sensor at rest flickers, unless its steps are coarse: so one that stands still alone is named where the other one moves meanwhile, both together always.

use crate::finding::Finding;
use crate::text::instrument;
use dpn_core::{ImuSample, Recorded, Sensor};
use std::io;

/// Shorter than this \[s\], or of fewer rows, nothing is said.
const LEAST_S: f64 = 1.0;
const FEWEST: usize = 20;
/// Share of the log that stands still from which a sensor is dead, which is said elsewhere.
const DEAD: f64 = 0.95;
/// Deviation of the other sensor's axes that is motion: accelerometer, gyroscope \[m/s^2, rad/s\].
const MOVES: [f64; 2] = [0.5, 0.1];

/// Rows that say the same of a sensor, or of both.
#[derive(Default)]
struct Run {
    first: Option<ImuSample>,
    rows: f64,
    to_s: f64,
    /// Sums and squares of what the other sensor says, from its first.
    sums: [[f64; 2]; 3],
}

/// What stands still: both sensors, or one.
#[derive(Clone, Copy)]
struct Watched(Option<Sensor>);

impl Watched {
    fn same(self, a: &ImuSample, b: &ImuSample) -> bool {
        Sensor::ALL
            .into_iter()
            .all(|sensor| self.0.is_some_and(|own| own != sensor) || a.of(sensor) == b.of(sensor))
    }

    fn other(self) -> Option<Sensor> {
        self.0.map(|own| if own == Sensor::Gyro { Sensor::Accel } else { Sensor::Gyro })
    }
}

impl Run {
    /// Goes on with a row, or begins anew.
    fn take(&mut self, what: Watched, s: &ImuSample) {
        let Some(first) = self.first.filter(|first| what.same(first, s)) else {
            *self = Self { first: Some(*s), rows: 1.0, ..Self::default() };
            return;
        };
        (self.rows, self.to_s) = (self.rows + 1.0, s.t.seconds_since(first.t));
        if let Some(other) = what.other() {
            for (sums, (v, from)) in self.sums.iter_mut().zip(s.of(other).into_iter().zip(first.of(other))) {
                *sums = [sums[0] + (v - from), sums[1] + (v - from).powi(2)];
            }
        }
    }

    fn is_frozen(&self, what: Watched) -> bool {
        let moves = what.other().is_none_or(|other| {
            let most = MOVES[usize::from(other == Sensor::Gyro)];
            self.sums
                .iter()
                .any(|[sum, squares]| squares / self.rows - (sum / self.rows).powi(2) > most * most)
        });
        self.to_s >= LEAST_S && self.rows >= FEWEST as f64 && moves
    }
}

/// Where the first run begins and how long it lasts \[s\], how many there are, and how long they are together.
#[derive(Default)]
struct Found {
    first: Option<[f64; 2]>,
    count: usize,
    length_s: f64,
}

/// What is to be said.
///
/// # Errors
/// As [`Samples::piece`](dpn_core::Samples::piece).
pub(super) fn findings(recording: &dyn Recorded) -> io::Result<Vec<Finding>> {
    let start = recording.span()[0];
    let all = [None, Some(Sensor::Accel), Some(Sensor::Gyro)].map(Watched);
    let mut runs: [Run; 3] = Default::default();
    let mut found: [Found; 3] = Default::default();
    let end = |run: &Run, what: Watched, found: &mut Found| {
        if let Some(first) = run.first.filter(|_| run.is_frozen(what)) {
            found.first.get_or_insert([first.t.seconds_since(start), run.to_s]);
            (found.count, found.length_s) = (found.count + 1, found.length_s + run.to_s);
        }
    };
    recording.each(0..recording.len(), &mut |s| {
        for ((run, found), what) in runs.iter_mut().zip(&mut found).zip(all) {
            if run.first.is_some_and(|first| !what.same(&first, s)) {
                end(run, what, found);
            }
            run.take(what, s);
        }
    })?;
    for ((run, found), what) in runs.iter().zip(&mut found).zip(all) {
        end(run, what, found);
    }
    let both = found[0].count > 0;
    let told = found.into_iter().zip(all).filter(|(_, what)| what.0.is_none() || !both);
    let said = told.filter_map(|(Found { first, count, length_s }, what)| {
        let [from, for_s] = first.filter(|_| length_s < DEAD * recording.length_s())?;
        let who = what.0.map_or("both sensors".to_owned(), |sensor| format!("the {}", instrument(sensor)));
        let more = if count > 1 { format!(", {count} times, {length_s:.1} s in all") } else { String::new() };
        let text = format!("the values of {who} stand still for {for_s:.1} s from {from:.1} s on{more}, to the last digit");
        let remedy = "look at the sensor's bus, power and driver; leave these seconds out (--from, --to): an estimator takes them for measurements";
        Some(Finding::bad("frozen", text, remedy))
    });
    Ok(said.collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::doctor::values::tests::level;
    use dpn_core::ImuRecording;

    fn said(change: impl Fn(f64, &mut ImuSample, ImuSample)) -> Vec<String> {
        let mut samples = level(20);
        let held = samples[1000];
        samples.iter_mut().for_each(|s| change(s.t.ns() as f64 * 1e-9, s, held));
        findings(&ImuRecording::new(samples).unwrap()).unwrap().into_iter().map(|f| f.text).collect()
    }

    #[test]
    fn sensors_that_stand_still_are_named_and_coarse_ones_at_rest_and_dead_ones_are_not() {
        assert_eq!(said(|_, _, _| {}), [""; 0]);
        let frozen = |t: f64| (5.0..8.0).contains(&t) || (12.0..13.5).contains(&t);
        let both = said(|t, s, held| {
            if frozen(t) {
                (s.gyro, s.accel) = (held.gyro, held.accel);
            }
        });
        assert_eq!(
            both,
            [
                "the values of both sensors stand still for 3.0 s from 5.0 s on, 2 times, 4.5 s in all, to the last digit"
            ]
        );
        let moves = |t: f64, s: &mut ImuSample| s.accel[0] += 2.0 * (3.0 * t).sin();
        let gyro = said(|t, s, held| {
            moves(t, s);
            s.gyro = if frozen(t) { held.gyro } else { s.gyro };
        });
        assert!(
            gyro.len() == 1 && gyro[0].starts_with("the values of the gyroscope stand still"),
            "{gyro:?}"
        );
        // At rest its steps may be that coarse.
        assert_eq!(said(|t, s, held| s.gyro = if frozen(t) { held.gyro } else { s.gyro }), [""; 0]);
        let dead = said(|t, s, held| {
            moves(t, s);
            s.gyro = held.gyro;
        });
        assert_eq!(dead, [""; 0]);
    }
}
