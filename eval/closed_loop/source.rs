//! What a path or a name is, and what the odometry sees of it. Every source of recordings is opened here.

use super::error::{ClosedLoopError, OfSequence};
use super::images::has_images;
use super::logged::LoggedSequence;
use super::sequence_set::{SequenceSet, Sequences, TrackSource};
use super::source_error::SourceError;
use dpn_io::asl::Sequence;
use dpn_io::calibration::{Calibration, beside};
use dpn_logs::{ImageLogOptions, Scales};
use dpn_sim::tracks::{CameraSettings, TracksConfig};
use dpn_sim::{Flight, FlightConfig, RenderConfig};
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};

/// What the odometry sees.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Camera {
    /// Camera tracks, given or made along the ground truth.
    #[default]
    Tracks,
    /// The sequence's own images.
    Images,
    /// Images rendered along the ground truth while the odometry runs.
    Rendered,
}

/// What recordings are read or made with: all that is said of a source but its name.
#[derive(Debug, Clone, Default)]
pub struct RunSource {
    /// What the odometry sees; without it a sequence's images where it holds any, else tracks.
    pub camera: Option<Camera>,
    /// File of camera tracks, or folder with SEQUENCE.txt each; without it tracks are made along the ground truth from the seed.
    pub tracks: Option<PathBuf>,
    /// Of sequences, folder with reconciled ground truth, the published one without it; of a log with images, file of true poses, or folder with NAME.csv.
    pub truth: Option<PathBuf>,
    /// How a log with images is read; whether images that are listed but not there are passed over, of a folder too.
    pub log: ImageLogOptions,
    /// The camera's, in place of its own.
    pub calibration: Option<Calibration>,
    /// Tracks that are made.
    pub simulated_tracks: TracksConfig,
    /// Images that are rendered.
    pub images: RenderConfig,
    /// Flights.
    pub flights: FlightConfig,
}

impl RunSource {
    /// The same with a calibration in place of the camera's own, of what is simulated too.
    ///
    /// # Errors
    /// A camera that cannot be simulated.
    pub fn with_calibration(mut self, given: Option<Calibration>) -> Result<Self, ClosedLoopError> {
        if let Some(given) = &given {
            let camera = CameraSettings::try_from(&given.camera).of_sequence(&given.to_string())?;
            (self.simulated_tracks.camera, self.images.camera) = (Some(camera), Some(camera));
        }
        self.calibration = given;
        Ok(self)
    }

    /// The sequence called `name`, and its place in its set. A folder is a sequence, a bag or a folder with `times.txt` a log with images, anything else a flight.
    ///
    /// # Errors
    /// What is neither; arguments that do not go together, or not with what the source is; files that cannot be read.
    pub fn one(self, name: &str) -> Result<(SequenceSet, usize), ClosedLoopError> {
        let dir = Path::new(name);
        if let Some(log) = self.logged(dir)? {
            return Ok((log, 0));
        }
        if dir.is_file() {
            return Err(SourceError::NoImages { source_name: name.to_owned() }.into());
        }
        if dir.exists() {
            let chosen = self.camera.is_some() || self.tracks.is_some();
            let mut sequence = Sequence::open(dir)?;
            let (mut source, mut found) = (self, None);
            if source.calibration.is_none() && !matches!(sequence.camera_config(), Ok(Some(_))) {
                let dirs = ["", "mav0", "cam0", "mav0/cam0"].map(|below| dir.join(below));
                found = beside::find(&dirs)?;
                source =
                    source.with_calibration(found.as_ref().map(|(_, calibration)| calibration.clone()))?;
            }
            if let Some(given) = &source.calibration {
                sequence = sequence.with_calibration(given.clone());
            }
            let tracks = source.seen(!chosen && has_images(&sequence)?)?;
            let set = SequenceSet { found, imu: source.log.imu.clone(), ..SequenceSet::one(dir, tracks)? };
            return Ok((source.completed(set), 0));
        }
        let flight: Flight =
            name.parse().map_err(|unknown| SourceError::Unknown { source_name: name.to_owned(), unknown })?;
        let place = Flight::ALL.iter().position(|f| *f == flight).expect("`ALL` holds every flight");
        Ok((self.flown()?, place))
    }

    /// All sequences below `data`, the log with images that it is, or the simulated flights without it.
    ///
    /// # Errors
    /// As [`one`](Self::one).
    pub fn all(self, data: Option<&Path>) -> Result<SequenceSet, ClosedLoopError> {
        let Some(dir) = data else { return Ok(self.flown()?) };
        if let Some(log) = self.logged(dir)? {
            return Ok(log);
        }
        let tracks = self.seen(false)?;
        Ok(self.completed(SequenceSet::recorded(dir, tracks)?))
    }

    /// The log with images at `dir`, if there is one.
    fn logged(&self, dir: &Path) -> Result<Option<SequenceSet>, ClosedLoopError> {
        let source_name = || dir.display().to_string();
        let Some(log) = LoggedSequence::find(dir, self.log.clone(), self.calibration.as_ref())? else {
            let imu = &self.log.imu;
            // A sequence's samples are a table like others.
            let is_table = Sequence::open(dir).is_ok();
            let of_logs = [
                ("image_topic", self.log.image_topic.is_some()),
                ("topic", imu.topic.is_some()),
                ("columns", !is_table && imu.csv.columns.is_some()),
                ("time_unit", !is_table && imu.csv.time.is_some()),
                ("gyro_unit", !is_table && imu.csv.gyro.is_some()),
                ("accel_unit", !is_table && imu.csv.accel.is_some()),
                ("rate", !is_table && imu.csv.rate.is_some()),
                ("scale", !is_table && imu.scales != Scales::default()),
            ];
            return match of_logs.into_iter().find(|(_, given)| *given) {
                Some((argument, _)) => {
                    Err(SourceError::Topic { argument, source_name: source_name() }.into())
                }
                None => Ok(None),
            };
        };
        let other = self.camera.is_some_and(|camera| camera != Camera::Images);
        if other || self.tracks.is_some() {
            return Err(SourceError::OwnCamera { source_name: source_name() }.into());
        }
        let log = match &self.truth {
            Some(dir) if dir.is_dir() => {
                let file = dir.join(format!("{}.csv", log.name()));
                log.with_truth(&file)?
            }
            Some(file) => log.with_truth(file)?,
            None => log,
        };
        let tracks = TrackSource::Images { skip_missing: self.log.skip_missing };
        Ok(Some(SequenceSet { of: Sequences::Logged(log), tracks, imu: self.log.imu.clone(), found: None }))
    }

    /// What the odometry sees of sequences; `images` where nobody says it.
    fn seen(&self, images: bool) -> Result<TrackSource, SourceError> {
        let by_itself = if images { Camera::Images } else { Camera::Tracks };
        match (self.camera.unwrap_or(by_itself), &self.tracks) {
            (Camera::Images | Camera::Rendered, Some(_)) => Err(SourceError::TwoCameras),
            (Camera::Tracks, Some(tracks)) => Ok(TrackSource::File(tracks.clone())),
            (Camera::Tracks, None) => Ok(TrackSource::Simulated(self.simulated_tracks.clone())),
            (Camera::Images, None) => Ok(TrackSource::Images { skip_missing: self.log.skip_missing }),
            (Camera::Rendered, None) => Ok(TrackSource::Rendered(Box::new(self.images.clone()))),
        }
    }

    fn completed(self, set: SequenceSet) -> SequenceSet {
        set.with_calibration(self.calibration).with_reconciled_truth(self.truth.as_deref())
    }

    fn flown(self) -> Result<SequenceSet, SourceError> {
        if self.camera == Some(Camera::Images) {
            return Err(SourceError::FlightImages);
        }
        if self.truth.is_some() {
            return Err(SourceError::FlightTruth);
        }
        if self.tracks.is_some() {
            return Err(SourceError::FlightTracks);
        }
        let tracks = self.seen(false)?;
        Ok(SequenceSet::flights(self.flights, tracks))
    }
}
