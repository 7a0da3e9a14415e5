//! One level on its own, for an estimator that is not this one: fed the residuals that it whitens with the level in force, and their redundancies.
//!
//! The rule is the learner's (see [`super`]): the logarithm `x` of the variance's factor, information forgotten at the rate `1/memory`, and what is told
//! coming back at the same rate with the weight of half an observation.
//! ```text
//! I <- f I + (1 - f)/4 + r/2,   x <- x + ((v^T v - r)/2 - (1 - f)/4 x) / I,   f = exp(-dt/memory)
//! ```
//! `r` is the redundancy of the residual `v`: its rows, less what the states take up, `tr(J H^-1 J^T)` with the whitened Jacobian `J` and the states' covariance
//! `H^-1`. Without it, residuals that the states were fitted to look too small, and the level sinks.

/// What is told weighs so much in the long run: half an observation of a variance has the curvature of a quarter.
const TOLD_INFORMATION: f64 = 0.25;
/// A step of the logarithm that one residual may cause: one beyond all expectation is as often a fault as noise.
const MAX_STEP: f64 = 0.2;
/// No level goes beyond this many times what was told, up or down.
const WIDEST: f64 = 100.0;

/// By what a deviation that was told is to be multiplied, learned from residuals.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Level {
    memory_s: f64,
    /// Logarithm of the variance's factor.
    x: f64,
    information: f64,
}

impl Level {
    /// At what was told, believed as if `prior` residuals had said so; forgets within `memory_s` \[s\]. `None` unless both are positive and finite.
    pub fn new(memory_s: f64, prior: f64) -> Option<Self> {
        let positive = |v: f64| v.is_finite() && v > 0.0;
        (positive(memory_s) && positive(prior)).then_some(Self { memory_s, x: 0.0, information: 0.5 * prior })
    }

    /// The factor in force on the deviation told.
    pub fn factor(&self) -> f64 {
        (0.5 * self.x).exp()
    }

    /// Takes the sum of squares of a residual, whitened with the deviation told times [`Level::factor`], and its redundancy, `dt_s` after the one
    /// before. Returns whether they moved it: numbers that are none, or below zero, do not.
    pub fn feed(&mut self, dt_s: f64, squares: f64, redundancy: f64) -> bool {
        let sound = |v: f64| v.is_finite() && v >= 0.0;
        if !(sound(dt_s) && sound(squares) && sound(redundancy)) {
            return false;
        }
        let kept = (-dt_s / self.memory_s).exp();
        let back = (1.0 - kept) * TOLD_INFORMATION;
        self.information = kept * self.information + back + 0.5 * redundancy;
        let step = (0.5 * (squares - redundancy) - back * self.x) / self.information;
        let widest = 2.0 * WIDEST.ln();
        self.x = (self.x + step.clamp(-MAX_STEP, MAX_STEP)).clamp(-widest, widest);
        true
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use dpn_core::random::Stream;
    use rand_distr::{Distribution, StandardNormal};

    /// Means of `rows` observations taken out of their residuals, as an estimator's states are.
    fn learned(true_std: f64, told_std: f64, with_redundancy: bool) -> f64 {
        let mut rng = Stream::new(3).named("level").rng();
        let mut level = Level::new(10.0, 10.0).unwrap();
        let rows = 5;
        for _ in 0..2000 {
            let noise: Vec<f64> = (0..rows)
                .map(|_| {
                    let n: f64 = StandardNormal.sample(&mut rng);
                    true_std * n
                })
                .collect();
            let mean = noise.iter().sum::<f64>() / rows as f64;
            let sigma = told_std * level.factor();
            let squares = noise.iter().map(|n| ((n - mean) / sigma).powi(2)).sum();
            let redundancy = if with_redundancy { rows - 1 } else { rows };
            assert!(level.feed(0.05, squares, redundancy as f64));
        }
        level.factor()
    }

    #[test]
    fn the_level_is_the_true_deviation_over_the_one_told() {
        // 200 residuals are remembered, 4 degrees of freedom each: 1/sqrt(2 * 800) = 2.5 %.
        for factor in [0.25, 1.0, 3.0] {
            let got = learned(factor * 0.1, 0.1, true);
            assert!((got / factor - 1.0).abs() < 0.1, "{got} for {factor}");
        }
        // That a whitened residual should have the square of its rows is the wrong target.
        let wrong = learned(0.1, 0.1, false);
        assert!(wrong < 0.95, "{wrong}");
    }

    #[test]
    fn what_is_told_comes_back_and_what_is_no_number_moves_nothing() {
        let mut level = Level::new(1.0, 10.0).unwrap();
        for _ in 0..50 {
            level.feed(0.05, 40.0, 10.0);
        }
        let high = level;
        assert!(high.factor() > 1.5);
        for bad in [(f64::NAN, 1.0, 1.0), (0.1, f64::INFINITY, 1.0), (0.1, 1.0, -1.0), (-0.1, 1.0, 1.0)] {
            assert!(!level.feed(bad.0, bad.1, bad.2));
        }
        assert_eq!(level, high);
        for _ in 0..2000 {
            level.feed(0.05, 0.0, 0.0);
        }
        assert!((level.factor() - 1.0).abs() < 0.05, "{}", level.factor());
        assert!(Level::new(0.0, 1.0).is_none() && Level::new(1.0, f64::NAN).is_none());
    }
}
