//! Where recordings and camera tracks come from: sequences on disk, or simulated flights.

use super::error::ClosedLoopError;
use super::images::ImageSource;
use super::logged::LoggedSequence;
use super::row::TruthKind;
use super::sequence_name::is_called;
use dpn_io::asl::{Sequence, discover};
use dpn_io::calibration::Calibration;
use dpn_sim::tracks::TracksConfig;
use dpn_sim::{Flight, FlightConfig};
use dpn_train::split::{Side, assign, paper_side};
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};

/// Where the tracks of recorded sequences come from.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
// A handful of these live at a time; their size is nobody's cost.
#[allow(clippy::large_enum_variant)]
pub enum TrackSource {
    /// Files `SEQUENCE.txt` in this folder; or one file, of the only sequence.
    File(PathBuf),
    /// Made along the ground truth, from the seed of the cell.
    Simulated(TracksConfig),
    /// Followed through images by the estimator's front-end; the seed of the cell is its, and that of images that are rendered.
    Images(ImageSource),
}

/// Sequences that the loop can be closed on.
#[derive(Debug, Clone)]
#[allow(clippy::large_enum_variant)]
pub enum SequenceSet {
    /// Recordings on disk.
    Recorded {
        /// The sequences and their sides, sorted by name.
        sequences: Vec<(Sequence, Side)>,
        /// Their tracks.
        tracks: TrackSource,
    },
    /// A log with images; no truth is known of it but what somebody gives.
    Logged {
        /// The log.
        log: LoggedSequence,
        /// Its own images.
        tracks: TrackSource,
    },
    /// Simulated flights; flight and tracks are made from the seed of the cell.
    Flights {
        /// What every flight is made of.
        config: FlightConfig,
        /// Their tracks.
        tracks: TrackSource,
    },
}

impl SequenceSet {
    /// The sequences under `dir`: the paper's where there are any, else all.
    ///
    /// # Errors
    /// A folder that cannot be listed or holds no sequence, or two of one name.
    pub fn recorded(dir: &Path, tracks: TrackSource) -> Result<Self, ClosedLoopError> {
        let all = discover(dir)?;
        let of_paper: Vec<_> = all.iter().filter_map(|s| Some((s.clone(), paper_side(s.name())?))).collect();
        let sequences: Vec<(Sequence, Side)> = if of_paper.is_empty() {
            let sides = assign(all.iter().map(Sequence::name));
            let side = |s: &Sequence| {
                let found = sides.iter().find(|(name, _)| name == s.name());
                found.expect("`assign` gives every name a side").1
            };
            all.iter().map(|s| (s.clone(), side(s))).collect()
        } else {
            of_paper
        };
        // Sorted by name.
        if let Some(twice) = sequences.windows(2).find(|w| w[0].0.name() == w[1].0.name()) {
            return Err(ClosedLoopError::SameName {
                name: twice[0].0.name().to_owned(),
                first: twice[0].0.dir().to_path_buf(),
                second: twice[1].0.dir().to_path_buf(),
            });
        }
        Ok(Self::Recorded { sequences, tracks })
    }

    /// The one sequence in `dir`.
    ///
    /// # Errors
    /// A folder that holds no sequence.
    pub fn one(dir: &Path, tracks: TrackSource) -> Result<Self, ClosedLoopError> {
        let sequence = Sequence::open(dir)?;
        let side = paper_side(sequence.name()).unwrap_or(Side::Test);
        Ok(Self::Recorded { sequences: vec![(sequence, side)], tracks })
    }

    /// A log with images, seen by its own camera.
    pub fn logged(log: LoggedSequence, skip_missing: bool) -> Self {
        Self::Logged { log, tracks: TrackSource::Images(ImageSource::Folder { skip_missing }) }
    }

    /// The same with other tracks.
    #[must_use]
    pub fn with_tracks(mut self, other: TrackSource) -> Self {
        match &mut self {
            Self::Recorded { tracks, .. } | Self::Logged { tracks, .. } | Self::Flights { tracks, .. } => {
                *tracks = other;
            }
        }
        self
    }

    /// The same with the reconciled ground truth of `dir`, `NAME.csv` a sequence, the published one without; flights have none but their own.
    #[must_use]
    pub fn with_reconciled_truth(mut self, dir: Option<&Path>) -> Self {
        if let (Self::Recorded { sequences, .. }, Some(dir)) = (&mut self, dir) {
            for (sequence, _) in sequences {
                *sequence = sequence.clone().with_reconciled_truth(dir);
            }
        }
        self
    }

    /// The same with a calibration in place of every sequence's own; flights have theirs in the settings of what is simulated.
    #[must_use]
    pub fn with_calibration(mut self, given: Option<Calibration>) -> Self {
        if let (Self::Recorded { sequences, .. }, Some(given)) = (&mut self, given) {
            for (sequence, _) in sequences {
                *sequence = sequence.clone().with_calibration(given.clone());
            }
        }
        self
    }

    /// Folder of the reconciled ground truth.
    pub fn reconciled_truth(&self) -> Option<&Path> {
        match self {
            Self::Recorded { sequences, .. } => sequences.iter().find_map(|(s, _)| s.reconciled_truth()),
            Self::Logged { .. } | Self::Flights { .. } => None,
        }
    }

    /// The sequences on disk at `places`; of logs and flights none.
    pub fn recordings(&self, places: &[usize]) -> Vec<Sequence> {
        match self {
            Self::Recorded { sequences, .. } => {
                places.iter().map(|place| sequences[*place].0.clone()).collect()
            }
            Self::Logged { .. } | Self::Flights { .. } => Vec::new(),
        }
    }

    /// What the ground truth is.
    pub fn truth(&self) -> TruthKind {
        match self {
            Self::Recorded { sequences, .. } if sequences.iter().any(|(s, _)| s.truth_is_reconciled()) => {
                TruthKind::Reconciled
            }
            Self::Recorded { .. } | Self::Logged { .. } => TruthKind::Published,
            Self::Flights { .. } => TruthKind::Exact,
        }
    }

    /// Names and sides of all sequences, in order.
    pub fn names(&self) -> Vec<(String, Side)> {
        match self {
            Self::Recorded { sequences, .. } => {
                sequences.iter().map(|(s, side)| (s.name().to_owned(), *side)).collect()
            }
            Self::Logged { log, .. } => vec![(log.name(), log.side())],
            Self::Flights { .. } => {
                Flight::ALL.into_iter().map(|f| (f.name().to_owned(), f.split())).collect()
            }
        }
    }

    /// Places of the sequences named: `all`, or names and beginnings of names, which must be of one sequence each.
    ///
    /// # Errors
    /// A name that no sequence has, or several begin with.
    pub fn select(&self, wanted: &str) -> Result<Vec<usize>, ClosedLoopError> {
        let names: Vec<String> = self.names().into_iter().map(|(name, _)| name).collect();
        if wanted == "all" {
            return Ok((0..names.len()).collect());
        }
        let mut found = Vec::new();
        for name in wanted.split([',', ';', ' ']).filter(|name| !name.is_empty()) {
            let exact: Vec<usize> = (0..names.len()).filter(|i| is_called(&names[*i], name)).collect();
            let begins = (0..names.len()).filter(|i| names[*i].starts_with(name)).collect();
            match if exact.is_empty() { begins } else { exact }.as_slice() {
                [one] => found.push(*one),
                [] => {
                    return Err(ClosedLoopError::UnknownSequence { name: name.to_owned(), known: names });
                }
                several => {
                    let found = several.iter().map(|i| names[*i].clone()).collect();
                    return Err(ClosedLoopError::AmbiguousSequence { name: name.to_owned(), found });
                }
            }
        }
        found.sort_unstable();
        found.dedup();
        if found.is_empty() {
            return Err(ClosedLoopError::UnknownSequence { name: wanted.to_owned(), known: names });
        }
        Ok(found)
    }

    /// Whether a sequence's samples depend on the seed.
    pub fn recordings_are_seeded(&self) -> bool {
        matches!(self, Self::Flights { .. })
    }

    /// Whether a sequence's tracks depend on the seed.
    pub fn tracks_are_seeded(&self) -> bool {
        !matches!(self, Self::Recorded { tracks: TrackSource::File(_), .. })
    }

    /// Where tracks come from.
    pub fn tracks(&self) -> &TrackSource {
        match self {
            Self::Recorded { tracks, .. } | Self::Logged { tracks, .. } | Self::Flights { tracks, .. } => {
                tracks
            }
        }
    }

    /// Whether the camera is simulated along the ground truth: errors are those of a camera that agrees with the truth.
    pub fn camera_is_simulated(&self) -> bool {
        match self.tracks() {
            TrackSource::Simulated(_) | TrackSource::Images(ImageSource::Rendered(_)) => true,
            TrackSource::File(_) | TrackSource::Images(ImageSource::Folder { .. }) => false,
        }
    }

    /// What the odometry sees, as rows call it.
    pub fn camera(&self) -> &'static str {
        match self.tracks() {
            TrackSource::Images(images) => images.name(),
            TrackSource::File(_) | TrackSource::Simulated(_) => "tracks",
        }
    }

    /// What recordings and tracks are made of, where they are not read: all settings that a number depends on.
    pub fn description(&self) -> serde_json::Value {
        let tracks = match self.tracks() {
            TrackSource::File(_) => serde_json::json!("given"),
            TrackSource::Simulated(config) => serde_json::json!(config),
            // The front-end's settings are the estimator's.
            TrackSource::Images(images @ ImageSource::Folder { .. }) => serde_json::json!(images.name()),
            TrackSource::Images(ImageSource::Rendered(config)) => serde_json::json!({ "rendered": config }),
        };
        match self {
            // The key is new: without it the cells of published truth keep their names.
            Self::Recorded { .. } if self.truth() == TruthKind::Reconciled => {
                serde_json::json!({ "tracks": tracks, "truth": self.truth() })
            }
            Self::Recorded { .. } | Self::Logged { .. } => serde_json::json!({ "tracks": tracks }),
            Self::Flights { config, .. } => serde_json::json!({ "flights": config, "tracks": tracks }),
        }
    }
}

/// The file of a sequence's tracks in `dir`, or `dir` itself where that is one file.
pub(super) fn tracks_file(dir: &Path, sequence: &Sequence) -> PathBuf {
    if dir.is_file() {
        return dir.to_path_buf();
    }
    dir.join(format!("{}.txt", sequence.name()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sequences_are_selected_by_name_short_name_or_beginning() {
        let source = SequenceSet::Flights {
            config: FlightConfig::default(),
            tracks: TrackSource::Simulated(TracksConfig::default()),
        };
        assert_eq!(source.select("all").unwrap().len(), 11);
        assert_eq!(source.select("hover, f02-hall-calm;f03").unwrap(), [1, 2, 8]);
        let error = |text: &str| source.select(text).unwrap_err().to_string();
        assert!(error("f0").contains("may be any of f01-hall-slow"));
        assert!(error("cave").contains("no sequence is called `cave`"));
        assert!(error("f07-rom-medium").ends_with("(did you mean `f07-room-medium`?)"));
        assert!(error("hovr").ends_with("(did you mean `f09-hover`?)"));
        assert!(error("the-cellar-below").ends_with("f11-room-wild"));
        assert!(error(" ").contains("no sequence"));
        assert!(is_called("MH_01_easy", "MH_01") && is_called("dataset-room1_512_16", "room1"));
    }
}
