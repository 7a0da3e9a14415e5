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
    /// Where lines are read out one after the other, the time from the first's exposure to the last's that was taken into account: `px` are where a camera
    /// of the stamp would have seen the points; 0 where all lines are taken at once, or nobody knows \[s\].
    pub readout_s: f64,
    /// What was added to the camera's stamps when points were followed into this image; 0 where its clock is right, or nobody knows \[s\].
    pub clock_s: f64,
}

impl TrackFrame {
    /// Of an image whose lines are taken at once.
    pub fn new(t: Stamp, tracks: Vec<Track>) -> Self {
        Self { t, tracks, readout_s: 0.0, clock_s: 0.0 }
    }

    /// The points that an earlier frame saw too, in this frame's order: where they were \[px\] and where they are.
    pub fn shared(&self, earlier: &Self) -> Vec<(Vector2<f64>, Vector2<f64>)> {
        let mut before: Vec<_> = earlier.tracks.iter().map(|track| (track.id, track.px)).collect();
        before.sort_by_key(|(id, _)| *id);
        let both = self.tracks.iter().filter_map(|track| {
            let at = before.binary_search_by_key(&track.id, |(id, _)| *id).ok()?;
            Some((before[at].1, track.px))
        });
        both.collect()
    }
}
