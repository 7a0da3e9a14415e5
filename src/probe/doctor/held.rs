//! A sensor whose values are held on rows of a faster one, in motion: where a value changes by much before and behind, it should stand on one row.
//!
//! At rest a coarse converter's values stay the same by chance, so only values that differ on two axes by several of its steps from both neighbours tell; the noise at rest
//! (`rest_noise`) says the same of a sensor that lies still.

use crate::finding::Finding;
use dpn_core::{Recorded, Sensor};
use std::io;

/// A change by so many of an axis' least ones is no chance.
const STEPS: f64 = 4.0;
/// Rows that may hold one value; more is a sensor that stands still.
const MOST: usize = 20;
/// Values that tell, and the share of rows that are the one before from which values are held.
const LEAST: usize = 500;
const SHARE: f64 = 0.05;

fn changes(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    std::array::from_fn(|axis| (b[axis] - a[axis]).abs())
}

/// Rows a value of this sensor stands on, on average, where it changes by much; none where too few do.
fn rows_a_value(recording: &dyn Recorded, sensor: Sensor) -> io::Result<Option<f64>> {
    let mut least = [f64::INFINITY; 3];
    recording.pairs(&mut |a, b| {
        for (least, change) in least.iter_mut().zip(changes(a.of(sensor), b.of(sensor))) {
            *least = if change > 0.0 { least.min(change) } else { *least };
        }
    })?;
    let is_large =
        |a, b| changes(a, b).iter().zip(least).filter(|(c, least)| **c >= STEPS * least).count() >= 2;
    // Rows of the value at hand, and whether it came by a large change.
    let (mut rows, mut came, mut values, mut all) = (1, false, 0_usize, 0_usize);
    recording.pairs(&mut |a, b| {
        let (a, b) = (a.of(sensor), b.of(sensor));
        if a == b {
            rows += 1;
            return;
        }
        let goes = is_large(a, b);
        if came && goes && rows <= MOST {
            values += 1;
            all += rows;
        }
        (rows, came) = (1, goes);
    })?;
    Ok((values >= LEAST).then(|| all as f64 / values as f64))
}

/// What is to be said where one sensor's values are held and the other's are not.
///
/// # Errors
/// As [`Samples::piece`](dpn_core::Samples::piece).
pub(super) fn finding(recording: &dyn Recorded) -> io::Result<Option<Finding>> {
    let mut on = [None; 2];
    for (on, sensor) in on.iter_mut().zip(Sensor::ALL) {
        *on = rows_a_value(recording, sensor)?;
    }
    let is_held = |on: f64| 1.0 - on.recip() > SHARE;
    // Of both, rows repeat, or little is known.
    let (sensor, rows) = match on {
        [Some(first), Some(second)] if is_held(first) && !is_held(second) => (Sensor::ALL[0], first),
        [Some(first), Some(second)] if is_held(second) && !is_held(first) => (Sensor::ALL[1], second),
        _ => return Ok(None),
    };
    let hz = recording.rate().hz();
    let text = format!(
        "{sensor}: in motion a value stands on {rows:.2} rows: values of {:.0} Hz are held on rows of {hz:.0} Hz",
        hz / rows
    );
    Ok(Some(Finding::warning(
        "held",
        text,
        "log each sensor at its own rate; noise per row is wrong like this, and every value counts more than once",
    )))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::doctor::turned::tests::waved;
    use crate::doctor::values::tests::level;
    use dpn_core::{ImuRecording, ImuSample, Samples};

    #[test]
    fn values_that_are_held_in_motion_are_named_with_their_rate_and_coarse_ones_are_not() {
        let of = |samples: Vec<ImuSample>| finding(&ImuRecording::new(samples).unwrap()).unwrap();
        let moving = waved(|_| {}).all().unwrap().into_owned();
        assert_eq!(of(moving.clone()), None);
        let held = |every: fn(usize) -> usize| {
            let rows = moving.iter().enumerate();
            of(rows.map(|(i, s)| ImuSample { accel: moving[every(i)].accel, ..*s }).collect())
                .map(|found| found.text)
        };
        let third = held(|i| i - usize::from(i % 3 == 2)).unwrap();
        assert!(
            third.ends_with("stands on 1.50 rows: values of 133 Hz are held on rows of 200 Hz"),
            "{third}"
        );
        let fourth = held(|i| i / 4 * 4).unwrap();
        assert!(fourth.contains("stands on 4.00 rows: values of 50 Hz"), "{fourth}");
        let coarse = level(40)
            .into_iter()
            .map(|s| ImuSample { accel: s.accel.map(|v| (v / 0.05).round() * 0.05), ..s });
        assert_eq!(of(coarse.collect()), None);
    }
}
