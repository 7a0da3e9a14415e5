//! A recording walked once: samples and images in the order in which a run takes them, whoever runs on them.

use super::error::{ClosedLoopError, OfSequence};
use super::images::ImageStream;
use super::recording::Recording;
use super::tracking_log::TrackingLog;
use dpn_core::{GrayImage, ImuSample, Stamp};
use dpn_vio::clock::REACH_S;
use dpn_vio::estimator::FeedError;
use std::ops::Range;

/// What comes next.
#[derive(Debug)]
pub(super) enum Step<'a> {
    /// The sample at this place.
    Sample(usize),
    /// Nothing; no more samples come.
    SamplesEnd,
    /// An image, when all samples before it and the one that completes it have come.
    Image(Stamp, &'a GrayImage),
    /// Nothing; no more images come.
    ImagesEnd,
}

/// The samples that frames or images need, each once.
#[derive(Debug)]
pub(super) struct SampleWalk<'a> {
    samples: &'a [ImuSample],
    next: usize,
}

impl<'a> SampleWalk<'a> {
    /// Begins with the last sample that is not after `first`, where the interval before it begins.
    pub(super) fn new(samples: &'a [ImuSample], first: Stamp) -> Self {
        Self { samples, next: samples.partition_point(|s| s.t <= first).saturating_sub(1) }
    }

    /// For a camera whose clock may be off: begins as far before its first stamp as that may be.
    pub(super) fn of_camera(samples: &'a [ImuSample], first: Stamp) -> Self {
        Self::new(samples, first.plus_seconds(-REACH_S))
    }

    /// Places of the samples since the last call, up to the first at or after `t`, which completes what was taken at `t`.
    pub(super) fn until(&mut self, t: Stamp) -> Range<usize> {
        let completing = self.samples.partition_point(|s| s.t < t);
        let end = (completing + 1).clamp(self.next, self.samples.len());
        std::mem::replace(&mut self.next, end)..end
    }

    /// Whether none is left, and none reached `t`.
    fn ended_before(&self, t: Stamp) -> bool {
        self.next == self.samples.len() && self.samples.last().is_none_or(|last| last.t < t)
    }
}

/// Walks `recording`'s samples beside its `images`; `log` is told of those that cannot be read or are not taken.
///
/// # Errors
/// None of the first images can be read; what `take` does not take, but for a single image that it refuses.
pub(super) fn walk(
    recording: &Recording,
    images: ImageStream<'_>,
    log: &mut TrackingLog<'_>,
    mut take: impl FnMut(Step<'_>, &mut TrackingLog<'_>) -> Result<(), FeedError>,
) -> Result<(), ClosedLoopError> {
    let mut samples: Option<SampleWalk<'_>> = None;
    for (t, image) in images {
        let image = match image {
            Ok(image) => {
                log.came();
                image
            }
            Err(error) => {
                log.unreadable(t, error)?;
                continue;
            }
        };
        let samples = samples.get_or_insert_with(|| SampleWalk::of_camera(recording.imu.samples(), t));
        for place in samples.until(t) {
            take(Step::Sample(place), log).of_sequence(&recording.name)?;
        }
        if samples.ended_before(t) {
            take(Step::SamplesEnd, log).of_sequence(&recording.name)?;
        }
        match take(Step::Image(t, &image), log) {
            Err(error @ (FeedError::ImageSize { .. } | FeedError::ImageOutOfOrder { .. })) => {
                log.refused(t, &error);
            }
            taken => taken.of_sequence(&recording.name)?,
        }
    }
    take(Step::ImagesEnd, log).of_sequence(&recording.name)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_sample_comes_once_and_the_one_that_completes_a_frame_before_it() {
        let samples: Vec<ImuSample> = (0..10)
            .map(|i| ImuSample { t: Stamp::from_ns(10 * i), gyro: [0.0; 3], accel: [0.0; 3] })
            .collect();
        let at = Stamp::from_ns;
        let mut walk = SampleWalk::new(&samples, at(25));
        let taken: Vec<Range<usize>> = [25, 40, 41, 45, 90].map(|t| walk.until(at(t))).to_vec();
        assert_eq!(taken, [2..4, 4..5, 5..6, 6..6, 6..10]);
        assert!(!walk.ended_before(at(90)) && walk.ended_before(at(91)));
        assert_eq!(walk.until(at(200)), 10..10);
        // Before the first sample one is taken too: it says that those before are not there.
        assert_eq!(SampleWalk::new(&samples, at(-5)).until(at(-5)), 0..1);
        assert_eq!(SampleWalk::new(&samples, at(30)).until(at(30)), 3..4, "on a sample that alone is needed");
    }
}
