//! Where recordings and camera tracks come from: sequences on disk, or simulated flights.

use super::error::ClosedLoopError;
use super::images::{ImageSource, ImageStream, of_folder};
use super::logged::LoggedSequence;
use super::recording::{Recording, Span};
use super::rendered::rendered;
use super::row::TruthKind;
use super::sequence_name::is_called;
use super::tracking::CameraInput;
use crate::metrics::poses_of;
use dpn_core::camera::CameraConfig;
use dpn_core::camera::CameraModel;
use dpn_core::checksum::{hex, of_parts, of_source};
use dpn_core::trajectory::StampedPose;
use dpn_core::{ImuRecording, SampleRate, Stamp, TrackFrame};
use dpn_io::asl::{Sequence, discover};
use dpn_io::calibration::Calibration;
use dpn_io::{ImageFolder, IoError, read_tracks};
use dpn_logs::{LogOptions, read_log};
use dpn_sim::tracks::{
    AnalyticPath, CameraSettings, PathConfig, RecordedPath, TracksConfig, camera_stamps, simulate_tracks,
};
use dpn_sim::{Flight, FlightConfig, RenderConfig, Split, simulate};
use dpn_train::split::{Side, assign, paper_side};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Rate of a camera that is not there: EuRoC's \[Hz\].
const CAMERA_HZ: f64 = 20.0;

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
            Self::Flights { .. } => Flight::ALL
                .into_iter()
                .map(|f| {
                    (f.name().to_owned(), if f.split() == Split::Train { Side::Train } else { Side::Test })
                })
                .collect(),
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

    /// The sequence at `place`, with all but its tracks.
    ///
    /// # Errors
    /// Files that cannot be read; no camera beside given tracks; no flight.
    pub fn recording(&self, place: usize, seed: u64) -> Result<Recording, ClosedLoopError> {
        match self {
            Self::Recorded { sequences, tracks } => {
                let (sequence, side) = &sequences[place];
                recorded(sequence, *side, tracks)
            }
            Self::Logged { log, .. } => log.recording(),
            Self::Flights { config, tracks } => flown(Flight::ALL[place], seed, config, tracks),
        }
    }

    /// What the odometry sees of the sequence at `place` within `span`: its images, or its tracks.
    ///
    /// # Errors
    /// A folder without images, or without all of them; nothing to render along; a file of tracks that cannot be read; no ground truth to make
    /// tracks along; a flight, which has neither a folder nor a file.
    pub fn camera_input(
        &self,
        place: usize,
        seed: u64,
        span: &Span,
    ) -> Result<CameraInput<'static>, ClosedLoopError> {
        match self.tracks() {
            TrackSource::Images(images) => Ok(CameraInput::Images(self.images(images, place, seed, span)?)),
            TrackSource::File(_) | TrackSource::Simulated(_) => {
                Ok(CameraInput::Tracks(self.frames(place, seed)?, *span))
            }
        }
    }

    fn images(
        &self,
        images: &ImageSource,
        place: usize,
        seed: u64,
        span: &Span,
    ) -> Result<ImageStream<'static>, ClosedLoopError> {
        match (images, self) {
            (_, Self::Logged { log, .. }) => log.images(span),
            (ImageSource::Folder { skip_missing }, Self::Recorded { sequences, .. }) => {
                of_folder(&sequences[place].0, span, *skip_missing)
            }
            (ImageSource::Folder { .. }, Self::Flights { .. }) => {
                let sequence = Flight::ALL[place].name().to_owned();
                Err(ClosedLoopError::NoImages { sequence, asked: false })
            }
            (ImageSource::Rendered(config), Self::Recorded { sequences, .. }) => {
                let sequence = &sequences[place].0;
                let camera = settled(sequence, config.camera)?;
                let config = RenderConfig { camera, ..RenderConfig::clone(config) };
                let (path, stamps) = path_of(sequence, &config.path)?;
                rendered(sequence.name(), &config, Arc::new(path), &stamps, seed, span)
            }
            (ImageSource::Rendered(config), Self::Flights { config: flight, .. }) => {
                let (path, stamps) = path_of_flight(Flight::ALL[place], flight, seed)?;
                rendered(Flight::ALL[place].name(), config, Arc::new(path), &stamps, seed, span)
            }
        }
    }

    /// The tracks of the sequence at `place`, given or made.
    ///
    /// # Errors
    /// A file that cannot be read; no ground truth to make tracks along; tracks that images are to be looked at for, or a flight's from a file.
    pub fn frames(&self, place: usize, seed: u64) -> Result<Vec<TrackFrame>, ClosedLoopError> {
        let no_tracks = |sequence: &str| ClosedLoopError::NoTracks { sequence: sequence.to_owned() };
        match (self, self.tracks()) {
            (Self::Recorded { sequences, .. }, TrackSource::File(dir)) => {
                let sequence = &sequences[place].0;
                let mut frames = read_tracks(&given(dir, sequence))?;
                if let Some(given) = sequence.calibration() {
                    frames.iter_mut().for_each(|frame| frame.t = given.on_imu_clock(frame.t));
                }
                Ok(frames)
            }
            (Self::Recorded { sequences, .. }, TrackSource::Simulated(config)) => {
                made(&sequences[place].0, config, seed)
            }
            (Self::Recorded { sequences, .. }, TrackSource::Images(_)) => {
                Err(no_tracks(sequences[place].0.name()))
            }
            (Self::Logged { log, .. }, _) => Err(no_tracks(&log.name())),
            (Self::Flights { config, .. }, TrackSource::Simulated(tracks)) => {
                let flight = Flight::ALL[place];
                let (path, stamps) = path_of_flight(flight, config, seed)?;
                simulate_tracks(tracks, &path, &stamps, seed)
                    .map_err(|source| ClosedLoopError::Tracks { sequence: flight.name().into(), source })
            }
            (Self::Flights { .. }, TrackSource::File(_) | TrackSource::Images(_)) => {
                Err(no_tracks(Flight::ALL[place].name()))
            }
        }
    }

    /// SHA-256 over the files that the sequence at `place` is read from, its images among them; of a flight, over nothing but its name.
    /// Images are read anew each time: a second for some gigabytes in the system's cache, and nothing remembered that may have changed.
    ///
    /// # Errors
    /// A file that cannot be read.
    pub fn checksum(&self, place: usize) -> Result<String, ClosedLoopError> {
        let mut hash = Sha256::new();
        match self {
            Self::Recorded { sequences, tracks } => {
                let (sequence, _) = &sequences[place];
                for sum in checksums(sequence, tracks) {
                    hash.update(sum?);
                }
                if let TrackSource::Images(ImageSource::Folder { .. }) = tracks {
                    let folder = ImageFolder::open(sequence)?;
                    let sums = folder.files().par_iter().map(|(t, path)| Ok((t, checksum_of_image(path)?)));
                    for (t, sum) in sums.collect::<Result<Vec<_>, IoError>>()? {
                        hash.update(t.ns().to_le_bytes());
                        hash.update(sum);
                    }
                }
            }
            Self::Logged { log, .. } => hash.update(log.checksum()?),
            Self::Flights { .. } => hash.update(Flight::ALL[place].name()),
        }
        Ok(hex(hash.finalize()))
    }

    /// The same of a sequence that need not be whole, without its images: what its samples are read from, as far as it is there.
    pub(super) fn checksum_of_samples(&self, place: usize) -> String {
        match self {
            Self::Recorded { sequences, tracks } => {
                // A file that cannot be read has no checksum, and one that is empty has.
                of_parts(checksums(&sequences[place].0, tracks).into_iter().map(Result::unwrap_or_default))
            }
            Self::Logged { log, .. } => log.checksum().unwrap_or_default(),
            Self::Flights { .. } => Flight::ALL[place].name().to_owned(),
        }
    }
}

/// SHA-256 of an image's file; zeros of one that is not there.
fn checksum_of_image(path: &Path) -> Result<[u8; 32], IoError> {
    // Opening a pipe of that name would wait for a writer.
    if !path.is_file() {
        return Ok([0; 32]);
    }
    let mut hash = Sha256::new();
    std::fs::File::open(path)
        .and_then(|mut file| std::io::copy(&mut file, &mut hash))
        .map_err(|source| IoError::Read { path: path.to_path_buf(), source })?;
    Ok(hash.finalize().into())
}

/// SHA-256 of the files that a sequence is read from, but for its images.
fn checksums(sequence: &Sequence, tracks: &TrackSource) -> Vec<Result<String, IoError>> {
    let mut sums = sequence.checksums();
    if let TrackSource::File(dir) = tracks {
        let file = given(dir, sequence);
        let read = std::fs::File::open(&file).and_then(of_source);
        sums.push(read.map_err(|e| IoError::reading(&file, e)));
    }
    sums
}

fn given(dir: &Path, sequence: &Sequence) -> PathBuf {
    if dir.is_file() {
        return dir.to_path_buf();
    }
    dir.join(format!("{}.txt", sequence.name()))
}

fn camera_rate(camera: Option<&CameraConfig>) -> SampleRate {
    let usual = || SampleRate::from_hz(CAMERA_HZ).expect("20 Hz is a rate");
    camera.map_or_else(usual, |camera| camera.rate)
}

fn recorded(sequence: &Sequence, side: Side, tracks: &TrackSource) -> Result<Recording, ClosedLoopError> {
    let name = sequence.name().to_owned();
    let (camera, body_from_cam) = match tracks {
        TrackSource::File(_) | TrackSource::Images(ImageSource::Folder { .. }) => {
            let no_camera = || ClosedLoopError::NoCamera { dir: sequence.dir().to_path_buf() };
            let config = sequence.camera_config()?.ok_or_else(no_camera)?;
            let camera = CameraModel::try_from(&config)
                .map_err(|source| ClosedLoopError::Camera { sequence: name.clone(), source })?;
            (camera, config.body_from_cam)
        }
        TrackSource::Simulated(config) => camera_of(&name, settled(sequence, config.camera)?)?,
        TrackSource::Images(ImageSource::Rendered(config)) => {
            camera_of(&name, settled(sequence, config.camera)?)?
        }
    };
    let truth = match sequence.ground_truth_path() {
        Some(_) => Some(poses_of(&sequence.ground_truth()?)),
        None => None,
    };
    let (imu, remarks) = match tracks {
        TrackSource::File(_) | TrackSource::Images(ImageSource::Folder { .. }) => own_samples(sequence)?,
        TrackSource::Simulated(_) | TrackSource::Images(ImageSource::Rendered(_)) => {
            (sequence.imu()?, Vec::new())
        }
    };
    Ok(Recording { name, side, imu, camera, body_from_cam, truth, oracle: None, remarks })
}

/// The samples of somebody's own recording: rows that no recording may hold, such as a stamp twice, are left out as everywhere else in logs, and said.
fn own_samples(sequence: &Sequence) -> Result<(ImuRecording, Vec<String>), ClosedLoopError> {
    let strict = match sequence.imu() {
        Ok(imu) => return Ok((imu, Vec::new())),
        Err(error) => error,
    };
    let Ok(log) = read_log(sequence.dir(), &LogOptions::default()) else { return Err(strict.into()) };
    let remarks = log.warnings();
    let imu = log.recording.held().map_err(|e| IoError::reading(&sequence.imu_path(), e))?;
    Ok((imu, remarks))
}

/// The camera that was given, else the sequence's own where it has one.
fn settled(
    sequence: &Sequence,
    given: Option<CameraSettings>,
) -> Result<Option<CameraSettings>, ClosedLoopError> {
    let (None, Some(own)) = (given, sequence.camera_config()?) else { return Ok(given) };
    let settings = CameraSettings::try_from(&own)
        .map_err(|source| ClosedLoopError::Camera { sequence: sequence.name().to_owned(), source })?;
    Ok(Some(settings))
}

fn camera_of(
    sequence: &str,
    settings: Option<CameraSettings>,
) -> Result<(CameraModel, nalgebra::Isometry3<f64>), ClosedLoopError> {
    let wrong = |source| ClosedLoopError::CameraSettings { sequence: sequence.to_owned(), source };
    let settings = settings.unwrap_or_default();
    Ok((settings.model().map_err(wrong)?, settings.body_from_cam().map_err(wrong)?))
}

/// The path along a sequence's ground truth, and its camera's stamps where it left any.
fn path_of(sequence: &Sequence, config: &PathConfig) -> Result<(RecordedPath, Vec<Stamp>), ClosedLoopError> {
    if sequence.ground_truth_path().is_none() {
        return Err(ClosedLoopError::NoGroundTruth { dir: sequence.dir().to_path_buf() });
    }
    let path = RecordedPath::new(&sequence.ground_truth()?, &path_config(sequence, config))
        .map_err(|source| ClosedLoopError::Path { sequence: sequence.name().to_owned(), source })?;
    let stamps = if sequence.has_camera_frames() {
        sequence.camera_frames()?.iter().map(|frame| frame.t).collect()
    } else {
        camera_stamps(&path, camera_rate(sequence.camera_config()?.as_ref()))
    };
    Ok((path, stamps))
}

/// How a sequence's ground truth becomes a path: a reconciled one is smooth, and smoothing would take it away from the samples.
pub fn path_config(sequence: &Sequence, config: &PathConfig) -> PathConfig {
    if sequence.truth_is_reconciled() { PathConfig { smoothing_s: 0.0, ..*config } } else { *config }
}

/// A flight's exact path, and stamps of a camera on it. The frame's shaking is in it: camera and IMU ride on one body.
fn path_of_flight(
    flight: Flight,
    config: &FlightConfig,
    seed: u64,
) -> Result<(AnalyticPath, Vec<Stamp>), ClosedLoopError> {
    let path = AnalyticPath::new(dpn_sim::path(flight, seed, config)?, Stamp::from_ns(config.epoch_ns));
    let stamps = camera_stamps(&path, camera_rate(None));
    Ok((path, stamps))
}

/// Tracks along the ground truth.
fn made(sequence: &Sequence, config: &TracksConfig, seed: u64) -> Result<Vec<TrackFrame>, ClosedLoopError> {
    let (path, stamps) = path_of(sequence, &config.path)?;
    let config = TracksConfig { camera: settled(sequence, config.camera)?, ..config.clone() };
    simulate_tracks(&config, &path, &stamps, seed)
        .map_err(|source| ClosedLoopError::Tracks { sequence: sequence.name().to_owned(), source })
}

fn flown(
    flight: Flight,
    seed: u64,
    config: &FlightConfig,
    tracks: &TrackSource,
) -> Result<Recording, ClosedLoopError> {
    let flown = simulate(flight, seed, config)?;
    let settings = match tracks {
        TrackSource::Simulated(made) => made.camera,
        TrackSource::Images(ImageSource::Rendered(rendered)) => rendered.camera,
        TrackSource::File(_) | TrackSource::Images(_) => None,
    };
    let (camera, body_from_cam) = camera_of(flight.name(), settings)?;
    let truth = flown.ground_truth.iter();
    let truth = truth.map(|s| StampedPose { t: s.t, world_from_body: s.world_from_body }).collect();
    Ok(Recording {
        name: flight.name().to_owned(),
        side: if flight.split() == Split::Train { Side::Train } else { Side::Test },
        camera,
        body_from_cam,
        truth: Some(truth),
        // A flight without white noise has none: who asks for the oracle is told so.
        oracle: flown.truth.oracle(&flown.recording).ok(),
        imu: flown.recording,
        remarks: Vec::new(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use dpn_sim::imu::VibrationConfig;
    use dpn_sim::tracks::CameraPath;

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

    #[test]
    fn tracks_that_are_not_there_are_an_error_and_never_none() {
        let config = FlightConfig::default();
        for tracks in [
            TrackSource::File(PathBuf::from("tracks")),
            TrackSource::Images(ImageSource::Rendered(Box::default())),
            TrackSource::Images(ImageSource::Folder { skip_missing: false }),
        ] {
            let source = SequenceSet::Flights { config: config.clone(), tracks };
            let error = source.frames(0, 1).unwrap_err().to_string();
            assert!(error.starts_with("f01-hall-slow: it has no file of tracks"), "{error}");
        }
        let folder = TrackSource::Images(ImageSource::Folder { skip_missing: false });
        let source = SequenceSet::Flights { config, tracks: folder };
        let error = source.camera_input(0, 1, &Span::from(0.0)).err().unwrap();
        assert!(matches!(error, ClosedLoopError::NoImages { asked: false, .. }), "{error}");
    }

    #[test]
    fn a_flight_has_truth_oracle_and_tracks_on_its_samples_clock() {
        let source = SequenceSet::Flights {
            config: FlightConfig::default(),
            tracks: TrackSource::Simulated(TracksConfig::default()),
        };
        let place = source.select("hover").unwrap()[0];
        let recording = source.recording(place, 3).unwrap();
        let frames = source.frames(place, 3).unwrap();
        let samples = recording.imu.samples();
        assert_eq!(recording.oracle.unwrap().noises().len(), samples.len());
        assert!(frames[0].t >= samples[0].t && frames.len() > 100);
        assert_ne!(frames, source.frames(place, 4).unwrap());
        assert_ne!(source.checksum(place).unwrap(), source.checksum(0).unwrap());
    }

    #[test]
    fn a_flights_camera_rides_on_the_body_that_shakes() {
        let config = FlightConfig::default();
        let tracks = TrackSource::Simulated(TracksConfig::default());
        let place = Flight::ALL.iter().position(|flight| *flight == Flight::Hover).unwrap();
        let truth = SequenceSet::Flights { config: config.clone(), tracks }
            .recording(place, 3)
            .unwrap()
            .truth
            .unwrap();
        let turned = |config: &FlightConfig| {
            let (path, _) = path_of_flight(Flight::Hover, config, 3).unwrap();
            let angle = |pose: &StampedPose| {
                Some(pose.world_from_body.rotation.angle_to(&path.world_from_body(pose.t)?.rotation))
            };
            truth.iter().filter_map(angle).fold(0.0, f64::max)
        };
        assert!(turned(&config) < 1e-9, "{:.1e} rad", turned(&config));
        // Half a pixel and more, where the path leaves the shaking out: the test above can fail.
        let still = VibrationConfig { scale: 0.0, ..config.vibration.clone() };
        assert!(turned(&FlightConfig { vibration: still, ..config }) > 1e-3);
    }
}
