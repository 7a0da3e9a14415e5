//! Initialisation: the first states of a flight, from tracks and IMU alone, or the reason why not yet.
//!
//! 1. [`rest`](self) is watched for; while it lasts the direction of gravity and the gyro's bias are read off and nothing is tried. A
//!    rest stays in the frames: its velocity is zero and its pose one, which makes the scale of what follows certain sooner.
//! 2. The gyro's bias from the tracks' directions, before any structure (`gyro_bias`).
//! 3. Structure from motion up to scale with the gyro's rotations (`structure`): the pair with most parallax after compensating
//!    rotation, translation by consensus, resection, bundle adjustment. Too little parallax ends here.
//! 4. Velocities, gravity, scale and accelerometer bias, linear (`align`).
//! 5. All of it together in one least squares (`refine`), with the noise of tracks and IMU re-estimated from their residuals. The scale's
//!    deviation from its own information decides whether the answer is given or waited for.
//!
//! Structure and refinement are adjusted in windows ([`crate::window`]), the visual one without inertial measurements (`adjustment`).
//!
//! Frames: world z up, gravity `(0, 0, -9.81)`, the first frame at the origin with the camera's optical axis at yaw 0. Not here: the
//! window that goes on from the answer.

mod adjustment;
mod align;
mod attempt;
mod buffer;
mod certainty;
mod config;
mod frame;
mod gyro_bias;
mod initialiser;
mod outcome;
mod refine;
mod rest;
mod robust;
mod structure;
#[cfg(test)]
pub(crate) mod tests;
mod translation;

pub use config::InitConfig;
pub use frame::InitFrame;
pub use initialiser::Initialiser;
pub use outcome::{Fit, Implausible, InitOutcome, Initialised, InitialisedFrame, WaitReason};
pub(crate) use rest::RestWatch;
