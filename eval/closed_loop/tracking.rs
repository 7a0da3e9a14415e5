//! What the odometry sees of a recording, and the tracks that its own tracker follows through images.

use super::error::ClosedLoopError;
use super::images::ImageStream;
use super::recording::{Recording, Span};
use super::tracked::TrackedSequence;
use super::tracking_log::TrackingLog;
use super::walk::{Step, walk};
use dpn_core::TrackFrame;
use dpn_live::pass_over_spikes;
use dpn_vio::estimator::{FrontEndObserver, ImageTracker};
use dpn_vio::frontend::FrontEndConfig;

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
        self.tracks_watched(recording, config, seed, &mut ())
    }

    /// The same while somebody looks on.
    ///
    /// # Errors
    /// As [`tracks`](Self::tracks).
    pub fn tracks_watched(
        self,
        recording: &Recording,
        config: &FrontEndConfig,
        seed: u64,
        also: &mut dyn FrontEndObserver,
    ) -> Result<TrackedSequence, ClosedLoopError> {
        let images = match self {
            Self::Images(images) => images,
            Self::Tracks(frames, span) => return Ok(TrackedSequence { frames, span, images: None }),
        };
        let (camera, mounted) = (recording.camera, recording.body_from_cam.rotation);
        let mut tracker =
            ImageTracker::new(*config, camera, mounted, seed).map_err(ClosedLoopError::Config)?;
        let mut frames = Vec::new();
        let mut keep = |frame: &TrackFrame| frames.push(frame.clone());
        let mut log = TrackingLog::new(also, &mut keep);
        walk(recording, images, &mut log, |step, log| {
            match step {
                Step::Sample(place) => pass_over_spikes(tracker.feed_imu(&recording.imu.samples()[place]))?,
                Step::SamplesEnd => tracker.end_imu(),
                Step::Image(t, image) => {
                    tracker.feed_image(image.view(), t)?;
                }
                Step::ImagesEnd => tracker.end_images(),
            }
            // The log hands the frames on.
            while tracker.next_frame(log).is_some() {}
            Ok(())
        })?;
        let images = log.finish(recording)?;
        Ok(TrackedSequence { frames, span: Span::from(0.0), images: Some(images) })
    }
}
