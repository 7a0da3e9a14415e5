//! A first look at the first images, for the camera's clock alone.
//!
//! Points are foreseen by the gyroscope's turns. With a camera that is late they are foreseen in wrong places and lost, and nothing can be built on those that
//! are left, also once the clock is found. So the first two seconds of images are kept until a tracker of their own has found it; then points are followed
//! through them anew. What comes out of a camera whose clock is right is the same as without.

use super::image_tracker::ImageTracker;
use dpn_core::{GrayImage, ImuSample, Stamp};
use std::collections::VecDeque;

/// Images are kept so long \[s\].
const LONGEST_S: f64 = 2.0;

/// The tracker that goes before, and the images that it has seen.
#[derive(Debug, Clone)]
pub(super) struct Scout {
    tracker: Box<ImageTracker>,
    seen: VecDeque<(Stamp, GrayImage)>,
}

impl Scout {
    /// With a tracker that has no scout.
    pub(super) fn new(tracker: ImageTracker) -> Self {
        Self { tracker: Box::new(tracker), seen: VecDeque::new() }
    }

    /// Takes a sample that was found to be good.
    pub(super) fn feed_imu(&mut self, sample: &ImuSample) {
        // A spike to it alone, which has not seen those that were passed over, is passed over.
        let _ = self.tracker.feed_imu(sample);
    }

    /// Says that no more samples come.
    pub(super) fn end_imu(&mut self) {
        self.tracker.end_imu();
    }

    /// Looks at an image that samples have reached; whether it has looked long enough.
    pub(super) fn look(&mut self, t: Stamp, image: GrayImage) -> bool {
        self.tracker
            .feed_image(image.view(), t)
            .expect("whose scout it is took it, and each is looked at before the next comes");
        while self.tracker.next_frame(&mut ()).is_some() {}
        self.seen.push_back((t, image));
        let (first, _) = self.seen.front().expect("one was just added");
        self.tracker.turns().is_settled()
            || self.tracker.clock().found.is_some()
            || t.seconds_since(*first) > LONGEST_S
    }

    /// What the camera's clock was found to be off by \[s\], and the images again.
    pub(super) fn finish(self) -> (Option<f64>, VecDeque<(Stamp, GrayImage)>) {
        let clock = self.tracker.clock();
        (clock.found.map(|_| clock.offset_s), self.seen)
    }
}
