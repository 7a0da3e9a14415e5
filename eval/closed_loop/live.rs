//! The odometry beside running sensors: samples and images as they come, poses as soon as they can be had.

use super::drive::settings_for;
use super::error::ClosedLoopError;
use super::gravity::gravity_warning;
use super::mounting_watch::MountingWatch;
use super::tracking::pass_over_spikes;
use crate::noise;
use dpn_core::camera::CameraModel;
use dpn_core::estimate::NoiseSpec;
use dpn_core::noise::NoiseModel;
use dpn_core::{GrayImage, ImuNoise, ImuRecording, ImuSample, Stamp};
use dpn_pronet::network::Network;
use dpn_vio::components::Levels;
use dpn_vio::estimator::{
    Doubt, Estimator, EstimatorConfig, FeedError, RunReport, Update, doubts, doubts_warning,
};
use dpn_vio::frontend::{camera_at_working_size, image_at_working_size};
use dpn_vio::preint::NoisySample;
use nalgebra::Isometry3;
use std::collections::VecDeque;

/// What the recording is called in messages.
const NAME: &str = "live";
/// Samples after which their rate is known.
const ENOUGH: usize = 100;
/// Samples after which it is known whether they are in m/s^2.
const WEIGHED: usize = 1000;

/// An estimator and what tells it the noise. What comes out is what a run over the same recording gives, as long as the first hundred samples have its rate.
pub struct LiveRun<'a> {
    estimator: Estimator,
    /// Of images as they come.
    size: [usize; 2],
    spec: NoiseSpec,
    networks: &'a [Network],
    noise: Option<noise::Feed>,
    /// What was told of the last sample.
    told: Option<ImuNoise>,
    /// Until the rate is known.
    first: Vec<ImuSample>,
    last: Option<Stamp>,
    mounting: MountingWatch,
    /// The first samples, until they were weighed.
    to_weigh: Option<Vec<ImuSample>>,
    warnings: VecDeque<String>,
    /// Those learned last.
    levels: Option<Box<Levels>>,
    doubted: bool,
}

impl<'a> LiveRun<'a> {
    /// With a camera at `body_from_cam` on the IMU; `seed` as for [`Estimator::new`].
    ///
    /// # Errors
    /// Settings out of their bounds.
    pub fn new(
        config: &EstimatorConfig,
        spec: NoiseSpec,
        networks: &'a [Network],
        (camera, body_from_cam): (CameraModel, Isometry3<f64>),
        seed: u64,
    ) -> Result<Self, ClosedLoopError> {
        let size = camera.size().map(|side| side as usize);
        let camera = camera_at_working_size(&camera);
        let estimator = Estimator::new(settings_for(config, &spec), camera, body_from_cam, seed)
            .map_err(ClosedLoopError::Config)?;
        Ok(Self {
            estimator,
            size,
            spec,
            networks,
            noise: None,
            told: None,
            first: Vec::new(),
            last: None,
            mounting: MountingWatch::default(),
            to_weigh: Some(Vec::new()),
            warnings: VecDeque::new(),
            levels: None,
            doubted: false,
        })
    }

    /// Takes a sample.
    ///
    /// # Errors
    /// A sample that is not later than the last or not finite, and the next one may be taken; noise that cannot be told while samples come.
    pub fn feed_sample(&mut self, sample: ImuSample) -> Result<(), ClosedLoopError> {
        if let Some(last) = self.last.filter(|last| sample.t <= *last) {
            return Err(self.refused(FeedError::SampleOutOfOrder { t: sample.t, last }));
        }
        if !sample.is_finite() {
            return Err(self.refused(FeedError::NotFinite { t: sample.t }));
        }
        self.last = Some(sample.t);
        if let Some(samples) = &mut self.to_weigh {
            samples.push(sample);
        }
        self.weigh(WEIGHED);
        if self.noise.is_some() {
            return self.told(sample);
        }
        self.first.push(sample);
        if self.first.len() < ENOUGH {
            return Ok(());
        }
        self.settle()
    }

    /// Takes an image.
    ///
    /// # Errors
    /// As [`Estimator::feed_image`].
    pub fn feed_image(&mut self, t: Stamp, image: GrayImage) -> Result<(), ClosedLoopError> {
        let found = [image.width(), image.height()];
        if found != self.size {
            return Err(self.refused(FeedError::ImageSize { t, found, camera: self.size }));
        }
        let image = image_at_working_size(image);
        self.estimator.feed_image(image.view(), t).map_err(|error| self.refused(error))
    }

    /// Works off the next frame whose samples are all there.
    pub fn next_update(&mut self) -> Option<Update> {
        self.estimator.track_images(&mut ());
        self.warnings.extend(self.mounting.warning(self.estimator.images().turns()));
        let update = self.estimator.next_update();
        self.levels = update.as_ref().and_then(|update| update.levels.clone()).or(self.levels.take());
        update
    }

    /// What turned out to be wrong, each once: the accelerometer's unit, and how the camera is said to be mounted, as soon as its turns and the gyro's tell.
    pub fn take_warning(&mut self) -> Option<String> {
        self.warnings.pop_front()
    }

    /// The noise in force: what was told of the last sample, times the levels learned last; none before the rate is known.
    pub fn noise_in_force(&self) -> Option<ImuNoise> {
        let told = self.told?;
        self.levels.as_deref().map_or(Some(told), |levels| levels.inertial.applied_to(&told))
    }

    /// The levels learned last.
    pub fn levels(&self) -> Option<&Levels> {
        self.levels.as_deref()
    }

    /// What speaks against the run so far.
    pub fn doubts(&self) -> Vec<Doubt> {
        doubts(self.estimator.report(), self.levels.as_deref())
    }

    /// Nothing more comes, and all updates were taken: what only the whole of it says is a warning from here on.
    pub fn look_back(&mut self) {
        self.weigh(0);
        let turns = self.estimator.images().turns();
        self.warnings.extend(self.mounting.last_warning(turns));
        let against = self.doubts();
        let cause_is_known = turns.axes().warning().is_some();
        self.warnings.extend(doubts_warning(&against, cause_is_known));
        self.doubted = cause_is_known || !against.is_empty();
    }

    /// Whether something speaks against the run that was [looked back](Self::look_back) at.
    pub fn is_doubted(&self) -> bool {
        self.doubted
    }

    /// Looks at the first samples' force, where there are more than `count`.
    fn weigh(&mut self, count: usize) {
        if let Some(samples) = self.to_weigh.take_if(|samples| samples.len() > count) {
            self.warnings.extend(gravity_warning(&samples));
        }
    }

    /// Says that nothing more comes.
    ///
    /// # Errors
    /// Noise that cannot be told, where so few samples came that nobody asked before.
    pub fn end(&mut self) -> Result<(), ClosedLoopError> {
        if self.noise.is_none() && self.first.len() > 1 {
            self.settle()?;
        }
        self.estimator.end_imu();
        Ok(())
    }

    /// Totals so far.
    pub fn report(&self) -> &RunReport {
        self.estimator.report()
    }

    /// The rate is known: the noise can be told.
    fn settle(&mut self) -> Result<(), ClosedLoopError> {
        let first = std::mem::take(&mut self.first);
        let recording = ImuRecording::new(first).expect("samples were held to increase, and there are two");
        self.noise = Some(noise::live(&self.spec, NAME, recording.rate(), self.networks)?);
        recording.samples().iter().try_for_each(|sample| self.told(*sample))
    }

    fn told(&mut self, sample: ImuSample) -> Result<(), ClosedLoopError> {
        let model = self.noise.as_mut().expect("the caller looked");
        let noise = model.feed(&sample);
        noise::check_range(&noise, &self.spec)?;
        self.told = Some(noise);
        pass_over_spikes(self.estimator.feed_imu(NoisySample { sample, noise }))
            .map_err(|error| self.refused(error))
    }

    fn refused(&self, source: FeedError) -> ClosedLoopError {
        ClosedLoopError::Feed { sequence: NAME.to_owned(), source }
    }
}
