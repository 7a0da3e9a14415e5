//! Camera tracks: where a tracker saw the same points in frame after frame. The one form in which the window gets its images,
//! whether from a file, a simulation or the front-end.

use crate::time::Stamp;
use nalgebra::Vector2;

/// One tracked point in one frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Track {
    /// The same number in every frame that sees the same point; never used again for another one.
    pub id: u64,
    /// Where, in distorted pixels.
    pub px: Vector2<f64>,
}

/// What the tracker saw in one frame.
#[derive(Debug, Clone, PartialEq)]
pub struct TrackFrame {
    /// When the image was taken, in the IMU's clock.
    pub t: Stamp,
    /// Each id at most once.
    pub tracks: Vec<Track>,
}
