//! What the initialisation answers: states of the frames, or what it is waiting for.

use crate::state::{ImuBias, NavState};
use dpn_core::named;
use dpn_core::time::Stamp;
use thiserror::Error;

/// The answer to a frame.
#[derive(Debug, Clone, PartialEq)]
pub enum InitOutcome {
    /// States and structure; the initialiser starts anew with the next frame.
    Ready(Box<Initialised>),
    /// Not yet, and why.
    Wait(WaitReason),
}

/// A frame that has got a state.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct InitialisedFrame {
    /// The frame's stamp.
    pub t: Stamp,
    /// Its state.
    pub state: NavState,
}

/// A first estimate.
///
/// # Units and frames
/// The world's z axis points up; the first frame is at its origin with yaw 0 (the body's x axis lies in the plane of x and z).
#[derive(Debug, Clone, PartialEq)]
pub struct Initialised {
    /// The frames in the estimate by increasing time, the newest frame last: those between them were only counted on by the IMU.
    pub frames: Vec<InitialisedFrame>,
    /// The bias in the first frame; over so few seconds it walks far less than it is uncertain.
    pub bias: ImuBias,
    /// Relative standard deviation of the scale, from the estimate's covariance.
    pub scale_std: f64,
    /// Standard deviation of the direction of gravity in the newest frame \[rad\].
    pub gravity_std: f64,
    /// Whether the frames begin at rest.
    pub from_rest: bool,
    /// How good the data turned out to be.
    pub fit: Fit,
}

/// Residuals of an estimate over what was expected of them.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Fit {
    /// Deviation of a track in one direction \[px\], from its residuals.
    pub track_std_px: f64,
    /// Deviation of the integrated gyro's residuals over the one its noise predicts.
    pub gyro_factor: f64,
    /// Deviation of the integrated accelerometer's residuals over the one its noise predicts.
    pub accel_factor: f64,
}

/// What the initialisation is waiting for: the measured value and the threshold beside it.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
pub enum WaitReason {
    /// Too few frames, or a span too short.
    #[error("{frames} frames of {needed}")]
    TooFewFrames {
        /// Frames held.
        frames: usize,
        /// Frames needed.
        needed: usize,
    },
    /// Frames share too few tracks.
    #[error("{shared} shared tracks of {needed}")]
    TooFewTracks {
        /// Shared by the pair of frames that matters.
        shared: usize,
        /// Needed.
        needed: usize,
    },
    /// Everything stands still. Of the gyro's bias, [`Initialiser::resting_gyro_bias`](super::Initialiser::resting_gyro_bias) knows.
    #[error("at rest for {seconds:.1} s")]
    AtRest {
        /// How long already \[s\].
        seconds: f64,
    },
    /// The camera turned, or moved too little for the distance of what it sees.
    #[error("parallax {parallax_px:.1} px of {needed_px:.1} px, after turning by {:.0} deg", rotation.to_degrees())]
    TooLittleParallax {
        /// Largest median parallax of a pair of frames after compensating rotation \[px\].
        parallax_px: f64,
        /// Needed \[px\].
        needed_px: f64,
        /// How far the camera turned over these frames \[rad\].
        rotation: f64,
    },
    /// No consistent geometry: too few tracks agree with one motion.
    #[error("no consistent structure: {consistent} agree, {needed} needed")]
    NoStructure {
        /// Tracks or frames that agree.
        consistent: usize,
        /// Needed.
        needed: usize,
    },
    /// The scale is not certain enough.
    #[error("scale uncertain by {:.1} %, {:.1} % allowed", 100.0 * relative_std, 100.0 * allowed)]
    ScaleUncertain {
        /// Relative standard deviation, from the estimate's covariance.
        relative_std: f64,
        /// Allowed.
        allowed: f64,
    },
    /// The estimate contradicts what an IMU or tracks can be.
    #[error("implausible {what}: {value:.3}, {allowed:.3} allowed")]
    Implausible {
        /// Which quantity.
        what: Implausible,
        /// Its value, in the unit of `what`.
        value: f64,
        /// Allowed.
        allowed: f64,
    },
}

named!(
    /// A quantity that speaks against an estimate.
    pub enum Implausible {
        /// Size of the accelerometer's bias \[m/s^2\].
        AccelBias = "accelerometer bias [m/s^2]",
        /// Size of the gyro's bias \[rad/s\].
        GyroBias = "gyro bias [rad/s]",
        /// Deviation of the tracks' residuals \[px\].
        TrackResidual = "track residual [px]",
        /// Deviation of the inertial residuals over the expected: axes, extrinsics or clocks may be wrong.
        InertialResidual = "inertial residual over its expectation",
    }
);

impl WaitReason {
    /// A short name, for counting.
    pub fn name(&self) -> &'static str {
        match self {
            Self::TooFewFrames { .. } => "too-few-frames",
            Self::TooFewTracks { .. } => "too-few-tracks",
            Self::AtRest { .. } => "at-rest",
            Self::TooLittleParallax { .. } => "too-little-parallax",
            Self::NoStructure { .. } => "no-structure",
            Self::ScaleUncertain { .. } => "scale-uncertain",
            Self::Implausible { what: Implausible::AccelBias, .. } => "implausible-accel-bias",
            Self::Implausible { what: Implausible::GyroBias, .. } => "implausible-gyro-bias",
            Self::Implausible { what: Implausible::TrackResidual, .. } => "implausible-track-residual",
            Self::Implausible { what: Implausible::InertialResidual, .. } => "implausible-inertial-residual",
        }
    }
}
