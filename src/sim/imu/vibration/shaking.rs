//! What the parts of a flight's vibration have in common.

use super::config::{AxisVibration, VibrationConfig};
use dpn_core::random::Stream;

/// What every part of a flight's vibration follows.
pub(super) struct Shaking<'a> {
    pub(super) config: &'a VibrationConfig,
    /// Accelerometer x, y, z, gyroscope x, y, z.
    pub(super) axes: &'a [AxisVibration; 6],
    /// Motors relative to hover, per sample.
    pub(super) speed: &'a [f64],
    /// A factor per sample.
    pub(super) loudness: &'a [f64],
    /// Time between samples \[s\].
    pub(super) dt: f64,
    pub(super) stream: &'a Stream,
}
