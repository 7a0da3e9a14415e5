//! What there is to work on, and what is missing.

use super::error::PaperError;
use super::published;
use crate::closed_loop::{ClosedLoopError, Source, Tracks};
use dpn_core::ImuRecording;
use dpn_train::corpus::{Corpus, Member};
use dpn_train::split::{Side, paper_side};
use serde::{Deserialize, Serialize};
use std::fmt;
use std::str::FromStr;

/// What the odometry sees.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum CameraChoice {
    /// Images where every sequence has them, else rendered ones, else tracks: the best that this program has for all of them.
    Auto,
    /// Camera tracks, given or made along the ground truth.
    Tracks,
}

impl CameraChoice {
    /// The camera that is used on `source`, and why.
    pub fn settle(self, source: &Source) -> (Self, &'static str) {
        match (self, source) {
            (Self::Tracks, _) => (Self::Tracks, "as asked for"),
            (Self::Auto, Source::Flights { .. }) => {
                (Self::Tracks, "simulated flights have no images; tracks are made along their true path")
            }
            (Self::Auto, Source::Recorded { .. }) => (
                Self::Tracks,
                "this program's odometry takes no images of these sequences; tracks are made along the ground truth",
            ),
        }
    }
}

impl fmt::Display for CameraChoice {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Auto => "auto",
            Self::Tracks => "tracks",
        })
    }
}

impl FromStr for CameraChoice {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        [Self::Auto, Self::Tracks]
            .into_iter()
            .find(|choice| choice.to_string() == text)
            .ok_or_else(|| format!("`{text}` is no camera; known are auto, tracks"))
    }
}

/// A sequence that has no rows.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Missing {
    /// Its name; of EuRoC's, the short one.
    pub name: String,
    /// Why.
    pub reason: String,
}

/// Recordings that can be used, and those that cannot.
#[derive(Debug)]
pub struct Input {
    /// Name of the collection, `euroc` or `simulated`.
    pub name: String,
    /// Sequences of the closed loop.
    pub source: Source,
    /// Places of those that are used.
    pub places: Vec<usize>,
    /// Those that are not.
    pub missing: Vec<Missing>,
    /// The recordings of those used: windows of the open loop come from them.
    pub corpus: Corpus,
    /// Minutes of the IMU of each sequence used, and its samples.
    pub lengths: Vec<(String, Side, usize, f64)>,
}

impl Input {
    /// Reads every sequence among `wanted` once; what does not read is missing, with its reason, as are sequences of the paper that are
    /// not there. `whole`: whether all sequences were wanted.
    ///
    /// # Errors
    /// No sequence that reads.
    pub fn check(source: Source, wanted: &[usize], whole: bool) -> Result<Self, PaperError> {
        let names = source.names();
        let (mut places, mut missing, mut lengths) = (Vec::new(), Vec::new(), Vec::new());
        let mut members = Vec::new();
        for &place in wanted {
            let (name, side) = &names[place];
            match usable(&source, place) {
                Ok(recording) => {
                    places.push(place);
                    lengths.push((name.clone(), *side, recording.len(), recording.duration() / 60.0));
                    members.push(Member { name: name.clone(), recording, side: *side });
                }
                Err(reason) => missing.push(Missing { name: name.clone(), reason }),
            }
        }
        if places.is_empty() {
            let reasons = missing.iter().map(|m| format!("{}: {}", m.name, m.reason)).collect();
            return Err(PaperError::Nothing { reasons });
        }
        let of_paper = names.iter().any(|(name, _)| paper_side(name).is_some());
        if of_paper {
            for sequence in published::sequences()? {
                let there = names.iter().position(|(name, _)| name.starts_with(&sequence.name));
                let reason = match there {
                    None => "there is no such folder in the data".to_owned(),
                    Some(place) if !wanted.contains(&place) && !whole => "not asked for".to_owned(),
                    _ => continue,
                };
                missing.push(Missing { name: sequence.name, reason });
            }
        }
        missing.sort_by(|a, b| a.name.cmp(&b.name));
        let name = match &source {
            Source::Flights { .. } => "simulated",
            Source::Recorded { .. } if of_paper => "euroc",
            Source::Recorded { .. } => "recorded",
        };
        let corpus = Corpus { name: name.into(), members };
        Ok(Self { name: name.into(), source, places, missing, corpus, lengths })
    }

    /// Whether the sequences are those of the paper.
    pub fn is_papers(&self) -> bool {
        self.name == "euroc"
    }

    /// Lines that say what is missing, for the foot of a table.
    pub(super) fn notes(&self) -> Vec<String> {
        self.missing.iter().map(|m| format!("No row for {}: {}.", m.name, m.reason)).collect()
    }
}

/// The samples of a sequence that a loop can be closed on and windows can be cut from.
fn usable(source: &Source, place: usize) -> Result<ImuRecording, String> {
    let recording = source.recording(place, 0).map_err(|error| words(&error))?;
    if recording.truth.is_none() {
        return Err("it has no ground truth, so that nothing can be judged".into());
    }
    if matches!(source, Source::Recorded { tracks: Tracks::Given(_), .. }) {
        source.frames(place, 0).map_err(|error| words(&error))?;
    }
    let member = Member { name: recording.name, recording: recording.imu, side: recording.side };
    let mut one = Corpus::new("one", vec![member]).map_err(|error| error.to_string())?;
    one.members.pop().map(|member| member.recording).ok_or_else(|| "it is empty".into())
}

/// An error and its causes on one line.
fn words(error: &ClosedLoopError) -> String {
    let mut text = error.to_string();
    let mut cause = std::error::Error::source(error);
    while let Some(inner) = cause {
        let more = inner.to_string();
        if !text.contains(&more) {
            text = format!("{text}: {more}");
        }
        cause = inner.source();
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;
    use dpn_sim::FlightConfig;
    use dpn_sim::tracks::TracksConfig;

    #[test]
    fn flights_miss_nothing_and_cameras_are_known_by_name() {
        let source = Source::Flights {
            config: FlightConfig::default(),
            tracks: crate::closed_loop::Tracks::Made(TracksConfig::default()),
        };
        let (camera, why) = CameraChoice::Auto.settle(&source);
        assert!(camera == CameraChoice::Tracks && why.contains("no images"));
        let input = Input::check(source, &[8], false).unwrap();
        assert_eq!((input.places.as_slice(), input.missing.len(), input.is_papers()), (&[8][..], 0, false));
        assert!(input.lengths[0].3 > 0.5);
        assert!("film".parse::<CameraChoice>().unwrap_err().contains("known are auto, tracks"));
    }
}
