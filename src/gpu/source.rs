//! What examples are drawn from, on the card once for all draws.

use crate::kernels::draw::{Drawing, LevelDraw, RULE, draw};
use crate::plan::UNITS;
use crate::room::Room;
use cubecl::prelude::*;
use std::fmt;
use std::sync::OnceLock;

/// Changes to a window that leave the question the same.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Turns {
    /// Start up to a window later than its place.
    pub offset: bool,
    /// Flip the sign, half of the time.
    pub sign: bool,
    /// Run time backwards, half of the time.
    pub reverse: bool,
    /// Share of the windows that grow or shrink about their mean.
    pub grow_share: f64,
    /// Smallest and largest factor, log-uniform.
    pub factors: [f64; 2],
}

/// Recorded windows, how they are cleaned, and what is injected.
pub struct Source {
    /// Recorded axes, one behind the other.
    pub(crate) samples: Vec<f32>,
    /// A window's first sample among them and how far it may be shifted.
    pub(crate) places: Vec<[u32; 2]>,
    pub(crate) weights: Vec<f32>,
    pub(crate) starts: Vec<u32>,
    pub(crate) rule: [f32; RULE],
    pub(crate) drawing: Drawing,
    on_card: OnceLock<[Room; 5]>,
}

impl fmt::Debug for Source {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Source").field("windows", &self.places.len()).finish_non_exhaustive()
    }
}

impl Source {
    /// `filters` are the ways in which windows are cleaned, which they take in turn: matrices of `[window, window]`, row by row, whose rows sum to one.
    ///
    /// # Shapes
    /// `samples`: recorded axes, one behind the other; `places`: first sample and slack of every window of `window` samples.
    ///
    /// # Units and frames
    /// Samples and the levels from `low` to `high` in the sensor's unit.
    pub fn new(
        window: usize,
        samples: Vec<f32>,
        places: Vec<[u32; 2]>,
        filters: &[Vec<f64>],
        (levels, [low, high]): (LevelDraw, [f64; 2]),
        turns: Turns,
    ) -> Self {
        let rows = || filters.iter().flat_map(|filter| filter.chunks_exact(window));
        let reach = |row: &[f64]| {
            let first = row.iter().position(|w| *w != 0.0).unwrap_or(0);
            (first, row.iter().rposition(|w| *w != 0.0).map_or(1, |last| last + 1 - first))
        };
        let taps = rows().map(|row| reach(row).1).max().unwrap_or(1);
        let (mut weights, mut starts) = (Vec::new(), Vec::new());
        for row in rows() {
            let first = reach(row).0.min(window - taps);
            starts.push(first as u32);
            weights.extend(row[first..first + taps].iter().map(|w| *w as f32));
        }
        let [shrink, grow] = turns.factors;
        Self {
            samples,
            places,
            weights,
            starts,
            rule: [low, high, turns.grow_share, shrink, grow].map(|number| number as f32),
            drawing: Drawing {
                window,
                taps,
                kinds: filters.len(),
                levels,
                offset: turns.offset,
                sign: turns.sign,
                reverse: turns.reverse,
                grows: turns.grow_share > 0.0,
            },
            on_card: OnceLock::new(),
        }
    }

    /// Draws an example for each of `chosen`, window and number of the draw, and puts them from row `first` on.
    ///
    /// # Shapes
    /// `windows`: `[.., window]`; `labels`: `[..]`.
    pub(crate) fn draw(
        &self,
        client: &Client,
        chosen: &[[u32; 2]],
        key: [u32; 2],
        windows: &Room,
        labels: &Room,
        first: usize,
    ) {
        let [samples, places, weights, starts, rule] = self.on_card.get_or_init(|| {
            [
                Room::of(client, &self.samples),
                Room::of(client, self.places.as_flattened()),
                Room::of(client, &self.weights),
                Room::of(client, &self.starts),
                Room::of(client, &self.rule),
            ]
        });
        // A launch has at most 65,535 workgroups a dimension.
        for (number, chosen) in chosen.chunks(1 << 15).enumerate() {
            draw::launch(
                client,
                CubeCount::Static(chosen.len() as u32, 1, 1),
                CubeDim::new_1d(UNITS as u32),
                samples.arg(),
                places.arg(),
                weights.arg(),
                starts.arg(),
                Room::of(client, chosen.as_flattened()).arg(),
                rule.arg(),
                windows.arg(),
                labels.arg(),
                (first + (number << 15)) as u32,
                key[0],
                key[1],
                self.drawing,
            );
        }
    }
}
