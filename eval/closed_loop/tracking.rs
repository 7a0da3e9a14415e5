//! Tracks of a recording: given, made, or followed through its images by the estimator's own tracker, and what became of the images.

use super::error::ClosedLoopError;
use super::image_report::{ImageReport, PassedOver};
use super::images::ImageStream;
use super::recording::{Recording, Span};
use super::tally::Tally;
use super::walk::{Step, walk};
use dpn_core::{GrayImage, Stamp, TrackFrame};
use dpn_io::IoError;
use dpn_vio::estimator::{FeedError, FrontEndObserver, ImageTracker};
use dpn_vio::frontend::{Fed, FrontEndConfig};

/// When none of so many first images can be read, no later one is waited for.
const FIRST: usize = 10;

/// Tracks of a recording.
#[derive(Debug, Clone)]
pub struct TrackedSequence {
    /// Frame by frame.
    pub frames: Vec<TrackFrame>,
    /// The part of them that is run; all, where images outside were left out before.
    pub span: Span,
    /// What the front-end made of the images; none where tracks came without any.
    pub images: Option<ImageReport>,
}

impl TrackedSequence {
    /// The frames that are run.
    pub fn run(&self) -> &[TrackFrame] {
        self.span.of(&self.frames, |frame| frame.t)
    }
}

/// What the odometry sees of a recording.
pub enum CameraInput<'a> {
    /// Images, those outside of what is run left out.
    Images(ImageStream<'a>),
    /// Tracks, of which the part within the span is run.
    Tracks(Vec<TrackFrame>, Span),
}

impl CameraInput<'_> {
    /// The tracks, followed through the images where there are images: what any number of runs with whatever noise have in common.
    ///
    /// `seed` feeds the consensus of the front-end.
    ///
    /// # Errors
    /// Settings out of their bounds; none of the first images can be read, or none of all shows anything.
    pub fn tracks(
        self,
        recording: &Recording,
        config: &FrontEndConfig,
        seed: u64,
    ) -> Result<TrackedSequence, ClosedLoopError> {
        let images = match self {
            Self::Images(images) => images,
            Self::Tracks(frames, span) => return Ok(TrackedSequence { frames, span, images: None }),
        };
        let (camera, mounted) = (recording.camera, recording.body_from_cam.rotation);
        let mut tracker = ImageTracker::new(*config, camera, mounted, &recording.name, seed)
            .map_err(ClosedLoopError::Config)?;
        let mut nobody = ();
        let mut log = TrackingLog::new(&mut nobody);
        walk(recording, images, &mut log, |step, log| {
            match step {
                Step::Sample(place) => tracker.feed_imu(&recording.imu.samples()[place])?,
                Step::SamplesEnd => tracker.end_imu(),
                Step::Image(t, image) => {
                    tracker.feed_image(image.view(), t)?;
                    // The log keeps the frames.
                    while tracker.next_frame(log).is_some() {}
                }
            }
            Ok(())
        })?;
        log.finish(recording)
    }
}

/// Looks on while images are worked off: keeps the frames, counts, and shows everything to somebody else too.
pub(super) struct TrackingLog<'a> {
    tally: Tally,
    frames: Vec<TrackFrame>,
    unreadable: usize,
    also: &'a mut dyn FrontEndObserver,
}

impl<'a> TrackingLog<'a> {
    pub(super) fn new(also: &'a mut dyn FrontEndObserver) -> Self {
        Self { tally: Tally::default(), frames: Vec::new(), unreadable: 0, also }
    }

    /// An image that cannot be read.
    ///
    /// # Errors
    /// Its own, where it is the last of the first images and none before it could be read either.
    pub(super) fn unreadable(&mut self, t: Stamp, error: IoError) -> Result<(), ClosedLoopError> {
        self.unreadable += 1;
        self.tally.passed_over(t, PassedOver::Unreadable, error.to_string());
        if self.unreadable == FIRST && self.unreadable == self.tally.images() {
            return Err(error.into());
        }
        Ok(())
    }

    /// An image that was not taken.
    pub(super) fn refused(&mut self, t: Stamp, error: &FeedError) {
        let reason = match error {
            FeedError::ImageSize { .. } => PassedOver::WrongSize,
            _ => PassedOver::OutOfOrder,
        };
        self.tally.passed_over(t, reason, error.to_string());
    }

    /// The tracks and the report.
    ///
    /// # Errors
    /// No frame at all.
    pub(super) fn finish(self, recording: &Recording) -> Result<TrackedSequence, ClosedLoopError> {
        if self.frames.is_empty() {
            return Err(ClosedLoopError::NothingTracked {
                sequence: recording.name.clone(),
                images: self.tally.images(),
                why: self.tally.worst().map_or_else(|| "there are none".into(), ToString::to_string),
            });
        }
        let images = self.tally.finish(&self.frames);
        Ok(TrackedSequence { frames: self.frames, span: Span::from(0.0), images: Some(images) })
    }
}

impl FrontEndObserver for TrackingLog<'_> {
    fn begin(&mut self, t: Stamp) {
        self.also.begin(t);
        self.tally.begin(t);
    }

    fn end(&mut self, image: &GrayImage, fed: &Fed) {
        self.tally.end(image, fed);
        self.also.end(image, fed);
        self.frames.extend(fed.frame.clone());
    }
}
