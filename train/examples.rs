//! Fixed examples: what validation and evaluation are measured on.

use crate::draw::{DrawRule, inject};
use crate::label::Label;
use crate::levels::{LevelKind, Levels};
use crate::windows::WindowSet;
use dpn_core::random::Stream;

/// Noisy windows with their true deviation. Rows stand window by window, level by level.
#[derive(Debug, Clone)]
pub struct Examples {
    /// Noisy samples, [`width`](Self::width) a row.
    pub samples: Vec<f64>,
    /// Samples in a row.
    pub width: usize,
    /// Deviation injected into each row.
    pub injected: Vec<f64>,
    /// White noise each row's base held before.
    pub own: Vec<f64>,
    /// What the vibration of each row counts, its base's own where that is known and that added; 0 where there is none.
    pub effective: Vec<f64>,
    /// Window of the set each row comes from.
    pub window: Vec<usize>,
}

impl Examples {
    /// Every window of `set` at `levels.steps` levels: all grid points, or as many draws of a continuous range, one from
    /// each of `steps` equal slices so that every window meets the whole range.
    ///
    /// Row (window, level) draws from `stream.index(window).index(level)`.
    pub fn draw(set: &WindowSet, levels: &Levels, stream: &Stream) -> Self {
        let (rows, width) = (set.len() * levels.steps, set.window());
        let mut out = Self {
            samples: vec![0.0; rows * width],
            width,
            injected: Vec::with_capacity(rows),
            own: Vec::with_capacity(rows),
            effective: Vec::with_capacity(rows),
            window: Vec::with_capacity(rows),
        };
        let grid = levels.grid();
        let mut base = vec![0.0; width];
        for index in 0..set.len() {
            set.base_into(index, 0, &mut base);
            let (own, effective) = (set.own_sigma(&base), set.flight_sigma(index, &base));
            for (step, grid_level) in grid.iter().enumerate() {
                let mut rng = stream.index(index as u64).index(step as u64).rng();
                let level = match levels.kind {
                    LevelKind::Grid => *grid_level,
                    kind => slice(levels, kind, step).draw(&mut rng),
                };
                let row = out.injected.len();
                let window = &mut out.samples[row * width..(row + 1) * width];
                window.copy_from_slice(&base);
                inject(window, level, &mut rng);
                out.injected.push(level);
                out.own.push(own);
                out.effective.push(effective);
                out.window.push(index);
            }
        }
        out
    }

    /// Adds the vibration of `rule` to every row, and what its sensor does, each from `stream.index(row)`.
    pub(crate) fn disturb(&mut self, rule: &DrawRule, stream: &Stream) {
        for (row, window) in self.samples.chunks_exact_mut(self.width).enumerate() {
            let stream = stream.index(row as u64);
            let effects = rule.effects(&stream);
            self.effective[row] = self.effective[row].hypot(rule.vibrate(&effects, &stream, window));
            effects.apply(window, rule.rate);
        }
    }

    /// Number of rows.
    pub fn len(&self) -> usize {
        self.injected.len()
    }

    /// Whether there is no row.
    pub fn is_empty(&self) -> bool {
        self.injected.is_empty()
    }

    /// The samples of one row.
    pub fn row(&self, row: usize) -> &[f64] {
        &self.samples[row * self.width..(row + 1) * self.width]
    }

    /// What a perfect estimator would answer, row by row.
    pub fn truth(&self, label: Label) -> Vec<f64> {
        let beside = if label == Label::Effective { &self.effective } else { &self.own };
        self.injected.iter().zip(beside).map(|(&injected, &beside)| label.of(injected, beside)).collect()
    }
}

/// The `step`-th of `levels.steps` equal parts of a continuous range.
fn slice(levels: &Levels, kind: LevelKind, step: usize) -> Levels {
    let at = |share: f64| match kind {
        LevelKind::LogUniform => (levels.low.ln() + share * (levels.high / levels.low).ln()).exp(),
        _ => levels.low + share * (levels.high - levels.low),
    };
    let n = levels.steps as f64;
    Levels { kind, low: at(step as f64 / n), high: at((step + 1) as f64 / n), steps: 1 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::Base;
    use crate::windows::{Stretch, WINDOW};
    use dpn_core::{ImuRecording, ImuSample, Sensor, Stamp};

    fn flat(windows: usize) -> WindowSet {
        let samples = (0..windows * WINDOW)
            .map(|i| ImuSample {
                t: Stamp::from_ns(5_000_000 * i as i64),
                gyro: [0.1; 3],
                accel: [1.0, 2.0, 9.8],
            })
            .collect();
        let recording = ImuRecording::new(samples).unwrap();
        WindowSet::cut(&[("flat", &recording)], Sensor::Accel, Base::Raw, Stretch::Whole, WINDOW).unwrap()
    }

    #[test]
    fn a_flat_base_holds_exactly_the_injected_noise() {
        let set = flat(40);
        let examples = Examples::draw(&set, &Levels::paper(Sensor::Accel, LevelKind::Grid), &Stream::new(1));
        assert_eq!(examples.len(), 40 * 3 * 11);
        let mut ratios = 0.0;
        for row in 0..examples.len() {
            let x = examples.row(row);
            let mean = x.iter().sum::<f64>() / 200.0;
            let variance = x.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / 199.0;
            ratios += variance / examples.injected[row].powi(2);
        }
        // Variance ratio has deviation sqrt(2/199) a row; 1320 rows: 4 standard errors are .011.
        assert!((ratios / examples.len() as f64 - 1.0).abs() < 0.011);
        assert!(examples.own.iter().all(|own| own.abs() < 1e-12));
    }

    #[test]
    fn continuous_draws_cover_every_slice_once_a_window() {
        let levels = Levels::paper(Sensor::Gyro, LevelKind::Uniform);
        let examples = Examples::draw(&flat(3), &levels, &Stream::new(1));
        for (row, level) in examples.injected.iter().enumerate() {
            let slice = ((level - 0.001) / 0.014 * 8.0).floor() as usize;
            assert_eq!(slice.min(7), row % 8);
        }
    }
}
