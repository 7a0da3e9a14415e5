//! The loop over frames.

use super::config::EstimatorConfig;
use super::imu_buffer::{ImuBuffer, Interval};
use super::report::{RunReport, Stage};
use super::update::{Phase, RestartReason, Update};
use crate::factors::reprojection::Sighting;
use crate::preint::{NoisySample, Preintegration};
use crate::state::{ImuBias, NavState};
use crate::window::{Leaving, Seen, Window};
use dpn_core::camera::PinholeRadtan;
use dpn_core::{Stamp, TrackFrame};
use nalgebra::Isometry3;
use std::collections::VecDeque;
use std::time::Instant;
use thiserror::Error;

/// Input that cannot be taken.
#[derive(Debug, Error, Clone, Copy, PartialEq, Eq)]
pub enum FeedError {
    /// A sample that is not later than the last.
    #[error("an IMU sample at {t} after one at {last}; samples must come in increasing time")]
    SampleOutOfOrder {
        /// Its stamp.
        t: Stamp,
        /// The newest before it.
        last: Stamp,
    },
    /// A frame that is not later than the last.
    #[error("a frame at {t} after one at {last}; frames must come in increasing time")]
    FrameOutOfOrder {
        /// Its stamp.
        t: Stamp,
        /// The newest before it.
        last: Stamp,
    },
    /// A sample that is not a number.
    #[error("an IMU sample at {t} holds a value that is not finite")]
    NotFinite {
        /// Its stamp.
        t: Stamp,
    },
}

/// One frame of a start: its stamp, its state, the samples since the frame before, its tracks.
#[derive(Debug, Clone)]
pub struct StartFrame {
    /// When.
    pub t: Stamp,
    /// What is believed of the body.
    pub state: NavState,
    /// Samples since the frame before; `None` for the first.
    pub preint: Option<Preintegration>,
    /// What was seen.
    pub seen: Vec<Seen>,
}

/// A monocular visual-inertial odometry.
#[derive(Debug, Clone)]
pub struct Estimator {
    config: EstimatorConfig,
    camera: PinholeRadtan,
    imu: ImuBuffer,
    frames: VecDeque<TrackFrame>,
    newest_frame: Option<Stamp>,
    window: Window,
    running: bool,
    starved_since: Option<Stamp>,
    report: RunReport,
}

impl Estimator {
    /// With a camera at `body_from_cam` on the IMU.
    pub fn new(config: EstimatorConfig, camera: PinholeRadtan, body_from_cam: Isometry3<f64>) -> Self {
        Self {
            config,
            camera,
            imu: ImuBuffer::default(),
            frames: VecDeque::new(),
            newest_frame: None,
            window: Window::new(config.window, body_from_cam),
            running: false,
            starved_since: None,
            report: RunReport::default(),
        }
    }

    /// Takes a sample with the noise in force.
    ///
    /// # Errors
    /// A sample that is not later than the last, or not finite; it is not taken.
    pub fn feed_imu(&mut self, sample: NoisySample) -> Result<(), FeedError> {
        let t = sample.sample.t;
        if !sample.sample.is_finite() {
            return Err(FeedError::NotFinite { t });
        }
        if let Some(last) = self.imu.newest().filter(|last| t <= *last) {
            return Err(FeedError::SampleOutOfOrder { t, last });
        }
        self.imu.push(sample);
        Ok(())
    }

    /// Takes a frame's tracks; it is worked off when samples reach its stamp.
    ///
    /// # Errors
    /// A frame that is not later than the last; it is not taken.
    pub fn feed_frame(&mut self, frame: TrackFrame) -> Result<(), FeedError> {
        if let Some(last) = self.newest_frame.filter(|last| frame.t <= *last) {
            return Err(FeedError::FrameOutOfOrder { t: frame.t, last });
        }
        self.newest_frame = Some(frame.t);
        self.frames.push_back(frame);
        Ok(())
    }

    /// Works off the next frame whose samples are all there.
    pub fn next_update(&mut self) -> Option<Update> {
        let (oldest, newest) = (self.imu.oldest()?, self.imu.newest()?);
        while self.frames.front().is_some_and(|f| f.t < oldest) {
            self.frames.pop_front();
            self.report.skipped += 1;
        }
        if self.frames.front()?.t > newest {
            return None;
        }
        let frame = self.frames.pop_front()?;
        let began = Instant::now();
        let mut update = self.work_off(&frame);
        update.seconds = began.elapsed().as_secs_f64();
        self.report.add(&update);
        Some(update)
    }

    /// Totals so far.
    pub fn report(&self) -> &RunReport {
        &self.report
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
                let sighting = Sighting::new(&self.camera, &track.px, self.config.window.pixel_std)?;
                Some(Seen { id: track.id, sighting })
            })
            .collect()
    }

    /// Begins from known states instead of initialising: the next frame fed goes on after the last of them.
    pub fn start(&mut self, frames: Vec<StartFrame>) {
        self.window = Window::new(self.config.window, *self.window.body_from_cam());
        for frame in frames {
            self.window.add_frame(frame.t, frame.state, frame.preint, &frame.seen);
        }
        self.window.anchor(0.05, f64::INFINITY, 0.5, 0.1);
        self.window.triangulate();
        for _ in 0..3 {
            self.window.optimise();
            self.window.reject_outliers();
            self.window.triangulate();
        }
        self.running = true;
    }

    fn work_off(&mut self, frame: &TrackFrame) -> Update {
        let clock = Instant::now();
        let interval = self.imu.cut(frame.t);
        let seen = self.sightings(frame);
        let mut update = Update {
            t: frame.t,
            phase: Phase::Initialising,
            state: None,
            covariance: None,
            tracked: 0,
            landmarks: 0,
            outliers: 0,
            iterations: 0,
            whitened: None,
            seconds: 0.0,
        };
        self.report.seconds[Stage::Feed as usize] += clock.elapsed().as_secs_f64();
        if !self.running {
            return update;
        }
        match self.track(frame.t, &interval, &seen, &mut update) {
            Ok(()) => update.phase = Phase::Tracking,
            Err(reason) => {
                update.phase = Phase::Restarted(reason);
                self.running = false;
            }
        }
        update
    }

    fn track(
        &mut self,
        t: Stamp,
        interval: &Interval,
        seen: &[Seen],
        update: &mut Update,
    ) -> Result<(), RestartReason> {
        let mut clock = Clock { at: Instant::now(), seconds: [0.0; 5] };
        if interval.longest_step > self.config.health.max_imu_gap {
            return Err(RestartReason::ImuGap { seconds: interval.longest_step });
        }
        let Some(last) = self.window.newest() else { return Err(RestartReason::NotFinite) };
        let last = last.state;
        let preint = integrate(&self.config, &last.bias, interval);
        let predicted = preint.as_ref().map_or(last, |p| p.predict(&last));
        update.tracked = self.window.add_frame(t, predicted, preint, seen);
        self.window.triangulate();
        clock.lap(Stage::Feed);
        update.iterations = self.window.optimise().iterations;
        clock.lap(Stage::Solve);
        update.outliers = self.window.reject_outliers();
        clock.lap(Stage::Reject);
        let state = self.window.newest().map_or(predicted, |f| f.state);
        if let Some(reason) = self.config.health.judge(&state, &predicted) {
            return Err(reason);
        }
        if update.tracked >= self.config.health.min_tracks {
            self.starved_since = None;
        } else {
            let since = *self.starved_since.get_or_insert(t);
            let seconds = t.seconds_since(since);
            if seconds > self.config.health.max_starved {
                return Err(RestartReason::Starved { seconds });
            }
        }
        update.state = Some(state);
        update.landmarks = self.window.landmarks().iter().filter(|l| l.inverse_depth.is_some()).count();
        if self.window.is_full() {
            let leaving: Leaving = self.window.leaving(self.camera.focal().mean());
            update.whitened = self.window.slide(leaving);
        }
        clock.lap(Stage::Slide);
        for (total, seconds) in self.report.seconds.iter_mut().zip(clock.seconds) {
            *total += seconds;
        }
        Ok(())
    }
}

struct Clock {
    at: Instant,
    seconds: [f64; 5],
}

impl Clock {
    fn lap(&mut self, stage: Stage) {
        let now = Instant::now();
        self.seconds[stage as usize] += (now - self.at).as_secs_f64();
        self.at = now;
    }
}

/// The samples between two frames as one measurement; `None` where there are fewer than two.
fn integrate(config: &EstimatorConfig, bias: &ImuBias, interval: &Interval) -> Option<Preintegration> {
    let (first, rest) = interval.samples.split_first()?;
    if rest.is_empty() {
        return None;
    }
    let mut preint = Preintegration::new(config.imu, *bias, *first);
    for sample in rest {
        preint.push(*sample);
    }
    Some(preint)
}
