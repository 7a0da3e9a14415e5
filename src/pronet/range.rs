//! What windows a network was trained on, in three numbers a window, so that windows unlike them can be counted.

use dpn_core::SampleRate;
use dpn_core::signal::Welch;
use serde::{Deserialize, Serialize};

/// Two figures of one window, in the sensor's unit.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct WindowFigures {
    /// Root mean square of the second differences over `sqrt(6)`: the deviation itself, were the window white noise.
    pub roughness: f64,
    /// Standard deviation about the window's mean.
    pub spread: f64,
}

impl WindowFigures {
    /// The figures of `window`; zeros for fewer than three samples.
    pub fn of(window: &[f32]) -> Self {
        if window.len() < 3 {
            return Self { roughness: 0.0, spread: 0.0 };
        }
        let n = window.len() as f64;
        let mean = window.iter().map(|v| f64::from(*v)).sum::<f64>() / n;
        let variance = window.iter().map(|v| (f64::from(*v) - mean).powi(2)).sum::<f64>() / n;
        let second = |w: &[f32]| f64::from(w[2]) - 2.0 * f64::from(w[1]) + f64::from(w[0]);
        let square = window.windows(3).map(|w| second(w).powi(2)).sum::<f64>() / (n - 2.0);
        Self { roughness: (square / 6.0).sqrt(), spread: variance.sqrt() }
    }
}

/// The quietest part of a window's spectrum.
///
/// White noise fills the whole band, so a network that says a deviation whose power is missing somewhere was asked about samples behind a low pass that its
/// training did not have.
pub struct Quietest {
    welch: Welch,
}

impl std::fmt::Debug for Quietest {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Quietest").finish_non_exhaustive()
    }
}

/// Parts that the band is looked at in; the lowest may be motion, and is not asked.
const PARTS: usize = 4;

impl Quietest {
    /// For windows of `len` samples; none where they are too short to tell parts of their band.
    pub fn new(len: usize) -> Option<Self> {
        // Three segments a window and more, for a mean that chance moves by a fifth.
        let segment = 1 << (len / 3).checked_ilog2()?;
        (segment >= 4 * PARTS)
            .then(|| Self { welch: Welch::new(segment).expect("a segment of 16 samples or more") })
    }

    /// Deviation of white noise that is everywhere as dense as the quietest quarter of the band, the lowest left out \[the window's unit\]: of white noise some
    /// four fifths of its own. NaN of samples that are no numbers.
    ///
    /// # Panics
    /// When `window` is shorter than was said.
    pub fn sigma(&self, window: &[f32]) -> f64 {
        let samples: Vec<f64> = window.iter().map(|v| f64::from(*v)).collect();
        // One sample a second: a density is then twice the variance.
        let rate = SampleRate::from_hz(1.0).expect("1 Hz is a rate");
        let spectrum = self.welch.spectrum(&samples, rate).expect("a window is longer than its segments");
        let bins = &spectrum.density()[1..];
        let mean = |part: &[f64]| part.iter().sum::<f64>() / part.len() as f64;
        let least = bins.chunks(bins.len() / PARTS).skip(1).map(mean).fold(f64::INFINITY, f64::min);
        (0.5 * least).sqrt()
    }
}

/// The smallest and the largest figures among the training windows, injected noise included.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TrainedRange {
    /// Smallest and largest roughness \[the sensor's unit\].
    pub roughness: [f64; 2],
    /// Smallest and largest spread \[the sensor's unit\].
    pub spread: [f64; 2],
    /// Least and most of what the quietest part of the band has ([`Quietest`]) over what the network answers, but for a window of a thousand at either end; not
    /// looked at when not given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub quietest: Option<[f64; 2]>,
}

/// Share of windows outside the range from which it is shouted.
pub const LOUD: f64 = 0.1;

/// Share of the training windows beyond either end of [`TrainedRange::quietest`].
const BEYOND: f64 = 1e-3;

impl TrainedRange {
    /// The range of `windows`; none when there are none.
    pub fn spanning<'a>(windows: impl IntoIterator<Item = &'a [f32]>) -> Option<Self> {
        let mut range: Option<Self> = None;
        for window in windows {
            let f = WindowFigures::of(window);
            let widen = |[low, high]: [f64; 2], v: f64| [low.min(v), high.max(v)];
            range = Some(match range {
                None => Self { roughness: [f.roughness; 2], spread: [f.spread; 2], quietest: None },
                Some(r) => Self {
                    roughness: widen(r.roughness, f.roughness),
                    spread: widen(r.spread, f.spread),
                    quietest: None,
                },
            });
        }
        range
    }

    /// The same with the range of what the quietest part of the band has over the network's answers.
    ///
    /// # Shapes
    /// One of `sigma` for each of `windows`, which have one length.
    #[must_use]
    pub fn with_answers<'a>(self, windows: impl ExactSizeIterator<Item = &'a [f32]>, sigma: &[f64]) -> Self {
        let mut quietest: Option<Quietest> = None;
        let mut ratios = Vec::with_capacity(windows.len());
        for (window, sigma) in windows.zip(sigma) {
            if quietest.is_none() {
                quietest = Quietest::new(window.len());
            }
            let ratio = quietest.as_ref().map(|quietest| quietest.sigma(window) / sigma);
            ratios.extend(ratio.filter(|ratio| ratio.is_finite()));
        }
        ratios.sort_unstable_by(f64::total_cmp);
        let beyond = (BEYOND * ratios.len() as f64) as usize;
        let ends = ratios.get(beyond).zip(ratios.iter().rev().nth(beyond));
        Self { quietest: ends.map(|(least, most)| [*least, *most]), ..self }
    }

    /// Whether `window`, or what the network answers to it, `sigma`, is unlike all of the training; `quietest` is that of windows of its length.
    pub fn is_outside(&self, window: &[f32], sigma: f64, quietest: Option<&Quietest>) -> bool {
        let excludes_answer = |quietest: &Quietest| self.excludes_answer(quietest.sigma(window), sigma);
        self.excludes(WindowFigures::of(window)) || quietest.is_some_and(excludes_answer)
    }

    /// Whether a window with these figures is unlike every training window.
    fn excludes(&self, f: WindowFigures) -> bool {
        is_outside(self.roughness, f.roughness) || is_outside(self.spread, f.spread)
    }

    /// Whether the quietest part of the band has so much of `sigma`, the answer, as none of the training has.
    fn excludes_answer(&self, quietest: f64, sigma: f64) -> bool {
        self.quietest.is_some_and(|range| is_outside(range, quietest / sigma))
    }
}

/// NaN is outside.
fn is_outside([low, high]: [f64; 2], value: f64) -> bool {
    !(low..=high).contains(&value)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_figures_of_an_alternating_window_are_known() {
        // x = +-1: second differences are +-4, so roughness is 4 / sqrt(6); the spread is 1.
        let window: Vec<f32> = (0..200).map(|i| if i % 2 == 0 { 1.0 } else { -1.0 }).collect();
        let f = WindowFigures::of(&window);
        assert!((f.roughness - 4.0 / 6f64.sqrt()).abs() < 1e-12);
        assert!((f.spread - 1.0).abs() < 1e-12);
    }

    #[test]
    fn a_line_has_spread_but_no_roughness() {
        let window: Vec<f32> = (0..200).map(|i| i as f32).collect();
        let f = WindowFigures::of(&window);
        assert_eq!(f.roughness, 0.0);
        // Variance of 0..n: (n^2 - 1) / 12.
        assert!((f.spread - (39_999f64 / 12.0).sqrt()).abs() < 1e-9);
    }

    #[test]
    fn the_range_spans_its_windows_and_excludes_a_louder_one() {
        let quiet: Vec<f32> = (0..50).map(|i| (i % 2) as f32).collect();
        let loud: Vec<f32> = quiet.iter().map(|v| 3.0 * v).collect();
        let louder: Vec<f32> = quiet.iter().map(|v| 3.1 * v).collect();
        let range = TrainedRange::spanning([quiet.as_slice(), &loud]).unwrap();
        assert!(!range.excludes(WindowFigures::of(&quiet)) && !range.excludes(WindowFigures::of(&loud)));
        assert!(range.excludes(WindowFigures::of(&louder)));
        assert!(TrainedRange::spanning([]).is_none());
    }

    #[test]
    fn what_a_low_pass_takes_is_missing_from_the_quietest_part_of_the_band() {
        use dpn_core::random::Stream;
        use rand::Rng;
        let mut rng = Stream::new(4).named("quietest").rng();
        let mut white = || (0..200).map(|_| 12f32.sqrt() * (rng.random::<f32>() - 0.5)).collect::<Vec<_>>();
        let windows: Vec<Vec<f32>> = (0..2000).map(|_| white()).collect();
        let range = TrainedRange::spanning(windows.iter().map(Vec::as_slice)).unwrap();
        let range = range.with_answers(windows.iter().map(Vec::as_slice), &[1.0; 2000]);
        let [least, most] = range.quietest.unwrap();
        assert!((0.4..0.8).contains(&least) && (0.8..1.2).contains(&most), "{least} {most}");
        let quietest = Quietest::new(200).unwrap();
        let mut outside = [0, 0];
        for window in &windows {
            // Three passes of one pole at 20 Hz.
            let mut slow = window.clone();
            for _ in 0..3 {
                let mut held = 0.0;
                slow.iter_mut().for_each(|v| {
                    held += 0.47 * (*v - held);
                    *v = held;
                });
            }
            for (outside, samples) in outside.iter_mut().zip([window, &slow]) {
                *outside += u32::from(range.excludes_answer(quietest.sigma(samples), 1.0));
            }
        }
        assert!(outside[0] <= 4 && outside[1] == 2000, "{outside:?}");
        assert!(range.excludes_answer(f64::NAN, 1.0) && Quietest::new(40).is_none());
    }
}
