//! Medians and quantiles of numbers that are gone through and not held: of a log of any length, to the bit, in constant memory.
//!
//! A number's bits, made to ascend with it, are a key of five digits of 13 bits. A pass counts, by their next digit, the keys that share the
//! digits known so far with the one sought, which tells that digit; five passes tell all. The levels of several columns share the passes.

use std::mem;

const DIGITS: u32 = 5;
const BITS: u32 = u64::BITS.div_ceil(DIGITS);

/// What is sought in a column.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Level {
    /// As [`stats::median`](super::stats::median).
    Median,
    /// As [`stats::upper_median`](super::stats::upper_median).
    UpperMedian,
    /// As [`stats::quantile`](super::stats::quantile), at a level in \[0, 1\].
    Quantile(f64),
}

impl Level {
    /// Ranks of the two numbers that it lies between, and how it is made of them.
    fn between(self, count: usize) -> ([usize; 2], impl Fn(f64, f64) -> f64) {
        let middle = count / 2;
        let (ranks, share) = match self {
            Self::Median if count.is_multiple_of(2) => ([middle - 1, middle], f64::NAN),
            Self::Median | Self::UpperMedian => ([middle, middle], 0.0),
            Self::Quantile(level) => {
                let place = level * (count - 1) as f64;
                let below = place.floor() as usize;
                ([below, (below + 1).min(count - 1)], place - below as f64)
            }
        };
        // A median is the mean of its two, which rounds otherwise than half of the way between them.
        (ranks, move |a, b| if share.is_nan() { 0.5 * (a + b) } else { a + share * (b - a) })
    }
}

/// Numbers of which some are sought.
#[derive(Debug, Clone, Copy)]
pub struct Column<'a> {
    /// How many of them a pass hands over.
    pub count: usize,
    /// What is sought.
    pub levels: &'a [Level],
}

/// Bits that ascend with the number, as `f64::total_cmp` does.
fn key(value: f64) -> u64 {
    let bits = value.to_bits();
    if bits >> 63 == 1 { !bits } else { bits | 1 << 63 }
}

fn value(key: u64) -> f64 {
    f64::from_bits(if key >> 63 == 1 { key & !(1 << 63) } else { !key })
}

/// One rank of a column.
struct Sought {
    /// Among the numbers that share the digits known.
    rank: u64,
    /// The digits known, at their places.
    known: u64,
    /// Numbers by their next digit; empty where the rank before has the same.
    counts: Vec<u64>,
}

/// The levels sought, a list a column; NaN where a column has no number. `pass` goes through the same numbers each time, in any order, and hands
/// each with its column's place to the function that it is given.
///
/// # Errors
/// Those of `pass`.
pub fn levels<E>(
    columns: &[Column<'_>],
    mut pass: impl FnMut(&mut dyn FnMut(usize, f64)) -> Result<(), E>,
) -> Result<Vec<Vec<f64>>, E> {
    let ranks = |c: &Column<'_>| -> Vec<Sought> {
        let wanted = c.levels.iter().filter(|_| c.count > 0).flat_map(|level| level.between(c.count).0);
        wanted.map(|rank| Sought { rank: rank as u64, known: 0, counts: Vec::new() }).collect()
    };
    let mut sought: Vec<Vec<Sought>> = columns.iter().map(ranks).collect();
    let passes = if sought.iter().all(Vec::is_empty) { 0 } else { DIGITS };
    for digit in (0..passes).rev() {
        let shift = digit * BITS;
        let above = |key: u64| key.checked_shr(shift + BITS).unwrap_or(0);
        for column in &mut sought {
            for at in 0..column.len() {
                let same = at > 0 && above(column[at - 1].known) == above(column[at].known);
                column[at].counts = vec![0; if same { 0 } else { 1 << BITS }];
            }
        }
        pass(&mut |column, value| {
            let key = key(value);
            for one in sought[column].iter_mut().filter(|one| !one.counts.is_empty()) {
                if above(key) == above(one.known) {
                    one.counts[(key >> shift) as usize & ((1 << BITS) - 1)] += 1;
                }
            }
        })?;
        for column in &mut sought {
            let mut counts = Vec::new();
            for one in column {
                if !one.counts.is_empty() {
                    counts = mem::take(&mut one.counts);
                }
                let mut digit = 0;
                while one.rank >= counts[digit] {
                    one.rank -= counts[digit];
                    digit += 1;
                }
                one.known |= (digit as u64) << shift;
            }
        }
    }
    let of = |(column, found): (&Column<'_>, &Vec<Sought>)| {
        let mut pairs = found.chunks_exact(2);
        let level = |level: &Level| {
            pairs.next().map_or(f64::NAN, |pair| {
                level.between(column.count).1(value(pair[0].known), value(pair[1].known))
            })
        };
        column.levels.iter().map(level).collect()
    };
    Ok(columns.iter().zip(&sought).map(of).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::signal::stats;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn levels_are_those_of_the_numbers_held_to_the_bit(
            wide in prop::collection::vec(prop::num::f64::NORMAL | prop::num::f64::ZERO, 0..40),
            near in prop::collection::vec(-3i32..3, 1..60),
            level in 0.0f64..=1.0,
        ) {
            // Half of wide and of near numbers overflow or tie.
            let near: Vec<f64> = near.into_iter().map(|n| 9.81 + f64::from(n) * f64::EPSILON).collect();
            let asked = [Level::Quantile(level), Level::Median, Level::UpperMedian, Level::Quantile(0.05)];
            let columns = [&wide, &near].map(|x| Column { count: x.len(), levels: &asked });
            let found = levels(&columns, |take| {
                wide.iter().for_each(|v| take(0, *v));
                near.iter().for_each(|v| take(1, *v));
                Ok::<(), ()>(())
            });
            for (x, found) in [&wide, &near].into_iter().zip(found.unwrap()) {
                let upper = stats::upper_median(x.iter().copied()).unwrap_or(f64::NAN);
                let held = [stats::quantile(x, level), stats::median(x), upper, stats::quantile(x, 0.05)];
                prop_assert_eq!(held.map(f64::to_bits).to_vec(), found.iter().map(|v| v.to_bits()).collect::<Vec<_>>());
            }
        }
    }
}
