//! Whether samples and tracks can belong together, told before any estimator runs.
//!
//! * [`axes`]: the camera's rotation between frames against the gyro's: axes that are swapped or mirrored, a camera that is mounted otherwise than
//!   its calibration says, a gyro in degrees.
//! * `lag`: how far apart both make the same turns, beyond what the clock is looked for.
//! * `jitter`: how far single frames' stamps are off.
//! * `tracks`: whether ids stay with their points.

mod axes;
mod jitter;
mod lag;
mod tracks;
mod turn_map;

pub(crate) use axes::compared;
pub use axes::{Axes, AxesVerdict, axes};
pub use tracks::{TrackHealth, TrackMeter};
pub(crate) use turn_map::Turn;
