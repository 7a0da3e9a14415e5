//! An estimator beside running sensors and what tells it the noise, on one clock.

use super::error::LiveError;
use super::gravity::gravity_warning;
use super::mounting::MountingWatch;
use super::setup::{Fed, pass_over_spikes, settings_for};
use super::still::Still;
use dpn_core::camera::{CameraConfig, CameraModel};
use dpn_core::estimate::NoiseSpec;
use dpn_core::noise::NoiseModel;
use dpn_core::{GrayView, ImuNoise, ImuRecording, ImuSample, SampleRate, Stamp, TrackFrame};
use dpn_noise as noise;
use dpn_pronet::network::Network;
use dpn_vio::components::Levels;
use dpn_vio::estimator::{
    Doubt, Estimator, EstimatorConfig, FeedError, FrontEndObserver, RunReport, Update, doubts, doubts_warning,
};
use dpn_vio::frontend::{camera_at_working_size, image_at_working_size};
use dpn_vio::preint::NoisySample;
use std::collections::VecDeque;

/// What the recording is called in messages.
const NAME: &str = "live";
/// Samples after which their rate is known.
const ENOUGH: usize = 100;
/// Samples after which it is known whether they are in m/s^2.
const WEIGHED: usize = 1000;
/// Most frames of tracks that wait for samples, as of images.
const MOST_WAITING: usize = 40;

/// An estimator and what tells it the noise. What comes out is what a run over the same recording gives, as long as the first hundred samples have its rate.
pub struct LiveRun {
    estimator: Estimator,
    fed: Fed,
    /// Of images as they come, and as points are followed in them.
    sizes: [[usize; 2]; 2],
    spec: NoiseSpec,
    /// Until they are asked.
    networks: Vec<Network>,
    noise: Option<noise::Feed>,
    rate: Option<SampleRate>,
    /// What was told last.
    told: Option<ImuNoise>,
    /// Until the rate is known.
    first: Vec<ImuSample>,
    /// The last sample that was taken, and the last that went on.
    last: Option<Stamp>,
    reached: Option<Stamp>,
    still: Still,
    /// Frames of tracks beyond the last sample.
    ahead: VecDeque<Stamp>,
    mounting: MountingWatch,
    /// The first samples, until they were weighed.
    to_weigh: Option<Vec<ImuSample>>,
    warnings: VecDeque<String>,
    /// Whether it was said of a sensor that its spectrum contradicts the noise told.
    contradicted: [bool; 2],
    /// Those learned last.
    levels: Option<Box<Levels>>,
    doubted: bool,
}

impl LiveRun {
    /// With a camera as calibrated on the IMU; `networks` for specs that ask some; `seed` as for [`Estimator::new`].
    ///
    /// # Errors
    /// Settings out of their bounds; a calibration of no camera.
    pub fn new(
        config: &EstimatorConfig,
        spec: NoiseSpec,
        networks: Vec<Network>,
        camera: &CameraConfig,
        fed: Fed,
        seed: u64,
    ) -> Result<Self, LiveError> {
        let model = CameraModel::try_from(camera)?;
        // Pixels of tracks are the camera's own.
        let seen = if fed == Fed::Images { camera_at_working_size(&model) } else { model };
        let estimator = Estimator::new(settings_for(config, &spec), seen, camera.body_from_cam, seed)
            .map_err(LiveError::Config)?;
        Ok(Self {
            estimator,
            fed,
            sizes: [model, seen].map(|camera| camera.size().map(|side| side as usize)),
            spec,
            networks,
            noise: None,
            rate: None,
            told: None,
            first: Vec::new(),
            last: None,
            reached: None,
            still: Still::default(),
            ahead: VecDeque::new(),
            mounting: MountingWatch::default(),
            to_weigh: Some(Vec::new()),
            warnings: VecDeque::new(),
            contradicted: [false; 2],
            levels: None,
            doubted: false,
        })
    }

    /// Takes a sample.
    ///
    /// # Errors
    /// A sample that is not later than the last or not finite, and the next one may be taken (one that says what the last said is held back: a sensor that stands still gives no pose); noise that cannot be told while samples come.
    pub fn feed_sample(&mut self, sample: ImuSample) -> Result<(), LiveError> {
        if let Some(last) = self.last.filter(|last| sample.t <= *last) {
            return Err(FeedError::SampleOutOfOrder { t: sample.t, last }.into());
        }
        if !sample.is_finite() {
            self.still.refuse(sample.t);
            self.warnings.extend(self.still.take_words());
            return Err(FeedError::NotFinite { t: sample.t }.into());
        }
        self.last = Some(sample.t);
        let (before, goes_on) = self.still.take(sample);
        self.warnings.extend(self.still.take_words());
        before.into_iter().chain(goes_on.then_some(sample)).try_for_each(|sample| self.go_on(sample))
    }

    /// Takes a sample that is a measurement.
    fn go_on(&mut self, sample: ImuSample) -> Result<(), LiveError> {
        self.reached = Some(sample.t);
        while self.ahead.front().is_some_and(|t| *t <= sample.t) {
            self.ahead.pop_front();
        }
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

    /// Takes an image; its pixels are copied, once.
    ///
    /// # Errors
    /// As [`Estimator::feed_image`]; where tracks were announced.
    pub fn feed_image(&mut self, t: Stamp, image: GrayView<'_>) -> Result<(), LiveError> {
        self.made_for(Fed::Images)?;
        let [camera, followed] = self.sizes;
        let found = [image.width(), image.height()];
        if found != camera {
            return Err(FeedError::ImageSize { t, found, camera }.into());
        }
        let fed = if followed == camera {
            self.estimator.feed_image(image, t)
        } else {
            self.estimator.feed_image(image_at_working_size(image.to_image()).view(), t)
        };
        fed.map_err(|error| match error {
            FeedError::ImuBehind { first, waiting, .. } if self.reached.is_some_and(|last| first <= last) => {
                LiveError::NotTaken { t, waiting }
            }
            error => error.into(),
        })
    }

    /// Takes a frame's tracks in pixels of the calibrated camera, each id at most once.
    ///
    /// # Errors
    /// A frame that is not later than the last, or 40 that wait for samples; where images were announced.
    pub fn feed_tracks(&mut self, frame: TrackFrame) -> Result<(), LiveError> {
        self.made_for(Fed::Tracks)?;
        let t = frame.t;
        if let Some(first) = self.ahead.front().filter(|_| self.ahead.len() >= MOST_WAITING) {
            return Err(FeedError::ImuBehind { t, first: *first, waiting: self.ahead.len() }.into());
        }
        self.estimator.feed_frame(frame)?;
        if self.reached.is_none_or(|last| t > last) {
            self.ahead.push_back(t);
        }
        Ok(())
    }

    fn made_for(&self, fed: Fed) -> Result<(), LiveError> {
        let name = |fed| if fed == Fed::Images { "images" } else { "tracks" };
        let other = LiveError::Other { found: name(fed), made: name(self.fed) };
        if fed == self.fed { Ok(()) } else { Err(other) }
    }

    /// Works off the next frame whose samples are all there.
    pub fn next_update(&mut self) -> Option<Update> {
        self.watched_update(&mut ())
    }

    /// The same while `observer` looks on at the images.
    pub fn watched_update(&mut self, observer: &mut dyn FrontEndObserver) -> Option<Update> {
        self.estimator.track_images(observer);
        self.warnings.extend(self.mounting.warning(self.estimator.images().turns()));
        let update = self.estimator.next_update();
        self.levels = update.as_ref().and_then(|update| update.levels.clone()).or(self.levels.take());
        update
    }

    /// What turned out to be wrong, each once: values that stand still or are no numbers, the accelerometer's unit, noise that the spectrum contradicts, and how the camera is said to be mounted, as soon as its turns and the gyro's tell.
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
        self.warnings.extend(self.still.bad_words());
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
    pub fn end(&mut self) -> Result<(), LiveError> {
        self.still.end().into_iter().try_for_each(|sample| self.go_on(sample))?;
        if self.noise.is_none() && self.first.len() > 1 {
            self.settle()?;
        }
        self.estimator.end_imu();
        Ok(())
    }

    /// The last sample's stamp that the odometry has.
    pub(crate) fn reached(&self) -> Option<Stamp> {
        self.reached
    }

    /// What keeps samples from it now.
    pub(crate) fn trouble(&self) -> Option<String> {
        self.still.trouble()
    }

    /// Totals so far.
    pub fn report(&self) -> &RunReport {
        self.estimator.report()
    }

    /// The rate is known: the noise can be told.
    fn settle(&mut self) -> Result<(), LiveError> {
        let first = std::mem::take(&mut self.first);
        let recording = ImuRecording::new(first).expect("samples were held to increase, and there are two");
        let feed = noise::live(&self.spec, NAME, recording.rate(), &self.networks)?;
        self.noise = Some(feed.watched(&self.spec, recording.rate()));
        self.networks = Vec::new();
        self.rate = Some(recording.rate());
        recording.samples().iter().try_for_each(|sample| self.told(*sample))
    }

    fn told(&mut self, sample: ImuSample) -> Result<(), LiveError> {
        let model = self.noise.as_mut().expect("the caller looked");
        let noise = model.feed(&sample);
        noise::check_range(&noise, &self.spec)?;
        for (said, doubt) in self.contradicted.iter_mut().zip(model.doubts()) {
            let first = doubt.filter(|_| !*said);
            *said |= first.is_some();
            self.warnings.extend(first.map(|doubt| doubt.words(&self.spec.to_string())));
        }
        self.told = Some(noise);
        Ok(pass_over_spikes(self.estimator.feed_imu(NoisySample { sample, noise }))?)
    }

    /// How many samples came while their rate is not known, and how many make it known.
    pub(crate) fn rate_in(&self) -> Option<[usize; 2]> {
        self.noise.is_none().then_some([self.first.len(), ENOUGH])
    }

    /// The samples' rate, once it is known.
    pub(crate) fn rate(&self) -> Option<SampleRate> {
        self.rate
    }
}
