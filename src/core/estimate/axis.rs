//! An estimator on one axis as samples come: asked every few samples for its window, or after every sample.

use super::WindowSigma;
use super::moving::Moving;
use std::sync::Arc;

/// What is known about one axis at a sample.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Reading {
    /// Nothing yet: too few samples so far.
    NotYet,
    /// An estimate, in the unit of the samples; may be zero.
    Estimate(f64),
    /// A figure given beforehand, to be taken as it is.
    Given(f64),
}

/// A causal source of one axis's deviation.
pub(crate) trait AxisSigma: Send {
    /// Takes the next sample and returns what is known at it.
    fn feed(&mut self, value: f64) -> Reading;

    /// Forgets everything fed so far.
    fn reset(&mut self);
}

/// The same figure at every sample.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Given(pub(crate) f64);

impl AxisSigma for Given {
    fn feed(&mut self, _value: f64) -> Reading {
        Reading::Given(self.0)
    }

    fn reset(&mut self) {}
}

/// What a window is put to: an estimator, or one that also remembers earlier windows.
pub(crate) trait Answer: Send {
    /// The deviation by `window` and by what was asked before.
    fn answer(&mut self, window: &[f64]) -> f64;

    /// Forgets what was asked before.
    fn forget(&mut self);
}

impl Answer for Arc<dyn WindowSigma> {
    fn answer(&mut self, window: &[f64]) -> f64 {
        self.sigma(window)
    }

    fn forget(&mut self) {}
}

/// A window estimator asked for the last `window` samples, first when there are so many, then every `hop` samples;
/// its answer holds in between.
pub(crate) struct HopWindow {
    asked: Box<dyn Answer>,
    window: usize,
    hop: usize,
    /// The last samples, oldest first, at most twice the window: moved to the front when full.
    recent: Vec<f64>,
    fed: usize,
    held: Reading,
}

impl HopWindow {
    /// Asks on a schedule of at least one sample each, with a window that is long enough.
    pub(crate) fn new(asked: Box<dyn Answer>, window: usize, hop: usize) -> Self {
        // Room is made as samples come: a window may be longer than any log.
        Self { asked, window, hop, recent: Vec::new(), fed: 0, held: Reading::NotYet }
    }
}

impl AxisSigma for HopWindow {
    fn feed(&mut self, value: f64) -> Reading {
        if self.recent.len() == self.window.saturating_mul(2) {
            self.recent.copy_within(self.window + 1.., 0);
            self.recent.truncate(self.window - 1);
        }
        self.recent.push(value);
        self.fed += 1;
        if self.fed >= self.window && (self.fed - self.window).is_multiple_of(self.hop) {
            let last = &self.recent[self.recent.len() - self.window..];
            self.held = Reading::Estimate(self.asked.answer(last));
        }
        self.held
    }

    fn reset(&mut self) {
        self.asked.forget();
        self.recent.clear();
        self.fed = 0;
        self.held = Reading::NotYet;
    }
}

/// A moving variance, asked after every sample once `warm_up` samples have been seen.
pub(crate) struct EachSample {
    estimator: Moving,
    warm_up: usize,
    fed: usize,
}

impl EachSample {
    /// Answers from sample number `warm_up` on, at the earliest from what the estimator needs.
    pub(crate) fn new(estimator: Moving, warm_up: usize) -> Self {
        Self { estimator, warm_up: warm_up.max(Moving::MIN_LEN), fed: 0 }
    }
}

impl AxisSigma for EachSample {
    fn feed(&mut self, value: f64) -> Reading {
        self.estimator.push(value);
        self.fed += 1;
        if self.fed < self.warm_up { Reading::NotYet } else { Reading::Estimate(self.estimator.now()) }
    }

    fn reset(&mut self) {
        self.estimator.reset();
        self.fed = 0;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::estimate::moving::Memory;

    /// Answers with the first and last value of the window, to see which window it got.
    struct Ends;

    impl WindowSigma for Ends {
        fn name(&self) -> &str {
            "ends"
        }
        fn min_len(&self) -> usize {
            2
        }
        fn sigma(&self, window: &[f64]) -> f64 {
            1000.0 * window[0] + window[window.len() - 1]
        }
    }

    #[test]
    fn it_is_asked_for_the_last_window_at_every_hop_and_holds_between() {
        let ends: Arc<dyn WindowSigma> = Arc::new(Ends);
        let mut axis = HopWindow::new(Box::new(ends), 5, 3);
        for i in 0..100_usize {
            let got = axis.feed(i as f64);
            let expected = if i < 4 {
                Reading::NotYet
            } else {
                let asked = i - (i - 4) % 3;
                Reading::Estimate(1000.0 * (asked - 4) as f64 + asked as f64)
            };
            assert_eq!(got, expected, "sample {i}");
        }
    }

    #[test]
    fn a_stream_and_its_window_form_agree_where_both_answer() {
        let sliding = Moving::new(Memory::Last(20)).unwrap();
        let mut each = EachSample::new(sliding.clone(), 20);
        let sliding: Arc<dyn WindowSigma> = Arc::new(sliding);
        let mut hop = HopWindow::new(Box::new(sliding), 20, 1);
        for i in 0..100 {
            let value = f64::from((i * 7919) % 211);
            match (each.feed(value), hop.feed(value)) {
                (Reading::Estimate(a), Reading::Estimate(b)) => assert!((a / b - 1.0).abs() < 1e-13),
                (a, b) => assert_eq!((a, b), (Reading::NotYet, Reading::NotYet)),
            }
        }
    }
}
