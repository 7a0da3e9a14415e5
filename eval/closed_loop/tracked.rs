//! Tracks of a recording, and what became of its images where they were followed.

use super::image_report::ImageReport;
use super::recording::Span;
use dpn_core::TrackFrame;

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
