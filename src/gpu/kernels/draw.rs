//! Examples made on the card: a recorded window, cleaned, turned about, with white noise of a drawn level on top.
//!
//! Chance is a function of its name, as everywhere in dpn: Threefry-2x32 of 20 rounds, keyed by the epoch, counts (example, lane). Which windows come in which order is
//! the processor's; levels, shifts and noise are this stream's own, not the processor's.
//!
//! Source: Salmon, Moraes, Dror and Shaw, "Parallel random numbers: as easy as 1, 2, 3", SC 2011.

use crate::plan::UNITS;
use cubecl::prelude::*;

/// How levels are drawn over `low..=high`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum LevelDraw {
    /// One of so many, evenly spaced.
    Grid(u32),
    /// Any, evenly.
    Uniform,
    /// Any, evenly in its logarithm.
    LogUniform,
}

/// What a drawing is compiled for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(crate) struct Drawing {
    pub(crate) window: usize,
    /// Samples that one cleaned sample is made of, and sets of such weights, which windows take in turn.
    pub(crate) taps: usize,
    pub(crate) kinds: usize,
    pub(crate) levels: LevelDraw,
    /// Start up to a window later; flip the sign, reverse time, half of the time.
    pub(crate) offset: bool,
    pub(crate) sign: bool,
    pub(crate) reverse: bool,
    pub(crate) grows: bool,
}

/// Numbers of the rule: low, high, share of windows that grow, smallest and largest factor.
pub(crate) const RULE: usize = 5;

#[cube]
fn mix(words: &mut Array<u32>, #[comptime] by: u32) {
    words[0] += words[1];
    words[1] = ((words[1] << by) | (words[1] >> comptime!(32 - by))) ^ words[0];
}

#[cube]
fn odd_rounds(words: &mut Array<u32>) {
    mix(words, 13u32);
    mix(words, 15u32);
    mix(words, 26u32);
    mix(words, 6u32);
}

#[cube]
fn even_rounds(words: &mut Array<u32>) {
    mix(words, 17u32);
    mix(words, 29u32);
    mix(words, 16u32);
    mix(words, 24u32);
}

/// Turns the two words of a counter into two random ones.
#[cube]
pub(crate) fn threefry(words: &mut Array<u32>, key0: u32, key1: u32) {
    let key2 = key0 ^ key1 ^ 0x1BD1_1BDA;
    words[0] += key0;
    words[1] += key1;
    odd_rounds(words);
    words[0] += key1;
    words[1] += key2 + 1;
    even_rounds(words);
    words[0] += key2;
    words[1] += key0 + 2;
    odd_rounds(words);
    words[0] += key0;
    words[1] += key1 + 3;
    even_rounds(words);
    words[0] += key1;
    words[1] += key2 + 4;
    odd_rounds(words);
    words[0] += key2;
    words[1] += key0 + 5;
}

/// A number between 0 and 1, neither of them.
#[cube]
fn unit(word: u32) -> f32 {
    (f32::cast_from(word >> 8) + 0.5) * comptime!(1.0 / 16_777_216.0f32)
}

/// Fills row `CUBE_POS_X` of this network's windows and labels.
///
/// # Shapes
/// `samples`: all recorded axes, one behind the other; `places`: `[windows, 2]`, a window's first sample and how far it may be shifted; `weights` and `starts`:
/// `[kinds, window, taps]` and `[kinds, window]`, what each cleaned sample is made of and the first recorded one in it; `chosen`: `[rows, 2]`, window and number of the
/// draw; `rule`: `[RULE]`. Out: `windows` from row `first` on, `[.., window]`, and `labels`, `[..]`.
#[cube(launch)]
#[allow(clippy::collapsible_if, reason = "the outer one is gone once the kernel is compiled")]
pub(crate) fn draw(
    samples: &[f32],
    places: &[u32],
    weights: &[f32],
    starts: &[u32],
    chosen: &[u32],
    rule: &[f32],
    windows: &mut [f32],
    labels: &mut [f32],
    first: u32,
    key0: u32,
    key1: u32,
    #[comptime] drawing: Drawing,
) {
    let length = comptime!(drawing.window);
    let row = CUBE_POS_X as usize;
    let (index, number) = (chosen[2 * row], chosen[2 * row + 1]);
    let mut words = Array::<u32>::new(2usize);
    // Lanes from 0 on: noise, a pair of samples each; the draw's own number in the upper half.
    let lane = number << 16;
    words[0] = index;
    words[1] = lane + 0xFFFF;
    threefry(&mut words, key0, key1);
    let (level_word, shift_word) = (words[0], words[1]);
    words[0] = index;
    words[1] = lane + 0xFFFE;
    threefry(&mut words, key0, key1);
    let (turn_word, growth_word) = (words[0], words[1]);
    let level: f32 = match comptime!(drawing.levels) {
        LevelDraw::Grid(count) => {
            let step = comptime!(1.0 / f32::max(count as f32 - 1.0, 1.0));
            let at =
                u32::min(u32::cast_from(unit(level_word) * comptime!(count as f32)), comptime!(count - 1));
            rule[0] + (rule[1] - rule[0]) * f32::cast_from(at) * step
        }
        LevelDraw::Uniform => rule[0] + (rule[1] - rule[0]) * unit(level_word),
        LevelDraw::LogUniform => rule[0] * (unit(level_word) * (rule[1] / rule[0]).ln()).exp(),
    };
    let mut from = places[2 * index as usize] as usize;
    if comptime!(drawing.offset) {
        let slack = places[2 * index as usize + 1];
        from += u32::min(u32::cast_from(unit(shift_word) * f32::cast_from(slack + 1)), slack) as usize;
    }
    let mut flips = false;
    if comptime!(drawing.sign) {
        flips = turn_word & 1 == 1;
    }
    let mut turns = false;
    if comptime!(drawing.reverse) {
        turns = turn_word & 2 == 2;
    }
    let kind = index as usize % comptime!(drawing.kinds);
    let about = samples[from];
    let mut clean = Shared::<[f32]>::new_slice(length);
    let mut t = UNIT_POS as usize;
    while t < length {
        let at = kind * length + t;
        let mut sum = 0.0f32;
        for tap in 0..comptime!(drawing.taps) {
            sum += weights[at * comptime!(drawing.taps) + tap]
                * (samples[from + starts[at] as usize + tap] - about);
        }
        clean[t] = sum;
        t += UNITS;
    }
    sync_cube();
    let mut factor = 1.0f32;
    let mut mean = 0.0f32;
    if comptime!(drawing.grows) {
        if unit(growth_word) < rule[2] {
            factor = rule[3] * (unit(turn_word) * (rule[4] / rule[3]).ln()).exp();
            for t in 0..length {
                mean += clean[t];
            }
            mean /= comptime!(length as f32);
        }
    }
    let to = (first as usize + row) * length;
    let mut pair = UNIT_POS as usize;
    while pair < comptime!(length.div_ceil(2)) {
        words[0] = index;
        words[1] = lane + pair as u32;
        threefry(&mut words, key0, key1);
        let log = unit(words[0]).ln();
        let radius = level * (log * -2.0f32).sqrt();
        let angle = unit(words[1]) * comptime!(std::f32::consts::TAU);
        let (cosine, sine) = (angle.cos(), angle.sin());
        #[unroll]
        for side in 0..2usize {
            let t = 2 * pair + side;
            if t < length {
                let place = select(turns, comptime!(length - 1) - t, t);
                let value = about + mean + factor * (clean[place] - mean);
                let noise = radius * select(side == 0, cosine, sine);
                windows[to + t] = select(flips, -value, value) + noise;
            }
        }
        pair += UNITS;
    }
    if UNIT_POS == 0 {
        labels[first as usize + row] = level;
    }
}
