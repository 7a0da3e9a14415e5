//! The levels, and how what leaves the window moves them.
//!
//! The unknowns are logarithms of variances. Information is forgotten at the rate `1/memory` and what is told comes back at the same rate with
//! the weight of half an observation, so that a component of which nothing is heard returns to what was told:
//! ```text
//! I <- f I + (1 - f) I_0 + I_new,   x <- x + I^-1 (g_new + I_new (x_new - x) + (1 - f) I_0 (x_0 - x)),   f = exp(-dt/memory)
//! ```

use super::config::ComponentsConfig;
use super::inertial::InertialScore;
use super::pixels::PixelScore;
use crate::preint::{ACCEL_WALK, COMPONENTS, GYRO_WALK, NoiseLevels, Preintegration, PreintegrationConfig};
use crate::window::{Frame, Window};
use dpn_core::{SampleRate, Sensor, Stamp};
use nalgebra::{SMatrix, SVector, Vector3};

/// What is told weighs so much in the long run: half an observation of a variance has the curvature of a quarter.
const TOLD_INFORMATION: f64 = 0.25;
/// A step of a logarithm that one frame may cause: a residual beyond all expectation is as often a fault as noise.
const MAX_STEP: f64 = 1.0;
/// The newest frames are not yet known well enough for the end of a span.
const YOUNG: usize = 3;
/// The same of the pixels', of which every frame says so much that smaller steps are quick.
const MAX_PIXEL_STEP: f64 = 0.2;
/// No level goes beyond this many times what was told, up or down; a walk's, beyond so many times its floor.
const WIDEST: f64 = 100.0;
/// Pixels are within this factor of what was told.
const WIDEST_PIXEL: f64 = 4.0;
/// Levels nearer than this to those of an interval, as logarithms of variances, are not worth integrating anew.
const WORTHWHILE: f64 = 0.2;

/// Levels in force: factors on the deviations told.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Levels {
    /// Of the inertial noise and its walks.
    pub inertial: NoiseLevels,
    /// Of the pixels.
    pub pixel: f64,
    /// Deviations of the logarithms of the inertial factors by all that was heard of them, were they constant; 1 and more where next to nothing was.
    pub unsure: [f64; COMPONENTS],
}

/// A logarithm no farther than `widest` from what was told, and not below its floor.
fn held(x: f64, floor: f64, widest: f64) -> f64 {
    x.min(widest).max(floor.max(-widest))
}

/// Learns them.
#[derive(Debug, Clone)]
pub(crate) struct Learner {
    config: ComponentsConfig,
    told: PreintegrationConfig,
    /// Deviation of a pixel that was told.
    told_pixel: f64,
    /// Logarithms of the variances' factors.
    x: SVector<f64, COMPONENTS>,
    information: SMatrix<f64, COMPONENTS, COMPONENTS>,
    /// All information that residuals had, nothing forgotten.
    heard: SMatrix<f64, COMPONENTS, COMPONENTS>,
    pixel: f64,
    pixel_information: f64,
    last: Option<Stamp>,
    /// Up to where inertial residuals have been read.
    read_until: Option<Stamp>,
}

impl Learner {
    /// Deviations told: `told`'s of the IMU, and of a pixel.
    pub(crate) fn new(config: ComponentsConfig, told: PreintegrationConfig, told_pixel: f64) -> Self {
        let mut learner = Self {
            config,
            told,
            told_pixel,
            x: SVector::zeros(),
            information: SMatrix::identity() * (0.5 * config.prior),
            heard: SMatrix::zeros(),
            pixel: 0.0,
            pixel_information: 0.5 * config.prior,
            last: None,
            read_until: None,
        };
        learner.x = learner.start();
        learner
    }

    /// What is told, walks raised to their floors.
    fn start(&self) -> SVector<f64, COMPONENTS> {
        let mut x = SVector::zeros();
        for (k, floor) in self.walk_floors() {
            x[k] = f64::max(0.0, floor);
        }
        x
    }

    fn walk_floors(&self) -> [(usize, f64); 2] {
        let accel = self.config.accel_walk_floor.get() / self.told.accel_bias_walk.get();
        let gyro = self.config.gyro_walk_floor.get() / self.told.gyro_bias_walk.get();
        [(ACCEL_WALK, 2.0 * accel.ln()), (GYRO_WALK, 2.0 * gyro.ln())]
    }

    /// The levels in force.
    pub(crate) fn levels(&self) -> Levels {
        let inertial = NoiseLevels(std::array::from_fn(|k| (0.5 * self.x[k]).exp()));
        // With half an observation beside it there is an inverse.
        let known = self.heard + SMatrix::identity() * TOLD_INFORMATION;
        let covariance = known.cholesky().map(|factor| factor.inverse());
        let unsure = std::array::from_fn(|k| covariance.map_or(1.0, |c| 0.5 * c[(k, k)].sqrt()));
        Levels { inertial, pixel: (0.5 * self.pixel).exp(), unsure }
    }

    /// Levels stay through a new start; how sure they are does not.
    pub(crate) fn restart(&mut self) {
        self.information = SMatrix::identity() * (0.5 * self.config.prior);
        self.pixel_information = 0.5 * self.config.prior;
        self.last = None;
        self.read_until = None;
    }

    /// Takes what a first start's residuals were over what was told as the levels to begin with, of the accelerometer and of the gyro. Levels that have
    /// been learned stay.
    pub(crate) fn begin_at(&mut self, accel: f64, gyro: f64) {
        if self.read_until.is_some() {
            return;
        }
        for (first, factor) in [(0, accel), (3, gyro)] {
            for k in first..first + 3 {
                self.x[k] = 2.0 * factor.ln();
            }
        }
    }

    /// Reads what is about to leave the window with its oldest frame.
    pub(crate) fn read(&mut self, window: &mut Window) {
        let [first, second, ..] = window.frames() else { return };
        let read_before = self.read_until.is_some_and(|end| first.t < end);
        let dt = self.last.map_or(0.0, |last| second.t.seconds_since(last));
        self.last = Some(second.t);
        let kept = (-dt / self.config.memory_s).exp();
        if self.config.pixels {
            let floor =
                if window.followed { self.config.followed_pixel_floor } else { self.config.pixel_floor };
            self.take_pixels(&window.oldest_pixel_score(), kept, floor);
        }
        if read_before || !window.factor_information() {
            return;
        }
        let first = &window.frames()[0];
        let far_enough = |frame: &Frame| frame.t.seconds_since(first.t) >= self.config.span_s;
        let newest = window.frames().len() - 1;
        let last = window
            .frames()
            .iter()
            .position(far_enough)
            .unwrap_or(newest)
            .clamp(1, newest.saturating_sub(YOUNG).max(1));
        let end = window.frames()[last].t;
        let since = self.read_until.map_or(0.0, |before| end.seconds_since(before));
        let kept = (-since / self.config.memory_s).exp();
        self.read_until = Some(end);
        for k in 1..=last {
            if let Some(change) = window.known_jump(k) {
                self.take_jump(&change, window.frames()[k].t.seconds_since(window.frames()[k - 1].t));
            }
        }
        if let Some(score) = window.inertial_score(last) {
            self.take_inertial(&score, kept);
            if let Some(preint) = &window.frames()[1].preint {
                self.hold_within(preint);
            }
        }
    }

    fn take_inertial(&mut self, score: &InertialScore, kept: f64) {
        let back = (1.0 - kept) * TOLD_INFORMATION;
        self.information = self.information * kept + SMatrix::identity() * back + score.information;
        let at = SVector::<f64, COMPONENTS>::from_fn(|k, _| 2.0 * score.at.0[k].ln());
        let gradient = score.gradient + score.information * (at - self.x) + (self.start() - self.x) * back;
        // Positive definite by the prior's share; numbers that are none move nothing.
        if let Some(step) = self.information.cholesky().map(|factor| factor.solve(&gradient))
            && step.iter().all(|d| d.is_finite())
        {
            self.heard += score.information;
            self.x += step.map(|d| d.clamp(-MAX_STEP, MAX_STEP));
        }
    }

    /// Reads a jump of the biases, found over `seconds`, as what it is: a draw of their walks. A sensor of which nothing is told did not jump.
    fn take_jump(&mut self, change: &[Option<Vector3<f64>>; 2], seconds: f64) {
        let walks =
            [(ACCEL_WALK, self.told.accel_bias_walk.get()), (GYRO_WALK, self.told.gyro_bias_walk.get())];
        for ((k, told), change) in walks.into_iter().zip(change) {
            let Some(change) = change else { continue };
            let variance = told * told * self.x[k].exp() * seconds;
            self.information[(k, k)] += 1.5;
            self.heard[(k, k)] += 1.5;
            let step = 0.5 * (change.norm_squared() / variance - 3.0) / self.information[(k, k)];
            if step.is_finite() {
                self.x[k] += step.clamp(-MAX_STEP, MAX_STEP);
            }
        }
    }

    /// Levels between the data sheet and what is believed of no sensor.
    fn hold_within(&mut self, preint: &Preintegration) {
        let samples = preint.samples();
        let period = preint.duration() / (samples.len() - 1).max(1) as f64;
        let Some(rate) = SampleRate::from_hz(1.0 / period) else { return };
        let widest = 2.0 * WIDEST.ln();
        let floors = [
            (Sensor::Accel, self.config.accel_floor.to_sample_std(rate).get()),
            (Sensor::Gyro, self.config.gyro_floor.to_sample_std(rate).get()),
        ];
        for (first, (sensor, floor)) in [0, 3].into_iter().zip(floors) {
            for axis in 0..3 {
                let squares: f64 = samples.iter().map(|s| s.noise.of(sensor)[axis].powi(2)).sum();
                let told = (squares / samples.len() as f64).sqrt();
                let x = &mut self.x[first + axis];
                *x = held(*x, 2.0 * (floor / told).ln(), widest);
            }
        }
        for (k, floor) in self.walk_floors() {
            self.x[k] = self.x[k].min(floor + widest).max(floor);
        }
    }

    /// `least` deviation of a pixel.
    fn take_pixels(&mut self, score: &PixelScore, kept: f64, least: f64) {
        let back = (1.0 - kept) * TOLD_INFORMATION;
        self.pixel_information = kept * self.pixel_information + back + 0.5 * score.redundancy;
        let gradient = 0.5 * (score.squares - score.redundancy) - back * self.pixel;
        let step = gradient / self.pixel_information;
        if step.is_finite() {
            let widest = 2.0 * WIDEST_PIXEL.ln();
            let floor = 2.0 * (least / self.told_pixel).ln();
            self.pixel = held(self.pixel + step.clamp(-MAX_PIXEL_STEP, MAX_PIXEL_STEP), floor, widest);
        }
    }

    /// Weighs what is in the window by the present levels, where those in force differ enough.
    pub(crate) fn apply(&self, window: &mut Window) {
        let Levels { inertial, pixel, .. } = self.levels();
        for preint in window.frames.iter_mut().filter_map(|frame| frame.preint.as_mut()) {
            let differ = |(now, then): (&f64, &f64)| 2.0 * (now / then).ln().abs() > WORTHWHILE;
            if inertial.0.iter().zip(&preint.levels().0).any(differ) {
                preint.set_levels(inertial);
            }
        }
        let factor = pixel * self.told_pixel / window.config.pixel_std;
        if 2.0 * factor.ln().abs() > 0.25 * WORTHWHILE {
            window.rescale_pixels(factor);
        }
    }
}
