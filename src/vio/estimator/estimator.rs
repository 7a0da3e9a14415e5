//! The loop over frames.

use super::config::{EstimatorConfig, FedTracks};
use super::delayed::Delayed;
use super::feed_error::FeedError;
use super::history::History;
use super::image_tracker::{FrontEndObserver, ImageTracker};
use super::imu_buffer::{ImuBuffer, Interval};
use super::jump::JumpWatch;
use super::ray_rates::RayRates;
use super::report::{RunReport, Stage};
use super::starter::{StartFrame, Starter, integrate};
use super::suspects::Suspects;
use super::update::{Phase, RestartReason, Update};
use crate::clock::SLIGHT_S;
use crate::components::Learner;
use crate::factors::reprojection::Sighting;
use crate::frontend::line_delay;
use crate::init::{InitFrame, RestWatch};
use crate::lens::LensField;
use crate::preint::{NoiseLevels, NoisySample, Preintegration};
use crate::state::NavState;
use crate::window::{Leaving, Seen, Standstill, Window};
use dpn_core::camera::CameraModel;
use dpn_core::config::{ConfigFault, Validate};
use dpn_core::random::Stream;
use dpn_core::trajectory::StampedPose;
use dpn_core::{GrayView, Stamp, TrackFrame};
use nalgebra::{Isometry3, UnitQuaternion, Vector3};
use std::collections::VecDeque;
use std::time::Instant;

/// Solving, telling outliers and finding depths anew, this many times over, settles a start.
const START_ROUNDS: usize = 5;

/// A clock found to be off by less moves no start \[s\].
const UNNOTICED_S: f64 = 0.002;

/// A frame's tracks, waiting for their samples.
#[derive(Debug, Clone)]
struct Queued {
    frame: TrackFrame,
    /// What is added to its stamp, where its image was looked at before; without it what is in force when its turn comes \[s\].
    offset_s: Option<f64>,
    /// Whether it was worked off before, by another clock.
    again: bool,
}

/// A monocular visual-inertial odometry.
#[derive(Debug, Clone)]
pub struct Estimator {
    config: EstimatorConfig,
    camera: CameraModel,
    imu: ImuBuffer,
    images: ImageTracker,
    frames: VecDeque<Queued>,
    history: History,
    /// What was added to the last frame's stamp \[s\].
    offset_s: f64,
    /// The camera's clock was found to be off by so much more than the running estimate allows for \[s\].
    clock_moved: Option<f64>,
    newest_frame: Option<Stamp>,
    window: Window,
    starter: Starter,
    rates: RayRates,
    rest: RestWatch,
    jumps: JumpWatch,
    delayed: Option<Delayed>,
    running: bool,
    /// Where the last estimate ended, for the next one to go on from.
    last_good: Option<NavState>,
    starved_since: Option<Stamp>,
    learner: Option<Learner>,
    lens: Option<LensField>,
    suspects: Suspects,
    report: RunReport,
}

impl Estimator {
    /// With a camera at `body_from_cam` on the IMU. All chance is a function of `seed` alone.
    ///
    /// # Errors
    /// Settings out of their bounds, all of them.
    pub fn new(
        mut config: EstimatorConfig,
        camera: CameraModel,
        body_from_cam: Isometry3<f64>,
        seed: u64,
    ) -> Result<Self, Vec<ConfigFault>> {
        config.init.focal_px = camera.px_per_rad();
        config.validate()?;
        let stream = Stream::new(seed).named("estimator");
        let mut estimator = Self {
            starter: Starter::new(&config, body_from_cam, stream)?,
            images: ImageTracker::new(config.front_end, camera, body_from_cam.rotation, seed)?,
            rates: RayRates::default(),
            rest: RestWatch::default(),
            jumps: JumpWatch::default(),
            delayed: None,
            last_good: None,
            camera,
            imu: ImuBuffer::default(),
            frames: VecDeque::new(),
            history: History::default(),
            offset_s: config.front_end.time_offset_s.unwrap_or(0.0),
            clock_moved: None,
            newest_frame: None,
            window: Window::new(config.window, body_from_cam),
            running: false,
            starved_since: None,
            learner: config
                .components
                .map(|components| Learner::new(components, config.imu, config.window.pixel_std)),
            lens: None,
            suspects: Suspects::default(),
            report: RunReport::default(),
            config,
        };
        if estimator.config.fed_tracks == FedTracks::Followed {
            estimator.follow();
        }
        Ok(estimator)
    }

    /// Takes a sample with the noise in force.
    ///
    /// # Errors
    /// A sample that is not later than the last, not finite, or a [spike](FeedError::Spike); it is not taken, and the next one may be.
    pub fn feed_imu(&mut self, sample: NoisySample) -> Result<(), FeedError> {
        self.images.feed_imu(&sample.sample).inspect_err(|error| {
            if matches!(error, FeedError::Spike { .. }) {
                self.report.spikes += 1;
                self.report.first_spike.get_or_insert(*error);
            }
        })?;
        self.imu.push(sample);
        self.history.sample(sample);
        Ok(())
    }

    /// Says that no more samples come: points are followed into images after the last one too, though there will be no pose for them.
    pub fn end_imu(&mut self) {
        self.images.end_imu();
    }

    /// Says that no more images come: without it those of a recording of less than two seconds are kept for what would come.
    pub fn end_images(&mut self) {
        self.images.end_images();
    }

    /// Takes an image; points are followed into it when samples reach its stamp, by [`next_update`](Self::next_update). Samples and
    /// images may come in any order between the two, each in increasing time of its own: what comes out is the same.
    ///
    /// # Errors
    /// An image that is not later than the last, or of another size than the camera's; 40 that wait for samples. It is not taken.
    pub fn feed_image(&mut self, image: GrayView<'_>, t: Stamp) -> Result<(), FeedError> {
        self.images.feed_image(image, t)?;
        if !self.window.followed {
            self.follow();
        }
        Ok(())
    }

    /// Takes tracks for what they are where points are followed through images.
    fn follow(&mut self) {
        self.window.followed = true;
        self.lens = self.config.lens.learn.then(LensField::new);
    }

    /// Takes a frame's tracks; it is worked off when samples reach its stamp. Images are not fed beside.
    ///
    /// # Errors
    /// A frame that is not later than the last; it is not taken.
    pub fn feed_frame(&mut self, frame: TrackFrame) -> Result<(), FeedError> {
        if let Some(last) = self.newest_frame.filter(|last| frame.t <= *last) {
            return Err(FeedError::FrameOutOfOrder { t: frame.t, last });
        }
        if self.newest_frame.is_none() {
            self.images.begin_with(&frame);
        }
        self.newest_frame = Some(frame.t);
        self.frames.push_back(Queued { frame, offset_s: None, again: false });
        Ok(())
    }

    /// Follows points into all images that samples have reached while `observer` looks on. [`next_update`](Self::next_update) does it by
    /// itself, unobserved, as far as it needs to.
    pub fn track_images(&mut self, observer: &mut dyn FrontEndObserver) {
        while self.follow_image(observer) {}
    }

    /// Follows points into the next images that samples have reached, up to one whose frame is handed over.
    fn follow_image(&mut self, observer: &mut dyn FrontEndObserver) -> bool {
        let Some(frame) = self.images.next_frame(observer) else { return false };
        // What was in force when the image was looked at; its frame may have made it another.
        let offset_s = Some(frame.clock_s);
        self.frames.push_back(Queued { frame, offset_s, again: false });
        true
    }

    /// Works off the next frame whose samples are all there, and the images before it.
    pub fn next_update(&mut self) -> Option<Update> {
        loop {
            let (frame, t, again) = self.next_in_time()?;
            let began = Instant::now();
            let mut update = self.work_off(&frame, t);
            if self.running {
                self.history.running(t);
            } else {
                self.history.frame(frame, t);
            }
            update.seconds = began.elapsed().as_secs_f64();
            // What was said of a frame is said: of one that is worked off again nothing comes out.
            if !again {
                self.report.clock = self.images.clock();
                self.report.readout = self.images.turns().readout();
                self.report.add(&update);
                return Some(update);
            }
        }
    }

    /// The next frame that samples have reached and its stamp on their clock; whether it is worked off again.
    fn next_in_time(&mut self) -> Option<(TrackFrame, Stamp, bool)> {
        loop {
            if self.frames.is_empty() && !self.follow_image(&mut ()) {
                // Images come in increasing time: so do their frames.
                return None;
            }
            let next = self.frames.front()?;
            let offset_s = next.offset_s.unwrap_or(self.images.clock().offset_s);
            if offset_s != self.offset_s {
                self.reclock(offset_s);
                continue;
            }
            let t = next.frame.t.plus_seconds(offset_s);
            let (oldest, newest) = (self.imu.oldest()?, self.imu.newest()?);
            if t > newest {
                return None;
            }
            let Queued { frame, again, offset_s } = self.frames.pop_front()?;
            if offset_s.is_none() && !again {
                // Where tracks are fed no image takes the samples.
                self.images.look_at_clock(&frame);
            }
            if t >= oldest {
                return Some((frame, t, again));
            }
            if !again {
                self.report.skipped += 1;
            }
        }
    }

    /// The camera's clock is off by other than was taken: what has no state yet is worked off again, a state that rests on it is given up.
    fn reclock(&mut self, offset_s: f64) {
        let moved = (offset_s - self.offset_s).abs();
        self.offset_s = offset_s;
        if self.running {
            // By less, the next interval is that much longer.
            self.clock_moved = (moved > SLIGHT_S).then_some(moved).or(self.clock_moved);
            return;
        }
        if moved < UNNOTICED_S {
            return;
        }
        let (frames, imu) = self.history.take();
        self.imu = imu;
        self.starter.reset();
        self.rates = RayRates::default();
        for frame in frames.into_iter().rev() {
            self.frames.push_front(Queued { frame, offset_s: Some(offset_s), again: true });
        }
    }

    /// Totals so far.
    pub fn report(&self) -> &RunReport {
        &self.report
    }

    /// The images on their way, and what their turns say beside the gyroscope's: of tracks that are fed too.
    pub fn images(&self) -> &ImageTracker {
        &self.images
    }

    /// The window, to look into.
    pub fn window(&self) -> &Window {
        &self.window
    }

    /// What the camera measures of a frame's tracks; tracks outside what the lens can do are left out.
    pub fn sightings(&self, frame: &TrackFrame) -> Vec<Seen> {
        frame
            .tracks
            .iter()
            .filter_map(|track| {
                let px = match &self.lens {
                    Some(lens) => lens.calibrated(&self.camera, &track.px)?,
                    None => track.px,
                };
                let mut sighting = Sighting::new(&self.camera, &px, self.window.config.pixel_std)?;
                // The pixel of the stamp's camera: a line or ten from the one that was exposed.
                sighting.delay_s = line_delay(&self.camera, &px, frame.readout_s);
                Some(Seen { id: track.id, sighting })
            })
            .collect()
    }

    /// Begins from known states instead of initialising: the next frame fed goes on after the last of them. Without any, nothing is known: the
    /// next frames initialise.
    pub fn start(&mut self, frames: Vec<StartFrame>) -> Option<NavState> {
        let followed = self.window.followed;
        self.window = Window::new(self.config.window, *self.window.body_from_cam());
        self.window.followed = followed;
        self.rest = RestWatch::default();
        self.jumps = JumpWatch::default();
        self.running = false;
        if frames.is_empty() {
            return None;
        }
        for frame in frames {
            let samples = frame.preint.as_ref().map_or(&[][..], Preintegration::samples);
            let rest = self.rests(frame.t, samples, &frame.seen);
            self.window.add_frame(frame.t, frame.state, frame.preint, &frame.seen);
            if let Some(rest) = rest {
                self.window.rest_since(rest);
            }
        }
        // The initialisation's own belief: a looser one would let a short start trade tilt for bias.
        if let Some(learner) = &mut self.learner {
            learner.restart();
            learner.apply(&mut self.window);
        }
        self.window.anchor([self.config.init.accel_bias_std, self.config.init.gyro_bias_std]);
        for _ in 0..START_ROUNDS {
            self.window.triangulate();
            self.window.optimise();
            self.window.reject_outliers();
        }
        let [oldest, ..] = self.window.frames() else { unreachable!("frames were just added") };
        let anchor = StampedPose { t: oldest.t, world_from_body: oldest.state.world_from_body };
        self.report.anchor.get_or_insert(anchor);
        let state = self.window.newest().expect("frames were just added").state;
        while self.window.is_full() {
            let leaving = self.window.leaving(self.camera.px_per_rad());
            self.window.slide(leaving);
        }
        self.delayed = Delayed::beside(&self.window, self.config.delayed);
        self.running = true;
        self.starved_since = None;
        Some(state)
    }

    /// Works off a frame of instant `t` on the IMU's clock.
    fn work_off(&mut self, frame: &TrackFrame, t: Stamp) -> Update {
        let mut clock = Clock::start();
        let interval = self.imu.cut(t);
        let mut seen = self.sightings(frame);
        self.rates.add(t, &mut seen);
        let mut update = Update {
            t,
            phase: Phase::Tracking,
            state: None,
            covariance: None,
            scale_std: None,
            tracked: 0,
            landmarks: 0,
            outliers: 0,
            iterations: 0,
            whitened: None,
            levels: None,
            jump: None,
            seconds: 0.0,
        };
        clock.lap(Stage::Feed);
        if self.running {
            if let Err(reason) = self.track(t, &interval, &seen, &mut update) {
                update = Update {
                    state: None,
                    covariance: None,
                    scale_std: None,
                    phase: Phase::Restarted(reason),
                    ..update
                };
                self.running = false;
                // What waits for a new start is seen with what was told.
                self.window.config.pixel_std = self.config.window.pixel_std;
            }
        } else {
            match self.starter.push(&self.config, t, interval, seen) {
                Err(reason) => update.phase = Phase::Initialising(reason),
                Ok((frames, fit)) => {
                    // Of points followed through images the residuals have lasting errors too, and a window that takes them for the accelerometer's noise may make the
                    // path several times too small and stay there. Taken for the gyroscope's they cost no scale, and one with a wrong sign or scale is believed less at once.
                    let accel = if self.window.followed { 1.0 } else { fit.accel_factor };
                    if let Some(learner) = &mut self.learner {
                        learner.begin_at(accel, fit.gyro_factor);
                    }
                    let frames = self.go_on_from_last(frames);
                    update.state = self.start(frames);
                    update.scale_std = self.window.scale_std();
                    if self.config.covariance {
                        update.covariance = self.window.newest_pose_covariance().map(Box::new);
                    }
                    self.last_good = update.state.or(self.last_good);
                }
            }
            clock.lap(Stage::Initialise);
        }
        update.levels = self.learner.as_ref().map(|learner| Box::new(learner.levels()));
        self.report.add_seconds(&clock.seconds);
        update
    }

    /// Moves a new start to where the last estimate ended: position and heading of its first frame.
    fn go_on_from_last(&self, mut frames: Vec<StartFrame>) -> Vec<StartFrame> {
        let (Some(last), Some(first)) = (self.last_good, frames.first()) else { return frames };
        let from = first.state.world_from_body;
        let heading = |rotation: &UnitQuaternion<f64>| {
            let forward = rotation * Vector3::x();
            forward.y.atan2(forward.x)
        };
        let turn = heading(&last.world_from_body.rotation) - heading(&from.rotation);
        let turn = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), turn);
        let shift = last.world_from_body.translation.vector - turn * from.translation.vector;
        let old_from_new = Isometry3::from_parts(shift.into(), turn);
        for frame in &mut frames {
            frame.state.world_from_body = old_from_new * frame.state.world_from_body;
            frame.state.vel_in_world = turn * frame.state.vel_in_world;
        }
        frames
    }

    /// The rest that the newest frame is in; `None` while something moves, or may.
    fn rests(&mut self, t: Stamp, samples: &[NoisySample], seen: &[Seen]) -> Option<Standstill> {
        let rates = samples.iter().map(|s| Vector3::from(s.sample.gyro)).sum::<Vector3<f64>>();
        let rate = rates.norm() / samples.len().max(1) as f64;
        let frame = InitFrame::new(t, seen.iter().map(|s| (s.id, s.sighting.bearing)).collect());
        let rest = self.rest.push(&frame, rate, &self.config.init)?;
        if !rest.lasts {
            self.window.rest_ended(rest.sure_until(), self.config.init.rest_angle());
            return None;
        }
        Some(Standstill { from: rest.from, angle: rest.moved })
    }

    fn track(
        &mut self,
        t: Stamp,
        interval: &Interval,
        seen: &[Seen],
        update: &mut Update,
    ) -> Result<(), RestartReason> {
        let mut clock = Clock::start();
        if let Some(seconds) = self.clock_moved.take() {
            return Err(RestartReason::CameraClock { seconds });
        }
        if interval.longest_step > self.config.health.max_imu_gap {
            return Err(RestartReason::ImuGap { seconds: interval.longest_step });
        }
        let rest = self.rests(t, &interval.samples, seen);
        let levels = self.learner.as_ref().map(|learner| learner.levels().inertial);
        let entering = Entering { config: &self.config, levels, t, samples: &interval.samples, seen, rest };
        let last = self.window.newest().expect("while it runs the window has frames: `start` saw one").t;
        let Some((predicted, tracked)) = entering.enter(&mut self.window) else {
            return Err(RestartReason::ImuGap { seconds: t.seconds_since(last) });
        };
        update.tracked = counted(tracked);
        if let Some(beside) = self.jumps.beside() {
            while beside.is_full() {
                // Intervals stay apart until it is known in which the jump fell.
                beside.slide(Leaving::Oldest);
            }
            entering.enter(beside);
            beside.triangulate();
        }
        if let Some(delayed) = &mut self.delayed {
            delayed.enter(&self.window, seen);
        }
        self.window.triangulate();
        clock.lap(Stage::Feed);
        let solved = self.window.optimise();
        update.iterations = counted(solved.iterations);
        update.jump = self.jumps.look(&mut self.window, solved.last_cost).map(Box::new);
        if update.jump.is_some() {
            // The prior of before does not allow for it.
            self.delayed = Delayed::beside(&self.window, self.config.delayed);
        }
        clock.lap(Stage::Solve);
        update.outliers = counted(self.window.reject_outliers());
        clock.lap(Stage::Reject);
        let state = self.window.newest().expect("a frame was just added").state;
        if let Some(reason) = self.config.health.judge(&state, &predicted, self.jumps.reach()) {
            return Err(reason);
        }
        if update.tracked as usize >= self.config.health.min_tracks {
            self.starved_since = None;
        } else {
            let since = *self.starved_since.get_or_insert(t);
            let seconds = t.seconds_since(since);
            if seconds > self.config.health.max_starved {
                return Err(RestartReason::Starved { seconds });
            }
        }
        update.state = Some(state);
        update.scale_std = self.window.scale_std();
        self.last_good = Some(state);
        if self.config.covariance {
            update.covariance = self.window.newest_pose_covariance().map(Box::new);
        }
        update.landmarks =
            counted(self.window.landmarks().iter().filter(|l| l.inverse_depth.is_some()).count());
        if let Some(delayed) = &mut self.delayed {
            delayed.take_estimates(&self.window);
        }
        if self.window.is_full() {
            let leaving: Leaving = self.window.leaving(self.camera.px_per_rad());
            if self.suspects.read(&mut self.window) {
                self.report.suspect = self.suspects.surest(&self.window.body_from_cam().rotation);
            }
            if let Some(learner) = self.learner.as_mut().filter(|_| leaving == Leaving::Oldest) {
                learner.read(&mut self.window);
            }
            if let Some(lens) = self.lens.as_mut().filter(|_| leaving == Leaving::Oldest) {
                self.report.lens_px = lens.read(&self.window).or(self.report.lens_px);
            }
            update.whitened = self.window.slide(leaving);
            if let Some(delayed) = &mut self.delayed {
                delayed.follow(&mut self.window, leaving);
            }
            if let Some(learner) = &self.learner {
                learner.apply(&mut self.window);
                let beside = [self.jumps.beside(), self.delayed.as_mut().map(Delayed::window)];
                beside.into_iter().flatten().for_each(|window| learner.apply(window));
            }
        }
        clock.lap(Stage::Slide);
        self.report.add_seconds(&clock.seconds);
        Ok(())
    }
}

/// A frame on its way into a window.
struct Entering<'a> {
    config: &'a EstimatorConfig,
    levels: Option<NoiseLevels>,
    t: Stamp,
    samples: &'a [NoisySample],
    seen: &'a [Seen],
    rest: Option<Standstill>,
}

impl Entering<'_> {
    /// Puts it at the end of a window: the state that the samples predict from the frame before, and how many tracks go on. `None`, and nothing
    /// done, where there are too few samples.
    fn enter(&self, window: &mut Window) -> Option<(NavState, usize)> {
        let last = window.newest()?.state;
        let mut preint = integrate(self.config, &last.bias, self.samples)?;
        if let Some(levels) = self.levels {
            preint.set_levels(levels);
        }
        let predicted = preint.predict(&last);
        let tracked = window.add_frame(self.t, predicted, Some(preint), self.seen);
        if let Some(rest) = self.rest {
            window.rest_since(rest);
        }
        Some((predicted, tracked))
    }
}

struct Clock {
    at: Instant,
    seconds: [f64; 5],
}

impl Clock {
    fn start() -> Self {
        Self { at: Instant::now(), seconds: [0.0; 5] }
    }

    fn lap(&mut self, stage: Stage) {
        let now = Instant::now();
        self.seconds[stage as usize] += (now - self.at).as_secs_f64();
        self.at = now;
    }
}

fn counted(of_a_frame: usize) -> u32 {
    u32::try_from(of_a_frame).expect("a frame's tracks fit into memory many times over")
}
