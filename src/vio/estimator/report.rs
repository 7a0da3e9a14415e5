//! What a whole run has to say of itself.

use super::feed_error::FeedError;
use super::jump::BiasJump;
use super::suspects::Suspect;
use super::update::{Phase, RestartReason, Update};
use crate::clock::{CameraClock, Readout};
use dpn_core::Stamp;
use dpn_core::trajectory::StampedPose;
use serde::Serialize;

/// Where a frame's time goes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Stage {
    /// Pre-integration, sightings, bookkeeping.
    Feed,
    /// Initialisation.
    Initialise,
    /// The solver.
    Solve,
    /// Outliers.
    Reject,
    /// Sliding and marginalisation.
    Slide,
}

impl Stage {
    /// All of them, in the order of a frame.
    pub const ALL: [Self; 5] = [Self::Feed, Self::Initialise, Self::Solve, Self::Reject, Self::Slide];
}

/// Totals over a run.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct RunReport {
    /// Frames worked off.
    pub frames: usize,
    /// Frames with a pose.
    pub poses: usize,
    /// Frames before the first sample, which nothing could be done with.
    pub skipped: usize,
    /// Samples passed over because no sensor reads as much.
    pub spikes: usize,
    /// What was said of the first of them.
    #[serde(skip)]
    pub first_spike: Option<FeedError>,
    /// Stamp of the first frame.
    pub first: Option<Stamp>,
    /// Stamp of the first pose.
    pub initialised: Option<Stamp>,
    /// The pose of the first start's oldest frame, by definition without error in position and heading: what covariances are about.
    #[serde(skip)]
    pub anchor: Option<StampedPose>,
    /// Frames since the first pose, those alone that samples reach.
    pub frames_since: usize,
    /// Starts after the first, with their reasons.
    pub restarts: Vec<(Stamp, RestartReason)>,
    /// Jumps of the biases that were found.
    pub jumps: Vec<BiasJump>,
    /// How far the lens was found to be off its calibration, root mean square over the points last seen, both axes \[px\]; `None` where that is not learned, or not yet.
    pub lens_px: Option<f64>,
    /// The camera's clock.
    pub clock: CameraClock,
    /// How long an image's lines take to be read out, where that was found.
    pub readout: Option<Readout>,
    /// Linear systems solved.
    pub iterations: usize,
    /// Tracks ended as outliers.
    pub outliers: usize,
    /// Sum of squares of whitened inertial residuals, and their degrees of freedom.
    pub whitened: (f64, usize),
    /// Sum over the poses of the accelerometer's bias along the vertical \[m/s^2\].
    pub vertical_bias: f64,
    /// What of the calibration residuals point at, the surest; `None` where nothing is.
    pub suspect: Option<Suspect>,
    /// Wall-clock seconds by [`Stage`].
    pub seconds: [f64; 5],
}

impl RunReport {
    /// Adds what the stages of [`Stage::ALL`] took \[s\].
    pub(crate) fn add_seconds(&mut self, seconds: &[f64; 5]) {
        self.seconds.iter_mut().zip(seconds).for_each(|(total, seconds)| *total += seconds);
    }

    /// Adds one update.
    pub fn add(&mut self, update: &Update) {
        self.frames += 1;
        self.first.get_or_insert(update.t);
        if let Some(state) = &update.state {
            self.poses += 1;
            self.vertical_bias += (state.world_from_body.rotation * state.bias.accel).z;
            self.initialised.get_or_insert(update.t);
        }
        if self.initialised.is_some() {
            self.frames_since += 1;
        }
        if let Phase::Restarted(reason) = update.phase {
            self.restarts.push((update.t, reason));
        }
        self.jumps.extend(update.jump.as_deref());
        self.iterations += update.iterations as usize;
        self.outliers += update.outliers as usize;
        if let Some(squares) = update.whitened {
            self.whitened.0 += squares;
            self.whitened.1 += 9;
        }
    }

    /// Mean square of the whitened inertial residual per degree of freedom: 1 where the noise told is the noise there is.
    pub fn whitened_mean(&self) -> Option<f64> {
        (self.whitened.1 > 0).then(|| self.whitened.0 / self.whitened.1 as f64)
    }

    /// Mean of the accelerometer's bias along the vertical \[m/s^2\]: what it reads of gravity that is none.
    pub fn vertical_bias_mean(&self) -> Option<f64> {
        (self.poses > 0).then(|| self.vertical_bias / self.poses as f64)
    }

    /// Share of the frames since initialisation that have a pose.
    pub fn completion(&self) -> Option<f64> {
        (self.frames_since > 0).then(|| self.poses as f64 / self.frames_since as f64)
    }
}
