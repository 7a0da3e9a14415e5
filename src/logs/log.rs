//! A log that was read, and what is to be said of it.

use crate::Kind;
use dpn_core::Samples;
use dpn_io::{LeftOut, Sieved, StoredRecording};

/// A recording and where it came from.
#[derive(Debug)]
pub struct Log {
    /// What kind of log it was.
    pub kind: Kind,
    /// The bag's topic.
    pub topic: Option<String>,
    /// The samples of use.
    pub recording: StoredRecording,
    /// Samples left out.
    pub sieved: Sieved,
    /// What the places of [`Sieved`] count: `line`, `message` or `record`.
    pub place: &'static str,
    /// What was wrong where the log ended early or could not be read.
    pub damage: Option<String>,
    /// What was guessed or taken for granted.
    pub guesses: Vec<String>,
    /// All else that should be known, one line each.
    pub remarks: Vec<String>,
    /// The rate that the log's own text names \[Hz\].
    pub said_hz: Option<f64>,
}

impl Log {
    /// A recording that is as it should be.
    pub fn sound(kind: Kind, recording: impl Into<StoredRecording>) -> Self {
        Self {
            kind,
            topic: None,
            recording: recording.into(),
            sieved: Sieved::default(),
            place: "line",
            damage: None,
            guesses: Vec::new(),
            remarks: Vec::new(),
            said_hz: None,
        }
    }

    /// What a person must know before trusting a figure made from it: damage, and samples that were left out. A line each.
    pub fn warnings(&self) -> Vec<String> {
        let used = || format!("the {} samples before the damage are used", self.recording.len());
        let mut all: Vec<String> =
            self.damage.iter().map(|damage| format!("damaged log: {damage}; {}", used())).collect();
        let place = |left: &LeftOut| {
            left.first.map_or_else(String::new, |first| format!(", first at {} {first}", self.place))
        };
        let Sieved { repeated, backward, not_finite, absurd } = &self.sieved;
        for (left, words) in [
            (repeated, "sample(s) with the stamp of the one before"),
            (backward, "sample(s) whose stamp goes back"),
            (not_finite, "sample(s) with NaN or infinite values"),
            (absurd, "sample(s) with values beyond 1e12 or below 1e-150, which no sensor measures"),
        ] {
            if left.count > 0 {
                all.push(format!("left out: {} {words}{}", left.count, place(left)));
            }
        }
        all.extend(self.remarks.iter().cloned());
        all
    }
}
