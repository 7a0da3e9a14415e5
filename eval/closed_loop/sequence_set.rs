//! Where recordings and camera tracks come from: sequences on disk, or simulated flights.

use super::error::ClosedLoopError;
use super::logged::LoggedSequence;
use super::row::TruthKind;
use super::sequence_name::is_called;
use dpn_io::asl::{Sequence, discover};
use dpn_io::calibration::Calibration;
use dpn_logs::LogOptions;
use dpn_sim::tracks::{CameraSettings, TracksConfig};
use dpn_sim::{Flight, FlightConfig, RenderConfig};
use dpn_train::split::{Side, assign, paper_side};
use std::path::{Path, PathBuf};

/// Where the odometry's tracks come from.
#[derive(Debug, Clone, PartialEq)]
// A handful of these live at a time; their size is nobody's cost.
#[allow(clippy::large_enum_variant)]
pub enum TrackSource {
    /// Files `SEQUENCE.txt` in this folder; or one file, of the only sequence.
    File(PathBuf),
    /// Made along the ground truth, from the seed of the cell.
    Simulated(TracksConfig),
    /// Followed through the sequence's own images, of its folder or its log, by the estimator's front-end; the seed of the cell is its.
    Images {
        /// Whether images that are listed but not there are passed over; else they are an error before the run begins.
        skip_missing: bool,
    },
    /// Followed through images rendered along the ground truth, from the seed of the cell.
    Rendered(Box<RenderConfig>),
}

impl TrackSource {
    /// Whether the camera is simulated along the ground truth: errors are those of a camera that agrees with the truth.
    pub fn is_simulated(&self) -> bool {
        matches!(self, Self::Simulated(_) | Self::Rendered(_))
    }

    /// Whether there are images.
    pub fn has_images(&self) -> bool {
        matches!(self, Self::Images { .. } | Self::Rendered(_))
    }

    /// The settings given of a camera that is simulated.
    pub(super) fn camera_settings(&self) -> Option<CameraSettings> {
        match self {
            Self::Simulated(made) => made.camera,
            Self::Rendered(rendered) => rendered.camera,
            Self::File(_) | Self::Images { .. } => None,
        }
    }
}

/// Sequences that the loop can be closed on, and what is seen of them.
#[derive(Debug, Clone)]
pub struct SequenceSet {
    /// The sequences.
    pub of: Sequences,
    /// Their tracks.
    pub tracks: TrackSource,
    /// How the only sequence's samples are read.
    pub(super) imu: LogOptions,
    /// The calibration that was found beside the only sequence, and its file, where it has none of its own and nobody named one.
    pub(super) found: Option<(PathBuf, Calibration)>,
}

/// Sequences of one kind.
#[derive(Debug, Clone)]
#[allow(clippy::large_enum_variant)]
pub enum Sequences {
    /// Recordings on disk and their sides, sorted by name.
    Recorded(Vec<(Sequence, Side)>),
    /// A log with images; no truth is known of it but what somebody gives.
    Logged(LoggedSequence),
    /// Simulated flights made of this; flight and tracks are made from the seed of the cell.
    Flights(FlightConfig),
}

impl SequenceSet {
    pub(super) fn new(of: Sequences, tracks: TrackSource) -> Self {
        Self { of, tracks, imu: LogOptions::default(), found: None }
    }

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
        Ok(Self::new(Sequences::Recorded(sequences), tracks))
    }

    /// The one sequence in `dir`.
    ///
    /// # Errors
    /// A folder that holds no sequence.
    pub fn one(dir: &Path, tracks: TrackSource) -> Result<Self, ClosedLoopError> {
        let sequence = Sequence::open(dir)?;
        let side = paper_side(sequence.name()).unwrap_or(Side::Test);
        Ok(Self::new(Sequences::Recorded(vec![(sequence, side)]), tracks))
    }

    /// The simulated flights.
    pub fn flights(config: FlightConfig, tracks: TrackSource) -> Self {
        Self::new(Sequences::Flights(config), tracks)
    }

    /// The same with the reconciled ground truth of `dir`, `NAME.csv` a sequence, the published one without; flights have none but their own.
    #[must_use]
    pub fn with_reconciled_truth(self, dir: Option<&Path>) -> Self {
        match dir {
            Some(dir) => self.each(|sequence| sequence.with_reconciled_truth(dir)),
            None => self,
        }
    }

    /// A calibration that was found beside what is run, and where, when nobody named it and it lies at no usual place.
    pub fn found_calibration(&self) -> Option<(&Path, &Calibration)> {
        match &self.of {
            Sequences::Logged(log) => log.found(),
            Sequences::Recorded(_) | Sequences::Flights(_) => {
                self.found.as_ref().map(|(file, calibration)| (file.as_path(), calibration))
            }
        }
    }

    /// The same with a calibration in place of every sequence's own; flights have theirs in the settings of what is simulated.
    #[must_use]
    pub fn with_calibration(self, given: Option<Calibration>) -> Self {
        match given {
            Some(given) => self.each(|sequence| sequence.with_calibration(given.clone())),
            None => self,
        }
    }

    fn each(mut self, change: impl Fn(Sequence) -> Sequence) -> Self {
        if let Sequences::Recorded(sequences) = &mut self.of {
            sequences.iter_mut().for_each(|(sequence, _)| *sequence = change(sequence.clone()));
        }
        self
    }

    /// The sequences on disk and their sides; of logs and flights none.
    pub(super) fn on_disk(&self) -> &[(Sequence, Side)] {
        match &self.of {
            Sequences::Recorded(sequences) => sequences,
            Sequences::Logged(_) | Sequences::Flights(_) => &[],
        }
    }

    /// Folder of the reconciled ground truth.
    pub fn reconciled_truth(&self) -> Option<&Path> {
        self.on_disk().iter().find_map(|(sequence, _)| sequence.reconciled_truth())
    }

    /// The sequences on disk at `places`; of logs and flights none.
    pub fn recordings(&self, places: &[usize]) -> Vec<Sequence> {
        places.iter().filter_map(|place| Some(self.on_disk().get(*place)?.0.clone())).collect()
    }

    /// What the ground truth is.
    pub fn truth(&self) -> TruthKind {
        match &self.of {
            Sequences::Flights(_) => TruthKind::Exact,
            _ if self.reconciled_truth().is_some() => TruthKind::Reconciled,
            _ => TruthKind::Published,
        }
    }

    /// Names and sides of all sequences, in order.
    pub fn names(&self) -> Vec<(String, Side)> {
        match &self.of {
            Sequences::Recorded(all) => all.iter().map(|(s, side)| (s.name().to_owned(), *side)).collect(),
            Sequences::Logged(log) => vec![(log.name(), log.side())],
            Sequences::Flights(_) => Flight::ALL.map(|f| (f.name().to_owned(), f.split())).to_vec(),
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
        matches!(self.of, Sequences::Flights(_))
    }

    /// Whether a sequence's tracks depend on the seed.
    pub fn tracks_are_seeded(&self) -> bool {
        !matches!((&self.of, &self.tracks), (Sequences::Recorded(_), TrackSource::File(_)))
    }

    /// What the odometry sees, as rows call it.
    pub fn camera(&self) -> &'static str {
        match self.tracks {
            TrackSource::Images { .. } => "images",
            TrackSource::Rendered(_) => "rendered",
            TrackSource::File(_) | TrackSource::Simulated(_) => "tracks",
        }
    }

    /// What recordings and tracks are made of, where they are not read: all settings that a number depends on.
    pub fn description(&self) -> serde_json::Value {
        let tracks = match &self.tracks {
            TrackSource::File(_) => serde_json::json!("given"),
            TrackSource::Simulated(config) => serde_json::json!(config),
            // The front-end's settings are the estimator's.
            TrackSource::Images { .. } => serde_json::json!("images"),
            TrackSource::Rendered(config) => serde_json::json!({ "rendered": config }),
        };
        match (&self.of, self.truth()) {
            (Sequences::Flights(config), _) => serde_json::json!({ "flights": config, "tracks": tracks }),
            // The key is new: without it the cells of published truth keep their names.
            (_, truth @ TruthKind::Reconciled) => serde_json::json!({ "tracks": tracks, "truth": truth }),
            _ => serde_json::json!({ "tracks": tracks }),
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
        let tracks = TrackSource::Simulated(TracksConfig::default());
        let source = SequenceSet::flights(FlightConfig::default(), tracks);
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
