//! The log of a front-end at work: counts, images that nothing was made of.

use super::error::ClosedLoopError;
use super::image_report::{ImageReport, PassedOver};
use super::recording::Recording;
use super::sequence_fault::SequenceFault;
use super::tally::Tally;
use dpn_core::{GrayImage, Stamp, TrackFrame};
use dpn_io::IoError;
use dpn_vio::estimator::{FeedError, FrontEndObserver};
use dpn_vio::frontend::Fed;
use std::collections::VecDeque;

/// When none of so many first images can be read, no later one is waited for.
const FIRST: usize = 10;

/// Looks on while images are worked off: counts, hands frames to `keep`, and shows everything to somebody else too.
pub(super) struct TrackingLog<'a> {
    tally: Tally,
    keep: &'a mut dyn FnMut(&TrackFrame),
    unreadable: usize,
    /// Images that came, readable or not.
    came: usize,
    /// Those of which nothing is made, until images before them were worked off.
    held: VecDeque<(Stamp, PassedOver, String)>,
    also: &'a mut dyn FrontEndObserver,
}

impl<'a> TrackingLog<'a> {
    pub(super) fn new(also: &'a mut dyn FrontEndObserver, keep: &'a mut dyn FnMut(&TrackFrame)) -> Self {
        Self { tally: Tally::default(), keep, unreadable: 0, came: 0, held: VecDeque::new(), also }
    }

    /// An image that is there.
    pub(super) fn came(&mut self) {
        self.came += 1;
    }

    /// An image that cannot be read.
    ///
    /// # Errors
    /// Its own, where it is the last of the first images and none before it could be read either.
    pub(super) fn unreadable(&mut self, t: Stamp, error: IoError) -> Result<(), ClosedLoopError> {
        self.unreadable += 1;
        self.came += 1;
        self.held.push_back((t, PassedOver::Unreadable, error.to_string()));
        if self.unreadable == FIRST && self.unreadable == self.came {
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
        self.held.push_back((t, reason, error.to_string()));
    }

    /// Counts those that came before the image at `t`, or all.
    fn let_go(&mut self, t: Option<Stamp>) {
        while let Some((at, reason, words)) = self.held.pop_front_if(|(at, ..)| t.is_none_or(|t| *at < t)) {
            self.tally.passed_over(at, reason, words);
        }
    }

    /// The report.
    ///
    /// # Errors
    /// No frame at all.
    pub(super) fn finish(mut self, recording: &Recording) -> Result<ImageReport, ClosedLoopError> {
        self.let_go(None);
        if self.tally.frames() == 0 {
            let why = self.tally.worst().map_or_else(|| "there are none".into(), ToString::to_string);
            return Err(
                SequenceFault::NothingTracked { images: self.tally.images(), why }.of(&recording.name)
            );
        }
        Ok(self.tally.finish())
    }
}

impl FrontEndObserver for TrackingLog<'_> {
    fn begin(&mut self, t: Stamp) {
        self.let_go(Some(t));
        self.also.begin(t);
        self.tally.begin(t);
    }

    fn end(&mut self, image: &GrayImage, fed: &Fed) {
        self.tally.end(image, fed);
        self.also.end(image, fed);
        if let Some(frame) = &fed.frame {
            (self.keep)(frame);
        }
    }
}
