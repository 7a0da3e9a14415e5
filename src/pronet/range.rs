//! What windows a network was trained on, in two numbers a window, so that windows unlike them can be counted.

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

/// The smallest and the largest figures among the training windows, injected noise included.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TrainedRange {
    /// Smallest and largest roughness \[the sensor's unit\].
    pub roughness: [f64; 2],
    /// Smallest and largest spread \[the sensor's unit\].
    pub spread: [f64; 2],
}

impl TrainedRange {
    /// The range of `windows`; none when there are none.
    pub fn spanning<'a>(windows: impl IntoIterator<Item = &'a [f32]>) -> Option<Self> {
        let mut range: Option<Self> = None;
        for window in windows {
            let f = WindowFigures::of(window);
            let widen = |[low, high]: [f64; 2], v: f64| [low.min(v), high.max(v)];
            range = Some(match range {
                None => Self { roughness: [f.roughness; 2], spread: [f.spread; 2] },
                Some(r) => {
                    Self { roughness: widen(r.roughness, f.roughness), spread: widen(r.spread, f.spread) }
                }
            });
        }
        range
    }

    /// Whether a window with these figures is unlike every training window.
    pub(crate) fn excludes(&self, f: WindowFigures) -> bool {
        let outside = |[low, high]: [f64; 2], v: f64| !(low..=high).contains(&v);
        outside(self.roughness, f.roughness) || outside(self.spread, f.spread)
    }
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
}
