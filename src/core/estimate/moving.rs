//! Moving variances: the deviation about a level that follows the samples, over a [`Memory`] of one of four kinds.
//!
//! One recursion on the innovation `d = x - level`: `level <- level + g d`, `squares <- k squares + w d^2`. Beside it run its
//! expectations for white noise of sigma 1: `u`, the level's variance, `e`, that of the squares, and `h`, half their variance. The answer is
//! `sqrt(squares / e) / c4(e^2 / h)`, so that neither the start nor the memory biases it (innovations are taken as uncorrelated in
//! the degrees of freedom alone).
//!
//! | memory | keeps `k` | gain `g` of sample n | weight `w` | source |
//! |---|---|---|---|---|
//! | `First` | 1 | 1 / n | 1 - g | Welford 1962 |
//! | `Fading` | 1 - a | 1 / W, `W <- k W + 1` | 1 - g | West 1979 |
//! | `Level` | 1 | p / (1 + p), `p <- p (1 - g) + q` | 1 / (1 + p) | Harvey 1989, sec. 4.2: the concentrated likelihood of a local level |
//! | `Last` | window | its mean | 1 | both passes over the samples kept; of thousands, the difference that one sample makes |
//!
//! `p` is the prediction variance of a level that steps by `q R` a sample under noise `R`, in units of `R`; its first sample fixes the level.

use super::quadratic::c4;
use super::{EstimatorError, WindowSigma};
use crate::signal::stats::{Ddof, deviation, mean, variance};

/// Samples of a window that are gone through anew at every question.
const TWO_PASSES: usize = 1000;

/// What a moving variance remembers.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Memory {
    /// `running(first)`: the first so many samples, held from then on, as drivers calibrate at power-up; all of them for `usize::MAX`. Right
    /// for a sensor at rest, far too large on a moving one, and slower to follow the longer it runs.
    First(usize),
    /// `sliding(length)`: the last so many samples, older ones forgotten at once.
    Last(usize),
    /// `ewma(alpha)`: sample `i` of `k` weighs `(1 - a)^(k - i)`; about `(2 - a) / a` samples. A jolt is forgotten slowly.
    Fading(f64),
    /// `kalman(q)`: all samples since the start, about a level that wanders by `sqrt(q)` sigma a sample: with .1 at 200 Hz what changes
    /// faster than about 10 Hz counts for noise.
    Level(f64),
}

impl Memory {
    fn name(self) -> String {
        match self {
            Self::First(usize::MAX) => "running".to_owned(),
            Self::First(first) => format!("running({first})"),
            Self::Last(length) => format!("sliding({length})"),
            Self::Fading(alpha) => format!("ewma({alpha})"),
            Self::Level(q) => format!("kalman({q})"),
        }
    }
}

/// A moving variance of one axis.
#[derive(Debug, Clone)]
pub(crate) struct Moving {
    name: String,
    memory: Memory,
    state: State,
}

#[derive(Debug, Clone, Default)]
struct State {
    count: usize,
    level: f64,
    squares: f64,
    /// `W` of a fading memory, `p` of a level.
    weight: f64,
    /// Under white noise of sigma 1: variance of the level, expectation and half the variance of the squares.
    level_spread: f64,
    expected: f64,
    half_spread: f64,
    /// The samples of a window, the oldest at `oldest` once it is full; their order does not matter.
    ring: Vec<f64>,
    oldest: usize,
}

impl Moving {
    /// Samples below which there is no answer.
    pub(crate) const MIN_LEN: usize = 2;

    /// Has seen nothing.
    ///
    /// # Errors
    /// A memory of fewer than two samples; a weight outside 0 to 1; a ratio not above 0 or beyond 100.
    pub(crate) fn new(memory: Memory) -> Result<Self, EstimatorError> {
        let (estimator, parameter, value, fits, range) = match memory {
            Memory::First(n) => ("running", "first", n as f64, n >= 2, "at least 2"),
            Memory::Last(n) => ("sliding", "length", n as f64, n >= 2, "at least 2"),
            Memory::Fading(a) => ("ewma", "alpha", a, a > 0.0 && a < 1.0, "above 0 and below 1"),
            Memory::Level(q) => ("kalman", "q", q, q > 0.0 && q <= 100.0, "above 0 and at most 100"),
        };
        if !fits {
            return Err(EstimatorError::Parameter { estimator, parameter, value, range });
        }
        Ok(Self { name: memory.name(), memory, state: State::default() })
    }

    /// Takes the next sample.
    pub(crate) fn push(&mut self, x: f64) {
        let s = &mut self.state;
        let d = x - s.level;
        match self.memory {
            Memory::First(first) if s.count == first => return,
            Memory::First(_) => {
                s.expected = s.count as f64;
                s.half_spread = s.expected;
                s.level += d / (s.count + 1) as f64;
                s.squares += d * (x - s.level);
            }
            Memory::Last(length) if s.ring.len() < length => {
                s.ring.push(x);
                s.level += d / s.ring.len() as f64;
                s.squares += d * (x - s.level);
            }
            Memory::Last(length) => {
                let old = std::mem::replace(&mut s.ring[s.oldest], x);
                let level = s.level + (x - old) / length as f64;
                s.squares += (x - old) * (x - level + old - s.level);
                s.level = level;
                s.oldest = (s.oldest + 1) % length;
                if s.oldest == 0 {
                    // Once round: what rounding left is taken out.
                    s.level = mean(&s.ring);
                    s.squares = variance(&s.ring, Ddof::Zero) * length as f64;
                }
            }
            Memory::Fading(alpha) => {
                let keep = 1.0 - alpha;
                s.weight = keep * s.weight + 1.0;
                let (gain, rest) = (1.0 / s.weight, 1.0 - 1.0 / s.weight);
                s.level += gain * d;
                s.squares = keep * s.squares + rest * d * d;
                let expected = rest * (1.0 + s.level_spread);
                s.expected = keep * s.expected + expected;
                s.half_spread = keep * keep * s.half_spread + expected * expected;
                s.level_spread = rest * rest * s.level_spread + gain * gain;
            }
            Memory::Level(q) if s.count == 0 => {
                (s.level, s.weight, s.level_spread) = (x, 1.0 + q, 1.0);
            }
            Memory::Level(q) => {
                let (spread, gain) = (1.0 + s.weight, s.weight / (1.0 + s.weight));
                s.level += gain * d;
                s.squares += d * d / spread;
                let expected = (1.0 + s.level_spread) / spread;
                s.expected += expected;
                s.half_spread += expected * expected;
                s.level_spread = (1.0 - gain).powi(2) * s.level_spread + gain * gain;
                s.weight = s.weight * (1.0 - gain) + q;
            }
        }
        s.count += 1;
    }

    /// The deviation by now, in the unit of the samples; NaN before [`MIN_LEN`](Self::MIN_LEN) of them.
    pub(crate) fn now(&self) -> f64 {
        let s = &self.state;
        match self.memory {
            _ if s.count < Self::MIN_LEN => f64::NAN,
            Memory::Last(_) if s.ring.len() <= TWO_PASSES => {
                deviation(&s.ring, Ddof::One) / c4((s.ring.len() - 1) as f64)
            }
            Memory::Last(_) => {
                let freedom = (s.ring.len() - 1) as f64;
                (s.squares.max(0.0) / freedom).sqrt() / c4(freedom)
            }
            _ => (s.squares / s.expected).sqrt() / c4(s.expected * s.expected / s.half_spread),
        }
    }

    /// Forgets everything pushed so far.
    pub(crate) fn reset(&mut self) {
        self.state = State::default();
    }
}

/// Asked for a window: the value after it, from fresh.
impl WindowSigma for Moving {
    fn name(&self) -> &str {
        &self.name
    }

    fn min_len(&self) -> usize {
        Self::MIN_LEN
    }

    fn sigma(&self, window: &[f64]) -> f64 {
        let mut fresh = self.clone();
        fresh.reset();
        window.iter().for_each(|x| fresh.push(*x));
        fresh.now()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn after(memory: Memory, x: &[f64]) -> Moving {
        let mut moving = Moving::new(memory).unwrap();
        x.iter().for_each(|x| moving.push(*x));
        moving
    }

    fn samples(count: i32, offset: f64) -> Vec<f64> {
        (0..count).map(|i| offset + f64::from((i * 7919) % 211)).collect()
    }

    #[test]
    fn the_running_recursion_gives_the_two_pass_deviation_under_a_large_offset() {
        let x = samples(500, 1e6);
        let expected = deviation(&x, Ddof::One) / c4(499.0);
        assert!((after(Memory::First(usize::MAX), &x).now() / expected - 1.0).abs() < 1e-10);
    }

    #[test]
    fn what_comes_after_the_first_samples_changes_nothing() {
        let of = |x: &[f64]| after(Memory::First(3), x).now();
        assert_eq!(of(&[1.0, 2.0, 4.0]), of(&[1.0, 2.0, 4.0, 1e9]));
    }

    #[test]
    fn only_the_last_samples_count_in_a_window() {
        let x = samples(50, 0.0);
        let (long, short) = (after(Memory::Last(8), &x), after(Memory::Last(8), &x[42..]));
        assert!((long.now() / short.now() - 1.0).abs() < 1e-14);
    }

    #[test]
    fn a_long_windows_recursion_is_its_two_passes_before_and_after_it_is_full() {
        let x = samples(6 * TWO_PASSES as i32, 1e4);
        for seen in [TWO_PASSES + 1, 2 * TWO_PASSES, 2 * TWO_PASSES + 1, 5 * TWO_PASSES, x.len()] {
            let kept = &x[seen.saturating_sub(2 * TWO_PASSES)..seen];
            let expected = deviation(kept, Ddof::One) / c4((kept.len() - 1) as f64);
            let got = after(Memory::Last(2 * TWO_PASSES), &x[..seen]).now();
            assert!((got / expected - 1.0).abs() < 1e-9, "{seen}: {got} {expected}");
        }
    }

    #[test]
    fn the_fading_recursion_is_the_weighted_deviation() {
        let (alpha, n) = (0.07, 60);
        let x: Vec<f64> = samples(n, 0.0).iter().map(|v| 9.81 + v / 100.0).collect();
        let state = after(Memory::Fading(alpha), &x).state;
        let weights: Vec<f64> = (0..n).rev().map(|age| (1.0 - alpha).powi(age)).collect();
        let total: f64 = weights.iter().sum();
        let mean = x.iter().zip(&weights).map(|(v, w)| v * w).sum::<f64>() / total;
        let squares: f64 = x.iter().zip(&weights).map(|(v, w)| w * (v - mean) * (v - mean)).sum();
        assert!((state.level / mean - 1.0).abs() < 1e-13);
        assert!((state.squares / squares - 1.0).abs() < 1e-12);
        // Expectation of the weighted squares under white noise: sum w - sum w^2 / sum w.
        let expected = total - weights.iter().map(|w| w * w).sum::<f64>() / total;
        assert!((state.expected / expected - 1.0).abs() < 1e-12);
    }

    #[test]
    fn the_prediction_variance_of_a_level_settles_at_the_riccati_root() {
        // p = p / (1 + p) + q  =>  p^2 - q p - q = 0
        let root = 0.5 * (0.1 + (0.01_f64 + 0.4).sqrt());
        assert!((after(Memory::Level(0.1), &[0.0; 200]).state.weight - root).abs() < 1e-14);
    }

    #[test]
    fn memories_out_of_range_are_refused() {
        let weights = [0.0, 1.0, -0.1, f64::NAN].map(Memory::Fading);
        let ratios = [0.0, -1.0, 101.0, f64::NAN].map(Memory::Level);
        for memory in [Memory::First(1), Memory::Last(1)].into_iter().chain(weights).chain(ratios) {
            assert!(Moving::new(memory).is_err(), "{memory:?}");
        }
    }
}
