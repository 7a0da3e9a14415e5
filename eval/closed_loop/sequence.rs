//! A sequence of a set as an estimator wants it: its recording, and what the odometry sees of it.

use super::error::{ClosedLoopError, OfSequence};
use super::images::of_folder;
use super::recording::{Recording, Span};
use super::rendered::rendered;
use super::sequence_fault::SequenceFault;
use super::sequence_set::{SequenceSet, Sequences, TrackSource, tracks_file};
use super::tracking::CameraInput;
use crate::metrics::poses_of;
use dpn_core::camera::{CameraConfig, CameraModel};
use dpn_core::trajectory::StampedPose;
use dpn_core::{ImuRecording, SampleRate, Stamp, TrackFrame};
use dpn_io::asl::Sequence;
use dpn_io::{IoError, read_tracks};
use dpn_logs::{LogOptions, read_log};
use dpn_sim::render::SharedPath;
use dpn_sim::tracks::{
    AnalyticPath, CameraSettings, PathConfig, RecordedPath, TracksConfig, camera_stamps, simulate_tracks,
};
use dpn_sim::{Flight, FlightConfig, RenderConfig, simulate};
use dpn_train::split::Side;
use dpn_vio::frontend::{camera_at_working_size, image_at_working_size};
use std::sync::Arc;

/// Rate of a camera that is not there: EuRoC's \[Hz\].
const CAMERA_HZ: f64 = 20.0;

impl SequenceSet {
    /// The sequence at `place`, with all but its tracks.
    ///
    /// # Errors
    /// Files that cannot be read; no camera beside given tracks; no flight.
    pub fn recording(&self, place: usize, seed: u64) -> Result<Recording, ClosedLoopError> {
        let mut recording = match &self.of {
            Sequences::Recorded(sequences) => {
                let (sequence, side) = &sequences[place];
                recorded(sequence, *side, &self.tracks, &self.imu)
            }
            Sequences::Logged(log) => log.recording(),
            Sequences::Flights(config) => flown(Flight::ALL[place], seed, config, &self.tracks),
        }?;
        if self.tracks.has_images() {
            recording.camera = camera_at_working_size(&recording.camera);
        }
        Ok(recording)
    }

    /// What the odometry sees of the sequence at `place` within `span`: its images, [reduced](image_at_working_size) where they are large, or its tracks.
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
        let images = match (&self.tracks, &self.of) {
            (TrackSource::File(_) | TrackSource::Simulated(_), _) => {
                return Ok(CameraInput::Tracks(self.frames(place, seed)?, *span));
            }
            (_, Sequences::Logged(log)) => log.images(span)?,
            (TrackSource::Images { skip_missing }, Sequences::Recorded(sequences)) => {
                of_folder(&sequences[place].0, span, *skip_missing)?
            }
            (TrackSource::Images { .. }, Sequences::Flights(_)) => {
                return Err(SequenceFault::NoImages { asked: false }.of(self.name(place)));
            }
            (TrackSource::Rendered(config), _) => {
                let camera = self.settled(place, config.camera)?;
                let config = RenderConfig { camera, ..RenderConfig::clone(config) };
                let (path, stamps) = self.path(place, seed, &config.path)?;
                rendered(&self.name(place), &config, path, &stamps, seed, span)?
            }
        };
        let images = images.map(|(t, image)| (t, image.map(image_at_working_size)));
        Ok(CameraInput::Images(Box::new(images)))
    }

    /// The tracks of the sequence at `place`, given or made.
    ///
    /// # Errors
    /// A file that cannot be read; no ground truth to make tracks along; tracks that images are to be looked at for, or a flight's from a file.
    pub fn frames(&self, place: usize, seed: u64) -> Result<Vec<TrackFrame>, ClosedLoopError> {
        match (&self.tracks, &self.of) {
            (TrackSource::File(dir), Sequences::Recorded(sequences)) => {
                let sequence = &sequences[place].0;
                let mut frames = read_tracks(&tracks_file(dir, sequence))?;
                if let Some(given) = sequence.calibration() {
                    frames.iter_mut().for_each(|frame| frame.t = given.on_imu_clock(frame.t));
                }
                Ok(frames)
            }
            (TrackSource::Simulated(config), _) => {
                let (path, stamps) = self.path(place, seed, &config.path)?;
                let camera = self.settled(place, config.camera)?;
                simulate_tracks(&TracksConfig { camera, ..config.clone() }, &*path, &stamps, seed)
                    .of_sequence(&self.name(place))
            }
            _ => Err(SequenceFault::NoTracks.of(self.name(place))),
        }
    }

    fn name(&self, place: usize) -> String {
        self.names().swap_remove(place).0
    }

    /// The camera that was given, else the sequence's own where it has one.
    fn settled(
        &self,
        place: usize,
        given: Option<CameraSettings>,
    ) -> Result<Option<CameraSettings>, ClosedLoopError> {
        self.on_disk().get(place).map_or(Ok(given), |(sequence, _)| settled(sequence, given))
    }

    /// The path along the truth of the sequence at `place`, and its camera's stamps.
    fn path(
        &self,
        place: usize,
        seed: u64,
        config: &PathConfig,
    ) -> Result<(SharedPath, Vec<Stamp>), ClosedLoopError> {
        match &self.of {
            Sequences::Recorded(sequences) => path_of(&sequences[place].0, config),
            Sequences::Logged(log) => Err(SequenceFault::NoTracks.of(log.name())),
            Sequences::Flights(config) => {
                let (path, stamps) = path_of_flight(Flight::ALL[place], config, seed)?;
                Ok((Arc::new(path), stamps))
            }
        }
    }
}

fn camera_rate(camera: Option<&CameraConfig>) -> SampleRate {
    let usual = || SampleRate::from_hz(CAMERA_HZ).expect("20 Hz is a rate");
    camera.map_or_else(usual, |camera| camera.rate)
}

fn recorded(
    sequence: &Sequence,
    side: Side,
    tracks: &TrackSource,
    options: &LogOptions,
) -> Result<Recording, ClosedLoopError> {
    let name = sequence.name().to_owned();
    let (camera, body_from_cam) = if tracks.is_simulated() {
        camera_of(&name, settled(sequence, tracks.camera_settings())?)?
    } else {
        let no_camera = || ClosedLoopError::NoCamera { dir: sequence.dir().to_path_buf() };
        let config = sequence.camera_config()?.ok_or_else(no_camera)?;
        let camera = CameraModel::try_from(&config).of_sequence(&name)?;
        (camera, config.body_from_cam)
    };
    let truth = match sequence.ground_truth_path() {
        Some(_) => Some(poses_of(&sequence.ground_truth()?)),
        None => None,
    };
    let is_plain = tracks.is_simulated() && *options == LogOptions::default();
    let (imu, remarks) =
        if is_plain { (sequence.imu()?, Vec::new()) } else { own_samples(sequence, options)? };
    Ok(Recording { name, side, imu, camera, body_from_cam, truth, oracle: None, remarks })
}

/// The samples of somebody's own recording: rows that no recording may hold, such as a stamp twice, are left out as everywhere else in logs, and said.
fn own_samples(
    sequence: &Sequence,
    options: &LogOptions,
) -> Result<(ImuRecording, Vec<String>), ClosedLoopError> {
    let log = if *options == LogOptions::default() {
        let strict = match sequence.imu() {
            Ok(imu) => return Ok((imu, Vec::new())),
            Err(error) => error,
        };
        read_log(sequence.dir(), options).map_err(|_| ClosedLoopError::from(strict))?
    } else {
        read_log(sequence.dir(), options)?
    };
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
    CameraSettings::try_from(&own).of_sequence(sequence.name()).map(Some)
}

fn camera_of(
    sequence: &str,
    settings: Option<CameraSettings>,
) -> Result<(CameraModel, nalgebra::Isometry3<f64>), ClosedLoopError> {
    let settings = settings.unwrap_or_default();
    Ok((settings.model().of_sequence(sequence)?, settings.body_from_cam().of_sequence(sequence)?))
}

/// The path along a sequence's ground truth, and its camera's stamps where it left any.
fn path_of(sequence: &Sequence, config: &PathConfig) -> Result<(SharedPath, Vec<Stamp>), ClosedLoopError> {
    if sequence.ground_truth_path().is_none() {
        return Err(ClosedLoopError::NoGroundTruth { dir: sequence.dir().to_path_buf() });
    }
    let path = RecordedPath::new(&sequence.ground_truth()?, &path_config(sequence, config))
        .of_sequence(sequence.name())?;
    let stamps = if sequence.has_camera_frames() {
        sequence.camera_frames()?.iter().map(|frame| frame.t).collect()
    } else {
        camera_stamps(&path, camera_rate(sequence.camera_config()?.as_ref()))
    };
    Ok((Arc::new(path), stamps))
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

fn flown(
    flight: Flight,
    seed: u64,
    config: &FlightConfig,
    tracks: &TrackSource,
) -> Result<Recording, ClosedLoopError> {
    let flown = simulate(flight, seed, config)?;
    let (camera, body_from_cam) = camera_of(flight.name(), tracks.camera_settings())?;
    let truth = flown.ground_truth.iter();
    let truth = truth.map(|s| StampedPose { t: s.t, world_from_body: s.world_from_body }).collect();
    Ok(Recording {
        name: flight.name().to_owned(),
        side: flight.split(),
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
    use std::path::PathBuf;

    #[test]
    fn tracks_that_are_not_there_are_an_error_and_never_none() {
        let config = FlightConfig::default();
        for tracks in [
            TrackSource::File(PathBuf::from("tracks")),
            TrackSource::Rendered(Box::default()),
            TrackSource::Images { skip_missing: false },
        ] {
            let source = SequenceSet::flights(config.clone(), tracks);
            let error = source.frames(0, 1).unwrap_err().to_string();
            assert!(error.starts_with("f01-hall-slow: it has no file of tracks"), "{error}");
        }
        let folder = TrackSource::Images { skip_missing: false };
        let source = SequenceSet::flights(config, folder);
        let error = source.camera_input(0, 1, &Span::from(0.0)).err().unwrap();
        assert_eq!(error.to_string(), "f01-hall-slow: it has no images");
    }

    #[test]
    fn a_flight_has_truth_oracle_and_tracks_on_its_samples_clock() {
        let tracks = TrackSource::Simulated(TracksConfig::default());
        let source = SequenceSet::flights(FlightConfig::default(), tracks);
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
        let truth = SequenceSet::flights(config.clone(), tracks).recording(place, 3).unwrap().truth.unwrap();
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
