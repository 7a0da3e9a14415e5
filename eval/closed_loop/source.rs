//! One run as it is asked for: what a path or a name is, and what the odometry sees of it.

use super::error::ClosedLoopError;
use super::images::{ImageSource, has_images};
use super::logged::LoggedSequence;
use super::sequence_set::{SequenceSet, TrackSource};
use super::source_error::SourceError;
use dpn_io::asl::{Sequence, is_there};
use dpn_io::calibration::Calibration;
use dpn_logs::{ImageLogOptions, Scales};
use dpn_sim::tracks::{CameraSettings, TracksConfig};
use dpn_sim::{Flight, FlightConfig, RenderConfig};
use serde::Deserialize;
use std::path::{Path, PathBuf};

/// What the odometry sees.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize)]
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

/// One run as it is asked for.
#[derive(Debug, Clone, Default)]
pub struct RunSource {
    /// A folder with an ASL sequence, a log with images, or the name of a flight.
    pub source: String,
    /// What the odometry sees; without it the folder's images where it holds any, else tracks.
    pub camera: Option<Camera>,
    /// File of camera tracks; without it tracks are made along the ground truth from the seed.
    pub tracks: Option<PathBuf>,
    /// Of a sequence, folder with reconciled ground truth, the published one without it; of a log with images, file of true poses.
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
            let camera = CameraSettings::try_from(&given.camera)
                .map_err(|source| ClosedLoopError::Camera { sequence: self.source.clone(), source })?;
            (self.simulated_tracks.camera, self.images.camera) = (Some(camera), Some(camera));
        }
        self.calibration = given;
        Ok(self)
    }

    /// The sequence, and its place in its set. A folder is a sequence, a bag or a folder with `times.txt` a log with images, anything else a flight.
    ///
    /// # Errors
    /// What is neither; arguments that do not go together, or not with what the source is; files that cannot be read.
    pub fn open(self) -> Result<(SequenceSet, usize), ClosedLoopError> {
        let skip_missing = self.log.skip_missing;
        let made = TrackSource::Simulated(self.simulated_tracks);
        let seen = TrackSource::Images(ImageSource::Folder { skip_missing });
        let rendered = TrackSource::Images(ImageSource::Rendered(Box::new(self.images)));
        let (dir, source_name) = (Path::new(&self.source), || self.source.clone());
        let imu = &self.log.imu;
        let of_logs = [
            ("image_topic", self.log.image_topic.is_some()),
            ("topic", imu.topic.is_some()),
            ("columns", imu.csv.columns.is_some()),
            ("time_unit", imu.csv.time.is_some()),
            ("gyro_unit", imu.csv.gyro.is_some()),
            ("accel_unit", imu.csv.accel.is_some()),
            ("scale", imu.scales != Scales::default()),
        ];
        if let Some(log) = LoggedSequence::find(dir, self.log, self.calibration.as_ref())? {
            let other = self.camera.is_some_and(|camera| camera != Camera::Images);
            if other || self.tracks.is_some() {
                return Err(SourceError::OwnCamera { source_name: source_name() }.into());
            }
            let log = match &self.truth {
                Some(file) => log.with_truth(file)?,
                None => log,
            };
            return Ok((SequenceSet::logged(log, skip_missing), 0));
        }
        if let Some((argument, _)) = of_logs.into_iter().find(|(_, given)| *given) {
            return Err(SourceError::Topic { argument, source_name: source_name() }.into());
        }
        if dir.exists() || is_there(dir) {
            let tracks = match (self.camera, self.tracks) {
                (Some(Camera::Images | Camera::Rendered), Some(_)) => {
                    return Err(SourceError::TwoCameras.into());
                }
                (_, Some(tracks)) => TrackSource::File(tracks),
                (Some(Camera::Images), None) => seen,
                (Some(Camera::Rendered), None) => rendered,
                (Some(Camera::Tracks), None) => made,
                (None, None) if has_images(&Sequence::open(dir)?)? => seen,
                (None, None) => made,
            };
            let set = SequenceSet::one(dir, tracks)?.with_calibration(self.calibration);
            return Ok((set.with_reconciled_truth(self.truth.as_deref()), 0));
        }
        if self.camera == Some(Camera::Images) {
            return Err(SourceError::FlightImages.into());
        }
        let flight: Flight = self
            .source
            .parse()
            .map_err(|unknown| SourceError::Unknown { source_name: source_name(), unknown })?;
        if self.truth.is_some() {
            return Err(SourceError::FlightTruth.into());
        }
        if self.tracks.is_some() {
            return Err(SourceError::FlightTracks.into());
        }
        let tracks = if self.camera == Some(Camera::Rendered) { rendered } else { made };
        let place = Flight::ALL.iter().position(|f| *f == flight).expect("`ALL` holds every flight");
        Ok((SequenceSet::Flights { config: self.flights, tracks }, place))
    }
}
