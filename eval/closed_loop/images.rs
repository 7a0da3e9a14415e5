//! The seam between whoever has images and the front-end.
//!
//! An [`ImageStream`] is all the front-end's side knows of them; the lens that took them is the [`Recording`](super::Recording)'s. [`TrackSource`](super::TrackSource)
//! names where they come from: a new kind is a variant there and an arm in [`SequenceSet::camera_input`](super::SequenceSet::camera_input).

use super::error::ClosedLoopError;
use super::recording::Span;
use super::sequence_fault::SequenceFault;
use dpn_core::{GrayImage, Stamp};
use dpn_io::asl::Sequence;
use dpn_io::{ImageFolder, IoError};

/// Images read ahead of the front-end.
const AHEAD: usize = 4;

/// A camera's images and their stamps, in increasing time. One that cannot be had is an error; the ones after it come all the same.
///
/// What makes them may work ahead on a thread of its own; its memory must not grow with their number.
pub type ImageStream<'a> = Box<dyn Iterator<Item = (Stamp, Result<GrayImage, IoError>)> + 'a>;

/// Whether a sequence's folder holds any of the images it lists; one without a list or a calibration holds none that could be looked at.
///
/// # Errors
/// A list or a calibration that is there and cannot be read.
pub fn has_images(sequence: &Sequence) -> Result<bool, IoError> {
    match ImageFolder::open(sequence) {
        Ok(folder) => Ok(folder.holds_any()),
        Err(IoError::Missing { .. }) => Ok(false),
        Err(error) => Err(error),
    }
}

/// The images that `sequence` lists within `span`, read ahead on a second thread.
///
/// # Errors
/// No stamps or no calibration; none of the images within `span`, or, unless missing ones are to be skipped, not all of them.
pub(super) fn of_folder(
    sequence: &Sequence,
    span: &Span,
    skip_missing: bool,
) -> Result<ImageStream<'static>, ClosedLoopError> {
    let all = ImageFolder::open(sequence)?;
    let stamps: Vec<_> = all.stamps().collect();
    let Some(listed) = span.of(&stamps, |t| *t).first().zip(span.of(&stamps, |t| *t).last()) else {
        return Err(SequenceFault::NoImages { asked: !all.is_empty() }.of(sequence.name()));
    };
    let folder = all.clone().between(*listed.0, *listed.1);
    let coverage = folder.coverage();
    let enough = coverage.is_complete() || (skip_missing && coverage.present() > 0);
    if !enough {
        // Counted from the first image listed, as --from and --to are.
        return Err(SequenceFault::ImagesMissing(Box::new(all.coverage())).of(sequence.name()));
    }
    let folder = if skip_missing { folder.only_present() } else { folder };
    let stamps: Vec<Stamp> = folder.stamps().collect();
    let images = folder.prefetch(AHEAD).map(|read| read.map(|stamped| stamped.image));
    Ok(Box::new(stamps.into_iter().zip(images)))
}
