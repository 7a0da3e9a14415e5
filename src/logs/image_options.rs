//! What is wanted of a log with images.

use crate::LogOptions;
use dpn_core::Stamp;
use std::ops::ControlFlow;

/// What the caller knows about a log with images.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct ImageLogOptions {
    /// About its IMU.
    pub imu: LogOptions,
    /// The topic of the images; without it, the only one.
    pub image_topic: Option<String>,
    /// Whether a list of images may be longer or shorter than the folder beside it.
    pub skip_missing: bool,
}

/// The part that is wanted, in seconds after the first image.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ImageSpan {
    /// Where it begins.
    pub from_s: f64,
    /// Where it ends; without it at the last image.
    pub to_s: Option<f64>,
}

impl ImageSpan {
    /// All images.
    pub const ALL: Self = Self { from_s: 0.0, to_s: None };
    /// So much outside is within, for seconds are rounded when they are written.
    const ROUNDED_S: f64 = 1e-6;

    /// Whether an image at `t` comes before the part, or after it, which nothing behind can mend.
    pub(crate) fn misses(&self, first: Stamp, t: Stamp) -> Option<ControlFlow<()>> {
        let after = self.to_s.is_some_and(|to_s| t > first.plus_seconds(to_s + Self::ROUNDED_S));
        let before = t < first.plus_seconds(self.from_s - Self::ROUNDED_S);
        if after { Some(ControlFlow::Break(())) } else { before.then_some(ControlFlow::Continue(())) }
    }
}
