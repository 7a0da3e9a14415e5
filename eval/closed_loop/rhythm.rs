//! The rhythm of images by their stamps: how often they come, and where they do not.

use dpn_core::Stamp;
use dpn_core::signal::stats::upper_median;
use serde::{Deserialize, Serialize};

/// A hole is at least so long \[s\]: over less, points are followed as well as ever.
const LEAST_HOLE_S: f64 = 0.25;
/// And so many times the usual step.
const LEAST_STEPS: f64 = 2.5;
/// Images that come slower than this are worth a word \[s\].
const SLOW_S: f64 = 0.13;
/// A share of missing images that is worth a word.
const MANY_MISSING: f64 = 0.2;
/// So many holes are said one by one.
const SHOWN: usize = 3;

/// Images that did not come.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Hole {
    /// Since the first image, the last one before it \[s\].
    pub from_s: f64,
    /// How long \[s\].
    pub seconds: f64,
}

/// How images, or frames of tracks, come.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct Rhythm {
    /// From one to the next, median \[s\]; 0 for fewer than two.
    pub period_s: f64,
    /// Where none came for long, the longest first.
    pub holes: Vec<Hole>,
    /// Share of those that should have come at this rhythm and did not, holes apart.
    pub missing: f64,
}

impl Rhythm {
    /// Of stamps in increasing time.
    pub(super) fn of(stamps: impl Iterator<Item = Stamp>) -> Self {
        let mut stamps = stamps.peekable();
        let Some(first) = stamps.peek().copied() else { return Self::default() };
        let mut last = first;
        let mut steps = Vec::new();
        for t in stamps.skip(1) {
            steps.push(Hole { from_s: last.seconds_since(first), seconds: t.seconds_since(last) });
            last = t;
        }
        let Some(period_s) =
            upper_median(steps.iter().map(|step| step.seconds)).filter(|period| *period > 0.0)
        else {
            return Self::default();
        };
        let is_hole = |step: &Hole| step.seconds > LEAST_HOLE_S.max(LEAST_STEPS * period_s);
        let (mut holes, others): (Vec<Hole>, Vec<Hole>) = steps.into_iter().partition(is_hole);
        holes.sort_by(|a, b| b.seconds.total_cmp(&a.seconds));
        let due: f64 = others.iter().map(|step| (step.seconds / period_s).round()).sum();
        let missing = if due > 0.0 { (1.0 - others.len() as f64 / due).max(0.0) } else { 0.0 };
        Self { period_s, holes, missing }
    }

    /// What is worth a word, a sentence each; `what` comes: images, or frames of tracks.
    pub(super) fn remarks(&self, what: &str) -> Vec<String> {
        let mut said = Vec::new();
        if !self.holes.is_empty() {
            let shown: Vec<String> = self
                .holes
                .iter()
                .take(SHOWN)
                .map(|hole| format!("{:.2} s from {:.2} s on", hole.seconds, hole.from_s))
                .collect();
            let more = self.holes.len().saturating_sub(SHOWN);
            let more = if more > 0 { format!(" and {more} shorter ones") } else { String::new() };
            said.push(format!(
                "no {what} for {}{more}, {:.3} s apart otherwise: over a hole the path rests on the IMU alone",
                shown.join(", "),
                self.period_s
            ));
        }
        if self.missing > MANY_MISSING {
            said.push(format!(
                "{:.0} % of the {what} seem to be missing: {:.3} s apart as a rule, and often a multiple of it",
                100.0 * self.missing,
                self.period_s
            ));
        }
        if self.period_s > SLOW_S {
            said.push(format!(
                "{what} come {:.1} times a second: from 10 on a moving camera's points are followed well",
                1.0 / self.period_s
            ));
        }
        said
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rhythm(ms: impl Iterator<Item = i64>) -> Rhythm {
        Rhythm::of(ms.map(|ms| Stamp::from_ns(ms * 1_000_000)))
    }

    #[test]
    fn holes_missing_images_and_slow_ones_are_said_and_a_steady_rhythm_is_not() {
        assert_eq!(rhythm(std::iter::empty()), Rhythm::default());
        let steady = rhythm((0..100).map(|k| 50 * k + k % 3));
        assert!(steady.remarks("images").is_empty() && steady.missing < 0.01, "{steady:?}");
        let hole = rhythm((0..100).filter(|k| !(40..56).contains(k) && *k != 80).map(|k| 50 * k));
        let [Hole { from_s, seconds }] = hole.holes[..] else { panic!("{hole:?}") };
        assert!((from_s - 1.95).abs() < 1e-9 && (seconds - 0.85).abs() < 1e-9, "{hole:?}");
        let said = hole.remarks("images");
        assert!(
            said.len() == 1 && said[0].starts_with("no images for 0.85 s from 1.95 s on, 0.050 s apart"),
            "{said:?}"
        );
        let dropped = rhythm((0..100).filter(|k| k % 4 != 1).map(|k| 50 * k));
        assert!((dropped.missing - 0.25).abs() < 0.02 && dropped.remarks("images").len() == 1, "{dropped:?}");
        let slow = rhythm((0..30).map(|k| 200 * k)).remarks("frames");
        assert!(slow.len() == 1 && slow[0].starts_with("frames come 5.0 times a second"), "{slow:?}");
    }
}
