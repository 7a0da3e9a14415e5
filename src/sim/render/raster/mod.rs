//! From a world and a pose to a frame of light.

mod batch;
mod frame;
mod lens;
mod uncalibrated;
mod view;

pub(super) use frame::Frame;
pub(super) use lens::Lens;
pub use lens::NoLineOfSight;
pub(super) use uncalibrated::Uncalibrated;
