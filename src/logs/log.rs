//! A log that was read, and what is to be said of it.

use crate::Kind;
use dpn_core::{Recorded, Samples, Sensor, Stamp};
use dpn_io::{LeftOut, Part, SampleStore, Sieved, StoredRecording};
use std::io;

/// A recording and where it came from.
#[derive(Debug)]
pub struct Log {
    /// What kind of log it was.
    pub kind: Kind,
    /// The bag's topic.
    pub topic: Option<String>,
    /// The samples of use.
    pub recording: StoredRecording,
    /// Where in the log they stand: the first and the last one's places.
    pub places: [u64; 2],
    /// Where stamps begin anew or two write at once, what else there is; `recording` is the longest.
    pub others: Vec<OtherPart>,
    /// The sensor that the log has alone; the other's axes are zeros.
    pub alone: Option<Sensor>,
    /// That two sensors' stamps are of two clocks, and how these were brought together.
    pub clocks: Option<String>,
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
    /// Variances of a sample, gyroscope's and accelerometer's x, y, z, that all messages say alike \[(rad/s)^2, (m/s^2)^2\].
    pub variances: [Option<[f64; 3]>; 2],
    /// Means of the outputs of a vehicle's motors, in the log's numbers, in increasing time.
    pub motors: Vec<(Stamp, f64)>,
}

/// What a sensor is called.
pub(crate) fn instrument(sensor: Sensor) -> &'static str {
    match sensor {
        Sensor::Gyro => "gyroscope",
        Sensor::Accel => "accelerometer",
    }
}

/// A part of a log with stamps of its own.
#[derive(Debug)]
pub struct OtherPart {
    /// Its samples.
    pub recording: StoredRecording,
    /// Places of the first and the last.
    pub places: [u64; 2],
    /// Whether it was written together with the part that is used, and not before or after it.
    pub is_among: bool,
}

/// The other parts as recordings, made what `settle` makes of their samples.
///
/// # Errors
/// `settle`'s own; a temporary file that cannot be read.
pub(crate) fn other_parts(
    others: Vec<Part>,
    places: [u64; 2],
    settle: impl Fn(SampleStore) -> io::Result<SampleStore>,
) -> io::Result<Vec<OtherPart>> {
    let used = Part { places, ..Part::default() };
    let mut all = Vec::new();
    for part in others {
        let (is_among, places) = (part.is_among(&used), part.places);
        if let Ok(recording) = settle(part.samples)?.recording()? {
            all.push(OtherPart { recording, places, is_among });
        }
    }
    Ok(all)
}

impl Log {
    /// A recording that is as it should be.
    pub fn sound(kind: Kind, recording: impl Into<StoredRecording>) -> Self {
        Self {
            kind,
            topic: None,
            recording: recording.into(),
            places: [0; 2],
            others: Vec::new(),
            alone: None,
            clocks: None,
            sieved: Sieved::default(),
            place: "line",
            damage: None,
            guesses: Vec::new(),
            remarks: Vec::new(),
            said_hz: None,
            variances: [None; 2],
            motors: Vec::new(),
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
        for (left, words, then) in [
            (repeated, "sample(s) with the stamp of the one before", &self.coarse_words()[..]),
            (backward, "sample(s) whose stamp goes back", ""),
            (not_finite, "sample(s) with NaN or infinite values", ""),
            (absurd, "sample(s) with values beyond 1e12 or below 1e-150, which no sensor measures", ""),
        ] {
            if left.count > 0 {
                all.push(format!("left out: {} {words}{}{then}", left.count, place(left)));
            }
        }
        all.extend(self.alone.map(|sensor| {
            format!("the log has the {} alone: the other sensor's axes are zeros", instrument(sensor))
        }));
        all.extend(self.parts_words());
        all.extend(self.clocks.iter().cloned());
        all.extend(self.remarks.iter().cloned());
        all
    }

    /// What is to be said behind the number of samples with the stamp of the one before: where they are many, that stamps are coarser than the samples.
    pub fn coarse_words(&self) -> String {
        /// Share of the samples from which densities are off by a tenth.
        const MANY: f64 = 0.2;
        let (left, kept) = (self.sieved.repeated.count as f64, self.recording.len() as f64);
        let (hz, counted) = (self.recording.rate().hz(), (kept + left) / self.recording.length_s());
        if !self.others.is_empty() || left <= MANY * kept {
            return String::new();
        }
        format!(
            "; unless these are copies, samples come at {counted:.1} Hz, not {hz:.1}, and densities are {:.2} times too large: --rate {counted:.1} counts them",
            (counted / hz).sqrt()
        )
    }

    /// What the log is made of, where its stamps begin anew or two write at once.
    pub fn parts_words(&self) -> Option<String> {
        let first = self.others.first()?;
        let part = |len: usize, recording: &StoredRecording, [from, to]: [u64; 2]| {
            format!("{len} samples at {:.1} Hz ({}s {from} to {to})", recording.rate().hz(), self.place)
        };
        let others: Vec<String> =
            self.others.iter().map(|o| part(o.recording.len(), &o.recording, o.places)).collect();
        let used = part(self.recording.len(), &self.recording, self.places);
        Some(if first.is_among {
            format!(
                "{} publishers write at once: used are {used}, not {}",
                1 + others.len(),
                others.join(", ")
            )
        } else {
            format!(
                "the stamps begin anew: {} spans; used are {used}, not {}",
                1 + others.len(),
                others.join(", ")
            )
        })
    }
}
