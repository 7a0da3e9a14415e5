//! What other programs hold: an odometry made from settings, fed with what sensors say by their own stamps.

use super::config::OdometryConfig;
use super::error::LiveError;
use super::run::LiveRun;
use super::setup::{Fed, settings_for};
use dpn_core::camera::CameraModel;
use dpn_core::estimate::NoiseSpec;
use dpn_core::{GrayView, ImuNoise, ImuSample, SampleRate, Stamp, Track, TrackFrame};
use dpn_io::calibration::Calibration;
use dpn_io::parse_image;
use dpn_pronet::network::Network;
use dpn_vio::EstimatorConfig;
use dpn_vio::estimator::{Phase, Update};
use nalgebra::{Vector2, Vector3};
use std::collections::HashSet;
use std::path::Path;

/// A sensor that has not been heard of for so long while the other was is waited for \[s\].
const SILENT_S: f64 = 1.0;

/// A visual-inertial odometry beside running sensors. All its work is done by who calls; samples and images may come in any order between the two.
pub struct Odometry {
    run: LiveRun,
    pub(crate) calibration: Calibration,
    pub(crate) camera: CameraModel,
    fed: Fed,
    config: EstimatorConfig,
    /// Newest sample and newest image or frame, on the IMU's clock.
    newest: [Option<Stamp>; 2],
    /// What came of the last frame.
    last: Option<(Phase, bool)>,
}

/// The IMU's noise as it is in force: what was told times what was learned.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NoiseInForce {
    /// Deviations of one sample at `rate`.
    pub sample: ImuNoise,
    /// Rate of the samples; a density is a deviation over its root.
    pub rate: SampleRate,
    /// Walk of the accelerometer's bias \[m/s^3/sqrt(Hz)\].
    pub accel_walk: f64,
    /// Walk of the gyroscope's bias \[rad/s^2/sqrt(Hz)\].
    pub gyro_walk: f64,
    /// Deviation of a pixel \[px\].
    pub pixel: f64,
    /// Deviations of the logarithms of what was learned (accelerometer x y z, gyroscope x y z, their walks): 1 and more where next to nothing is known.
    /// `None` where nothing is learned.
    pub unsure: Option<[f64; 8]>,
}

impl Odometry {
    /// Of these settings; `networks` for specs that ask some.
    ///
    /// # Errors
    /// A calibration that cannot be read or is of no camera; settings out of their bounds.
    pub fn new(config: &OdometryConfig, networks: Vec<Network>) -> Result<Self, LiveError> {
        let calibration = config.calibration()?;
        let OdometryConfig { camera, noise, seed, estimator, .. } = config;
        Self::calibrated(calibration, *camera, noise, estimator, networks, *seed)
    }

    /// The same where the calibration was read before.
    ///
    /// # Errors
    /// As [`new`](Self::new).
    pub fn calibrated(
        calibration: Calibration,
        fed: Fed,
        noise: &NoiseSpec,
        estimator: &EstimatorConfig,
        networks: Vec<Network>,
        seed: u64,
    ) -> Result<Self, LiveError> {
        let camera = &calibration.camera;
        let run = LiveRun::new(estimator, noise.clone(), networks, camera, fed, seed)?;
        let (camera, config) = (CameraModel::try_from(camera)?, settings_for(estimator, noise));
        Ok(Self { run, calibration, camera, fed, config, newest: [None; 2], last: None })
    }

    /// Takes a sample.
    ///
    /// # Errors
    /// One that is not later than the last or not finite; noise that cannot be told of samples at this rate.
    pub fn feed_sample(&mut self, sample: ImuSample) -> Result<(), LiveError> {
        self.run.feed_sample(sample)?;
        self.newest[0] = Some(sample.t);
        Ok(())
    }

    /// Takes an image of the camera's stamp `t`; its pixels are copied.
    ///
    /// # Errors
    /// One that is not later than the last or of another size; 40 that wait for samples, or to be worked off.
    pub fn feed_image(&mut self, t: Stamp, image: GrayView<'_>) -> Result<(), LiveError> {
        let t = self.calibration.on_imu_clock(t);
        self.run.feed_image(t, image)?;
        self.newest[1] = Some(t);
        Ok(())
    }

    /// The same of a file's bytes, PNG or JPEG.
    ///
    /// # Errors
    /// Bytes that are no such image; as [`feed_image`](Self::feed_image).
    pub fn feed_encoded(&mut self, t: Stamp, bytes: &[u8]) -> Result<(), LiveError> {
        let size = self.camera.size().map(|side| side as usize);
        let image = parse_image(bytes, Path::new("image"), size)?;
        self.feed_image(t, image.view())
    }

    /// Takes the tracks of a frame of the camera's stamp `t`: distorted pixels, or where `normalised` the points (x / z, y / z) that the lens bends yet.
    ///
    /// # Errors
    /// A frame that is not later than the last, an id twice, a point that is nowhere; 40 frames that wait for samples.
    pub fn feed_tracks(
        &mut self,
        t: Stamp,
        points: impl IntoIterator<Item = (u64, [f64; 2])>,
        normalised: bool,
    ) -> Result<(), LiveError> {
        let t = self.calibration.on_imu_clock(t);
        let mut ids = HashSet::new();
        let tracks = points.into_iter().map(|(id, at)| {
            if !ids.insert(id) {
                return Err(LiveError::IdTwice { t, id });
            }
            let px = match normalised {
                true => self.camera.project(&Vector3::new(at[0], at[1], 1.0)),
                false => Some(Vector2::from(at)),
            };
            match px.filter(|px| px.iter().all(|v| v.is_finite())) {
                Some(px) => Ok(Track { id, px }),
                None => Err(LiveError::Point { t, id, at, normalised }),
            }
        });
        let tracks = tracks.collect::<Result<_, _>>()?;
        self.run.feed_tracks(TrackFrame::new(t, tracks))?;
        self.newest[1] = Some(t);
        Ok(())
    }

    /// Says that nothing more comes: points are followed into the last images too.
    ///
    /// # Errors
    /// Noise that cannot be told, where few samples came.
    pub fn end(&mut self) -> Result<(), LiveError> {
        self.run.end()
    }

    /// Works off the next frame whose samples are all there.
    pub fn next_update(&mut self) -> Option<Update> {
        let update = self.run.next_update()?;
        self.last = Some((update.phase, update.state.is_some()));
        Some(update)
    }

    /// What seems to be wrong with the input, each once.
    pub fn take_warning(&mut self) -> Option<String> {
        self.run.take_warning()
    }

    /// The noise in force; `None` until the samples' rate is known.
    pub fn noise(&self) -> Option<NoiseInForce> {
        let (rate, sample, levels) = (self.run.rate()?, self.run.noise_in_force()?, self.run.levels());
        let [of_accel_walk, of_gyro_walk] =
            levels.map_or([1.0; 2], |levels| [levels.inertial.0[6], levels.inertial.0[7]]);
        Some(NoiseInForce {
            sample,
            rate,
            accel_walk: of_accel_walk * self.config.imu.accel_bias_walk.get(),
            gyro_walk: of_gyro_walk * self.config.imu.gyro_bias_walk.get(),
            pixel: levels.map_or(1.0, |levels| levels.pixel) * self.config.window.pixel_std,
            unsure: levels.map(|levels| levels.unsure),
        })
    }

    /// What is waited for; `None` while poses come.
    pub fn waiting(&self) -> Option<String> {
        let seen = if self.fed == Fed::Images { "image" } else { "frame of tracks" };
        let (sample, frame) = match self.newest {
            _ if let Some(trouble) = self.run.trouble() => return Some(trouble),
            [None, _] => return Some("no IMU sample has come".to_owned()),
            [_, None] => return Some(format!("no {seen} has come")),
            [Some(sample), Some(frame)] => (sample, frame),
        };
        if let Some([found, needed]) = self.run.rate_in() {
            return Some(format!("{found} IMU samples of {needed}, by which their rate is known"));
        }
        let ahead = frame.seconds_since(sample);
        if ahead > SILENT_S {
            return Some(format!(
                "no IMU sample since {sample}, and the newest {seen} is of {frame}, {ahead:.1} s later: is the IMU silent, or its clock another?"
            ));
        }
        if -ahead > SILENT_S {
            return Some(format!(
                "no {seen} since {frame}, and the newest IMU sample is of {sample}, {:.1} s later: is the camera silent, or its clock another?",
                -ahead
            ));
        }
        match &self.last {
            None => Some(format!("the first {seen} that samples reach is not worked off yet")),
            Some((Phase::Initialising(reason), false)) => Some(format!("initialising: {reason}")),
            Some((Phase::Restarted(reason), _)) => Some(format!("given up, initialising again: {reason}")),
            Some(_) => None,
        }
    }
}
