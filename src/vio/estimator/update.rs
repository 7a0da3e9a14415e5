//! What comes out for each frame.

use crate::components::Levels;
use crate::init::WaitReason;
use crate::state::NavState;
use dpn_core::Stamp;
use nalgebra::Matrix6;

pub use super::health::RestartReason;
use super::jump::BiasJump;

/// What the estimator is doing.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Phase {
    /// Waiting until the first states can be told, and what for.
    Initialising(WaitReason),
    /// Estimating.
    Tracking,
    /// Given up at this frame, for the reason said; the next frames initialise again.
    Restarted(RestartReason),
}

/// The outcome of one frame. A run keeps all of them, 200 bytes each: what is seldom there is apart.
#[derive(Debug, Clone, PartialEq)]
pub struct Update {
    /// The frame's stamp.
    pub t: Stamp,
    /// What the estimator is doing.
    pub phase: Phase,
    /// The newest state; `None` while there is none.
    pub state: Option<NavState>,
    /// Covariance of the newest pose (position, then rotation on the right), as believed; `None` where it was not asked for.
    pub covariance: Option<Box<Matrix6<f64>>>,
    /// Relative standard deviation of the scale of the path that the window's frames lie on, as believed; `None` where there is no state. Large also
    /// where the body hardly moves.
    pub scale_std: Option<f64>,
    /// Tracks that went on from earlier frames.
    pub tracked: u32,
    /// Landmarks with a depth.
    pub landmarks: u32,
    /// Tracks ended as outliers at this frame.
    pub outliers: u32,
    /// Linear systems solved.
    pub iterations: u32,
    /// Sum of squares in standard deviations of the inertial residual that left the window with this frame: position, rotation and
    /// velocity, 9 degrees of freedom.
    pub whitened: Option<f64>,
    /// By what the noise told is multiplied from this frame on; `None` where nothing is learned.
    pub levels: Option<Box<Levels>>,
    /// A jump of the biases that this frame showed.
    pub jump: Option<Box<BiasJump>>,
    /// Wall-clock time this frame took \[s\].
    pub seconds: f64,
}
