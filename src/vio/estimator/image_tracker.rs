//! Images on their way to tracks: they wait until samples reach them, then the front-end follows points into them.
//!
//! Whether an image or its samples come first makes no difference: an image is worked off when there is a sample at or after its stamp, so that
//! the turn the gyroscope says is the same in any order of arrival. Nothing of it depends on the noise of the samples or on an estimate: tracks
//! made once serve every noise, and [`Estimator::feed_frame`](crate::Estimator::feed_frame) makes of them what
//! [`Estimator::feed_image`](crate::Estimator::feed_image) makes of the images.
//!
//! The first two seconds are looked at beforehand. Points are foreseen by the gyroscope's turns: with a camera that is late they are foreseen in wrong places and
//! lost, and nothing can be built on those that are left, also once the clock is found. So a tracker goes before until it has found it; then points are
//! followed through the same images anew. Of a camera whose clock is right they would be the same points: what the tracker that went before has found is taken as it is.
//! A camera at rest says nothing of its clock, and is followed by any: there the tracker goes before again when the gyroscope begins to turn.

use super::feed_error::FeedError;
use super::spike::SpikeFilter;
use crate::clock::{CameraClock, ClockWatch, REACH_S};
use crate::frontend::{Fed, FrontEnd, FrontEndConfig, GyroTurn, LineTurns, turn_of_camera};
use dpn_core::camera::CameraModel;
use dpn_core::config::ConfigFault;
use dpn_core::geometry::so3;
use dpn_core::random::Stream;
use dpn_core::{GrayImage, GrayView, ImuSample, Stamp, TrackFrame};
use nalgebra::{UnitQuaternion, Vector3};
use std::collections::VecDeque;

/// Most images that wait for samples: two seconds at 20 Hz.
pub(super) const MOST_WAITING: usize = 40;

/// The first images are kept so long \[s\].
const SCOUTED_S: f64 = 2.0;
/// Rates are means over so much time before an image \[s\].
const RATE_S: f64 = 0.25;
/// A rate that changes by less is of a body that does not begin to turn \[rad/s\].
const BEGINS_TO_TURN: f64 = 0.06;

/// Who looks on while points are followed through images: figures, pictures. What it does changes no track.
pub trait FrontEndObserver {
    /// The image taken at `t` is about to be worked off.
    fn begin(&mut self, t: Stamp) {
        let _ = t;
    }

    /// What was made of an image.
    fn end(&mut self, image: &GrayImage, fed: &Fed);
}

/// Nobody.
impl FrontEndObserver for () {
    fn end(&mut self, _: &GrayImage, _: &Fed) {}
}

/// An image, and what was made of it where it was followed.
type Seen = (Stamp, GrayImage, Option<Fed>);

/// The front-end with the images and gyroscope samples that wait for it.
#[derive(Debug, Clone)]
pub struct ImageTracker {
    front_end: FrontEnd,
    gyro: GyroTurn,
    clock: ClockWatch,
    body_from_cam: UnitQuaternion<f64>,
    size: [usize; 2],
    scout: Option<Scout>,
    /// The gyroscope's rate while the camera rests and nothing is known of its clock, in the body's axes \[rad/s\].
    resting: Option<Vector3<f64>>,
    /// Those that the scout has seen, before those that wait, with what it made of them where that holds.
    again: VecDeque<Seen>,
    waiting: VecDeque<(Stamp, GrayImage)>,
    newest_image: Option<Stamp>,
    newest_sample: Option<Stamp>,
    spikes: SpikeFilter,
    imu_ended: bool,
    images_ended: bool,
}

impl ImageTracker {
    /// For a camera turned by `body_from_cam` on the IMU. The chance of its consensus is a function of `seed` alone.
    ///
    /// # Errors
    /// Settings out of their bounds, all of them.
    pub fn new(
        config: FrontEndConfig,
        camera: CameraModel,
        body_from_cam: UnitQuaternion<f64>,
        seed: u64,
    ) -> Result<Self, Vec<ConfigFault>> {
        let alone = Self::alone(config, camera, body_from_cam, seed)?;
        let scout = config.time_offset_s.is_none().then(|| Scout::new(alone.clone()));
        Ok(Self { scout, ..alone })
    }

    /// One that looks at each image once.
    fn alone(
        config: FrontEndConfig,
        camera: CameraModel,
        body_from_cam: UnitQuaternion<f64>,
        seed: u64,
    ) -> Result<Self, Vec<ConfigFault>> {
        Ok(Self {
            front_end: FrontEnd::new(camera, config, &Stream::new(seed).named("front-end"))?,
            gyro: GyroTurn::new(),
            clock: ClockWatch::new(camera, body_from_cam, config.time_offset_s),
            body_from_cam,
            size: camera.size().map(|side| side as usize),
            scout: None,
            resting: None,
            again: VecDeque::new(),
            waiting: VecDeque::new(),
            newest_image: None,
            newest_sample: None,
            spikes: SpikeFilter::default(),
            imu_ended: false,
            images_ended: false,
        })
    }

    /// Takes a sample.
    ///
    /// # Errors
    /// A sample that is not later than the last, not finite, or a spike; it is not taken, and the next one may be.
    pub fn feed_imu(&mut self, sample: &ImuSample) -> Result<(), FeedError> {
        let t = sample.t;
        if !sample.is_finite() {
            return Err(FeedError::NotFinite { t });
        }
        if let Some(last) = self.newest_sample.filter(|last| t <= *last) {
            return Err(FeedError::SampleOutOfOrder { t, last });
        }
        if let Some((sensor, reading)) = self.spikes.spike(sample) {
            return Err(FeedError::Spike { t, sensor, reading });
        }
        self.take(sample);
        Ok(())
    }

    /// Takes a sample that was found to be good, as the scout does.
    fn take(&mut self, sample: &ImuSample) {
        self.newest_sample = Some(sample.t);
        self.imu_ended = false;
        self.gyro.feed(sample);
        self.clock.feed_imu(sample);
        if let Some(scout) = &mut self.scout {
            scout.tracker.take(sample);
        }
    }

    /// Says that no more samples come: images do not wait for them any longer.
    pub fn end_imu(&mut self) {
        self.imu_ended = true;
        if let Some(scout) = &mut self.scout {
            scout.tracker.end_imu();
        }
    }

    /// Says that no more images come: what was kept of few of them is worked off.
    pub fn end_images(&mut self) {
        self.images_ended = true;
    }

    /// The camera's clock so far.
    pub fn clock(&self) -> CameraClock {
        self.clock.clock()
    }

    /// The turns of camera and gyroscope.
    pub fn turns(&self) -> &ClockWatch {
        &self.clock
    }

    /// Takes tracks to begin with this frame: what was known of the clock when they were made is known.
    pub(super) fn begin_with(&mut self, frame: &TrackFrame) {
        self.scout = None;
        self.clock.begin_at(frame.clock_s, frame.t);
    }

    /// A stamp of the camera on the IMU's clock, as far as is known.
    pub(super) fn on_imu_clock(&self, t: Stamp) -> Stamp {
        self.clock.on_imu_clock(t)
    }

    /// Looks at a frame whose samples are there for what it says of the clock, and forgets samples that no image after it needs;
    /// [`next_frame`](Self::next_frame) does so by itself.
    pub(super) fn look_at_clock(&mut self, frame: &TrackFrame) {
        let before = self.clock().offset_s;
        self.clock.feed_frame(frame);
        self.gyro.move_last(self.clock().offset_s - before);
        self.forget_before(self.on_imu_clock(frame.t));
    }

    /// Forgets samples that no image after `t` needs, wherever the clock will be found to be.
    fn forget_before(&mut self, t: Stamp) {
        self.gyro.forget_before(t.plus_seconds(-0.5 * self.readout_s().abs() - 2.0 * REACH_S));
    }

    fn readout_s(&self) -> f64 {
        let found = || self.clock.readout().map_or(0.0, |found| found.seconds);
        self.front_end.config().readout_s.unwrap_or_else(found)
    }

    /// Takes an image; points are followed into it when a sample at or after its stamp is there.
    ///
    /// # Errors
    /// An image that is not later than the last, or of another size than the camera's; 40 that wait for samples. It is not taken.
    pub fn feed_image(&mut self, image: GrayView<'_>, t: Stamp) -> Result<(), FeedError> {
        if let Some(last) = self.newest_image.filter(|last| t <= *last) {
            return Err(FeedError::ImageOutOfOrder { t, last });
        }
        let found = [image.width(), image.height()];
        if found != self.size {
            return Err(FeedError::ImageSize { t, found, camera: self.size });
        }
        if let Some((first, _)) = self.waiting.front().filter(|_| self.waiting.len() >= MOST_WAITING) {
            return Err(FeedError::ImuBehind { t, first: *first, waiting: self.waiting.len() });
        }
        self.newest_image = Some(t);
        self.waiting.push_back((t, image.to_image()));
        Ok(())
    }

    /// The camera's turns while the image of time `t` on the IMU's clock is read out; none where its lines are taken at once, or no samples cover them.
    fn line_turns(&self, t: Stamp) -> Option<LineTurns> {
        let readout_s = self.readout_s();
        let turns = if readout_s == 0.0 { return None } else { self.gyro.over(t, readout_s)? };
        Some(LineTurns::new(&turns, &self.body_from_cam, readout_s))
    }

    /// When the next image was taken on the IMU's clock, where samples have reached it.
    fn reached(&self) -> Option<Stamp> {
        let again = self.again.front().map(|(t, ..)| *t);
        let t = self.on_imu_clock(again.or(self.waiting.front().map(|(t, _)| *t))?);
        let read_out = t.plus_seconds(0.5 * self.readout_s().abs());
        (self.imu_ended || self.newest_sample.is_some_and(|newest| read_out <= newest)).then_some(t)
    }

    /// The next image, where samples have reached it: those seen by the scout come again.
    fn next_image(&mut self) -> Option<Seen> {
        self.reached()?;
        self.again.pop_front().or_else(|| self.waiting.pop_front().map(|(t, image)| (t, image, None)))
    }

    /// The gyroscope's mean rate before `t` on the IMU's clock \[rad/s\]; none where samples do not cover it.
    fn rate_before(&self, t: Stamp) -> Option<Vector3<f64>> {
        Some(so3::log(&self.gyro.integrate(t.plus_seconds(-RATE_S), t)?) / RATE_S)
    }

    /// Sends a scout out again before an image of a camera that rested and begins to turn.
    fn scout_again(&mut self) {
        let Some(at_rest) = self.resting.filter(|_| self.scout.is_none() && self.again.is_empty()) else {
            return;
        };
        if self.clock.is_known() {
            self.resting = None;
            return;
        }
        let rate = self.reached().and_then(|t| self.rate_before(t));
        if rate.is_some_and(|rate| (rate - at_rest).norm() > BEGINS_TO_TURN) {
            self.resting = None;
            let waiting = std::mem::take(&mut self.waiting);
            self.scout = Some(Scout::new(self.clone()));
            self.waiting = waiting;
        }
    }

    /// Whether nothing is left for the scout to do.
    fn is_scouted(&mut self) -> bool {
        self.scout_again();
        let Some(mut scout) = self.scout.take() else { return true };
        loop {
            let Some((t, image, _)) = self.next_image() else {
                if self.imu_ended || self.images_ended {
                    break;
                }
                self.scout = Some(scout);
                return false;
            };
            if scout.look(t, image) {
                break;
            }
        }
        let Scout { tracker, mut seen } = scout;
        let found = tracker.clock();
        seen.extend(tracker.waiting.into_iter().map(|(t, image)| (t, image, None)));
        if let Some((first, ..)) = seen.front().filter(|_| found.found.is_some()) {
            self.gyro.move_last(found.offset_s - self.clock().offset_s);
            self.clock.begin_at(found.offset_s, *first);
            seen.iter_mut().for_each(|(.., made)| *made = None);
        }
        if !tracker.clock.is_known()
            && let Some((last, ..)) = seen.back()
        {
            let last = self.on_imu_clock(*last);
            let rates = [last, last.plus_seconds(-RATE_S)].map(|t| self.rate_before(t));
            self.resting = rates[0]
                .zip(rates[1])
                .and_then(|(now, before)| ((now - before).norm() < 0.5 * BEGINS_TO_TURN).then_some(now));
        }
        if found.found.is_none() {
            (self.front_end, self.gyro, self.clock) = (tracker.front_end, tracker.gyro, tracker.clock);
        }
        self.again = seen;
        true
    }

    /// Follows points into an image that samples have reached.
    fn follow(&mut self, t: Stamp, image: &GrayImage) -> Fed {
        let on_imu_clock = self.on_imu_clock(t);
        let lines = self.line_turns(on_imu_clock);
        let turn = self.gyro.until(on_imu_clock);
        let turn = turn.map(|turn| turn_of_camera(&turn, &self.body_from_cam));
        let mut fed = self.front_end.feed_lines(image.view(), t, turn.as_ref(), lines);
        match &mut fed.frame {
            None => self.forget_before(on_imu_clock),
            Some(frame) => {
                frame.clock_s = self.clock().offset_s;
                self.look_at_clock(frame);
            }
        }
        fed
    }

    /// Follows points through the images that samples have reached until a frame is handed over, while `observer` looks on.
    pub fn next_frame(&mut self, observer: &mut dyn FrontEndObserver) -> Option<TrackFrame> {
        loop {
            if !self.is_scouted() {
                return None;
            }
            let (t, image, made) = self.next_image()?;
            observer.begin(t);
            let fed = made.unwrap_or_else(|| self.follow(t, &image));
            observer.end(&image, &fed);
            if fed.frame.is_some() {
                return fed.frame;
            }
        }
    }
}

/// A tracker that goes before, for the camera's clock alone, and the images that it has seen.
#[derive(Debug, Clone)]
struct Scout {
    tracker: Box<ImageTracker>,
    seen: VecDeque<Seen>,
}

impl Scout {
    /// With a tracker that has no scout.
    fn new(tracker: ImageTracker) -> Self {
        Self { tracker: Box::new(tracker), seen: VecDeque::new() }
    }

    /// Looks at an image that samples have reached; whether it has looked long enough.
    fn look(&mut self, t: Stamp, image: GrayImage) -> bool {
        self.tracker.waiting.push_back((t, image));
        while let Some((t, image, _)) = self.tracker.next_image() {
            let made = self.tracker.follow(t, &image);
            self.seen.push_back((t, image, Some(made)));
        }
        let lasts = |(first, ..): &Seen| t.seconds_since(*first) > SCOUTED_S;
        self.tracker.turns().is_known() || self.seen.front().is_some_and(lasts)
    }
}
