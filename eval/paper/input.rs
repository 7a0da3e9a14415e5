//! What there is to work on, and what is missing.

use super::error::PaperError;
use super::published;
use crate::closed_loop::{ClosedLoopError, Images, Source, Tracks, Vision, has_images};
use dpn_core::ImuRecording;
use dpn_sim::FlightConfig;
use dpn_sim::tracks::TracksConfig;
use dpn_train::corpus::{Corpus, Member};
use dpn_train::split::{Side, paper_side};
use dpn_vio::frontend::FrontEndConfig;
use serde::{Deserialize, Serialize};
use std::fmt;
use std::path::{Path, PathBuf};
use std::str::FromStr;

/// What the odometry sees.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum CameraChoice {
    /// The best that every sequence has: its own images, else tracks.
    Auto,
    /// The sequences' own images; those without any are missing.
    Images,
    /// Camera tracks, given or made along the ground truth.
    Tracks,
}

/// What sequences and their tracks are made of, where they are not read.
#[derive(Debug, Clone)]
pub struct Cameras {
    /// Folder with camera tracks, where there is one.
    pub given: Option<PathBuf>,
    /// Tracks along a path.
    pub made: TracksConfig,
    /// Simulated flights.
    pub flights: FlightConfig,
    /// What follows points through images.
    pub front_end: FrontEndConfig,
}

impl CameraChoice {
    const ALL: [Self; 3] = [Self::Auto, Self::Images, Self::Tracks];

    /// The sequences of `dir` (the simulated flights without one) as this camera shows them, and why this one, in words. `wanted` are names
    /// as for [`Source::select`].
    ///
    /// # Errors
    /// A folder that cannot be listed, a sequence that is not there, images of flights.
    pub fn open(
        self,
        dir: Option<&Path>,
        wanted: &str,
        with: &Cameras,
    ) -> Result<(Source, String), PaperError> {
        let Some(dir) = dir else {
            if self == Self::Images {
                return Err(PaperError::NoCamera {
                    camera: self.to_string(),
                    reason: "simulated flights have no images".into(),
                });
            }
            let tracks = Tracks::Made(with.made.clone());
            let why = "simulated flights have no images; tracks are made along their true path";
            return Ok((Source::Flights { config: with.flights.clone(), tracks }, why.into()));
        };
        let seen = || {
            let images = Images::Folder { skip_missing: false };
            Tracks::Seen(Vision { images, front_end: with.front_end })
        };
        if self == Self::Images {
            return Ok((Source::recorded(dir, seen())?, "the sequences' own, as asked for".into()));
        }
        let (tracks, words) = match &with.given {
            Some(folder) => (Tracks::Given(folder.clone()), "the given ones"),
            None => (Tracks::Made(with.made.clone()), "made along the ground truth"),
        };
        let source = Source::recorded(dir, tracks)?;
        let (Self::Auto, None, Source::Recorded { sequences, .. }) = (self, &with.given, &source) else {
            return Ok((source, format!("{words}, as asked for")));
        };
        let places = source.select(wanted)?;
        let without = places.iter().filter(|place| !has_images(&sequences[**place].0)).count();
        if without == 0 {
            return Ok((Source::recorded(dir, seen())?, "every sequence has its own".into()));
        }
        let why = format!("{words}, for {without} of {} sequences have no images here", places.len());
        Ok((source, why))
    }
}

impl fmt::Display for CameraChoice {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Auto => "auto",
            Self::Images => "images",
            Self::Tracks => "tracks",
        })
    }
}

impl FromStr for CameraChoice {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let known = || Self::ALL.map(|choice| choice.to_string()).join(", ");
        let named = Self::ALL.into_iter().find(|choice| choice.to_string() == text);
        named.ok_or_else(|| format!("`{text}` is no camera; known are {}", known()))
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
    match source {
        Source::Recorded { tracks: Tracks::Given(_), .. } => {
            source.frames(place, 0).map_err(|error| words(&error))?;
        }
        Source::Recorded { sequences, tracks: Tracks::Seen(_) } if !has_images(&sequences[place].0) => {
            return Err("it has none of the images it lists".into());
        }
        _ => {}
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

    fn cameras() -> Cameras {
        Cameras {
            given: None,
            made: TracksConfig::default(),
            flights: FlightConfig::default(),
            front_end: FrontEndConfig::default(),
        }
    }

    #[test]
    fn flights_miss_nothing_and_have_no_images() {
        let (source, why) = CameraChoice::Auto.open(None, "all", &cameras()).unwrap();
        assert!(source.camera() == "tracks" && why.contains("no images"), "{why}");
        let input = Input::check(source, &[8], false).unwrap();
        assert_eq!((input.places.as_slice(), input.missing.len(), input.is_papers()), (&[8][..], 0, false));
        assert!(input.lengths[0].3 > 0.5);
        let error = CameraChoice::Images.open(None, "all", &cameras()).unwrap_err();
        assert!(error.to_string().contains("simulated flights have no images") && error.hint().is_some());
    }

    #[test]
    fn without_images_the_best_camera_is_tracks_and_images_asked_for_leave_nothing() {
        let dir = tempfile::tempdir().unwrap();
        let imu = dir.path().join("MH_01_easy/mav0/imu0");
        std::fs::create_dir_all(&imu).unwrap();
        std::fs::write(imu.join("data.csv"), "#timestamp [ns]\n").unwrap();
        let (source, why) = CameraChoice::Auto.open(Some(dir.path()), "all", &cameras()).unwrap();
        assert_eq!(source.camera(), "tracks");
        assert_eq!(why, "made along the ground truth, for 1 of 1 sequences have no images here");
        let (source, _) = CameraChoice::Images.open(Some(dir.path()), "all", &cameras()).unwrap();
        assert_eq!(source.camera(), "images");
        assert!(matches!(Input::check(source, &[0], true), Err(PaperError::Nothing { .. })));
        assert!("film".parse::<CameraChoice>().unwrap_err().contains("known are auto, images, tracks"));
    }
}
