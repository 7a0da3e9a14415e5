//! Rows that stand in a log once more, later and under stamps that go on: a part that was pasted, played or written again.
//!
//! Of every eight rows that differ there is a hash, and of those hashes one in so many is held, chosen by its value: a part and its copy have the same
//! ones. Where one comes again, both places are compared row by row. No sensor says a hundred rows of noise twice.

use crate::finding::Finding;
use dpn_core::{ImuSample, Recorded};
use std::collections::HashMap;
use std::collections::hash_map::Entry;
use std::io;

/// Rows that a hash is of.
const ROWS: usize = 8;
/// Hashes that are held, about.
const HELD: usize = 1 << 16;
/// A copy is at least so long \[s\], and has so many rows that are not the one before.
const LEAST_S: f64 = 1.0;
const LEAST: usize = 100;
/// Places that are compared: of a log of few values the same eight rows come again by chance.
const COMPARED: usize = 10_000;

fn is_same(a: &ImuSample, b: &ImuSample) -> bool {
    a.gyro == b.gyro && a.accel == b.accel
}

fn hash(values: impl IntoIterator<Item = u64>) -> u64 {
    let mixed = values
        .into_iter()
        .fold(0_u64, |all, v| (all ^ v).wrapping_mul(0x9e37_79b9_7f4a_7c15).rotate_left(31));
    mixed ^ mixed >> 29
}

/// Hashes of eight rows and where the last of these stands.
fn hashes(recording: &dyn Recorded) -> io::Result<Vec<(u64, usize)>> {
    let every = (recording.len() / HELD).next_power_of_two() as u64;
    let (mut held, mut last, mut rows) = (Vec::new(), None, [0; ROWS]);
    let (mut index, mut fresh) = (0, 0);
    recording.each(0..recording.len(), &mut |s| {
        if last.replace(*s).is_none_or(|last| !is_same(&last, s)) {
            rows.rotate_left(1);
            rows[ROWS - 1] = hash(s.gyro.iter().chain(&s.accel).map(|v| v.to_bits()));
            fresh += 1;
            let of_all = hash(rows);
            if fresh >= ROWS && of_all % every == 0 && held.len() < 4 * HELD {
                held.push((of_all, index));
            }
        }
        index += 1;
    })?;
    Ok(held)
}

/// How many rows behind those at `a` and `b` are the same, these among them.
fn behind(recording: &dyn Recorded, a: usize, b: usize) -> io::Result<usize> {
    let (mut count, mut many) = (0, 64);
    loop {
        let all = many.min(recording.len() - b - count);
        let [x, y] = [a, b].map(|from| recording.piece(from + count..from + count + all));
        let same = x?.iter().zip(y?.iter()).take_while(|(x, y)| is_same(x, y)).count();
        count += same;
        if same < all || all < many {
            return Ok(count);
        }
        many = 4096;
    }
}

/// How many rows before those at `a` and `b` are the same.
fn before(recording: &dyn Recorded, a: usize, b: usize) -> io::Result<usize> {
    let (mut count, mut many) = (0, 64);
    loop {
        let all = many.min(a - count);
        let [x, y] = [a, b].map(|to| recording.piece(to - count - all..to - count));
        let same = x?.iter().rev().zip(y?.iter().rev()).take_while(|(x, y)| is_same(x, y)).count();
        count += same;
        if same < all || all < many {
            return Ok(count);
        }
        many = 4096;
    }
}

/// What is to be said of rows that stand there once more.
///
/// # Errors
/// As [`Samples::piece`](dpn_core::Samples::piece).
pub(super) fn finding(recording: &dyn Recorded) -> io::Result<Option<Finding>> {
    let least = LEAST.max((LEAST_S * recording.rate().hz()) as usize);
    let (mut first, mut compared, mut done) = (HashMap::new(), 0, 0);
    // Where rows stand that stand there once more, and how many.
    let mut copies: Vec<(usize, usize, usize)> = Vec::new();
    for (of_all, at) in hashes(recording)? {
        let from = match first.entry(of_all) {
            Entry::Vacant(place) => {
                place.insert(at);
                continue;
            }
            Entry::Occupied(place) if at >= done && compared < COMPARED => *place.get(),
            Entry::Occupied(_) => continue,
        };
        compared += 1;
        let before = before(recording, from, at)?.min(at - done);
        let (from, at) = (from - before, at - before);
        let count = before + behind(recording, from + before, at + before)?;
        // What repeats itself sooner is a signal of a generator.
        if count > at - from && at - from < least {
            return Ok(None);
        }
        let count = count.min(at - from);
        if count < least {
            continue;
        }
        let (mut fresh, mut last) = (0, None);
        recording.each(at..at + count, &mut |s| {
            fresh += usize::from(last.replace(*s).is_none_or(|last| !is_same(&last, s)));
        })?;
        if fresh >= LEAST {
            copies.push((from, at, count));
            done = at + count;
        }
    }
    let Some((from, at, count)) = copies.iter().copied().max_by_key(|(.., count)| *count) else {
        return Ok(None);
    };
    let start = recording.span()[0];
    let second = |index: usize| Ok::<_, io::Error>(recording.at(index)?.t.seconds_since(start));
    let others =
        if copies.len() > 1 { format!("; {} such parts in all", copies.len()) } else { String::new() };
    let text = format!(
        "the {count} samples from {:.2} to {:.2} s are those from {:.2} to {:.2} s once more, to the last digit, under later stamps{others}",
        second(at)?,
        second(at + count - 1)?,
        second(from)?,
        second(from + count - 1)?,
    );
    Ok(Some(Finding::bad(
        "copies",
        text,
        "a part was pasted, or played and recorded, again: leave the second one out (--to, --from)",
    )))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::doctor::values::tests::level;
    use dpn_core::{ImuRecording, Stamp};

    fn of(rows: impl Iterator<Item = ImuSample>) -> Option<String> {
        let stamped =
            rows.enumerate().map(|(i, s)| ImuSample { t: Stamp::from_ns(i as i64 * 5_000_000), ..s });
        finding(&ImuRecording::new(stamped.collect()).unwrap()).unwrap().map(|found| found.text)
    }

    #[test]
    fn a_part_that_stands_there_twice_is_named_and_a_signal_that_repeats_itself_is_not() {
        let rows = level(40);
        assert_eq!(of(rows.iter().copied()), None);
        let pasted = [&rows[..6000], &rows[1000..2500], &rows[6000..], &rows[..300]].concat();
        assert_eq!(
            of(pasted.into_iter()).unwrap(),
            "the 1500 samples from 30.00 to 37.50 s are those from 5.00 to 12.50 s once more, to the last digit, under later stamps; 2 such parts in all"
        );
        let whole = of(rows.iter().chain(&rows).copied()).unwrap();
        assert!(whole.starts_with("the 8000 samples from 40.00 to "), "{whole}");
        // Every row four times, as a faster reader has it.
        let held = of((0..16_000).map(|i| rows[i / 4 % 2000])).unwrap();
        assert!(held.starts_with("the 8000 samples from 40.00 to "), "{held}");
        assert_eq!(of((0..8000).map(|i| rows[i % 160])), None);
        assert_eq!(of((0..8000).map(|i| if i < 4000 { rows[i] } else { rows[17] })), None);
    }
}
