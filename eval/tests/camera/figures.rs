//! What a camera's images are like to the front-end: the figures that tell whether a rendered camera is as hard as a real one.
//!
//! Over one span of time, the front-end beginning anew: how long tracks live, what ends them, how well they agree with one camera's
//! motion, and how bright and rich in contrast the images are.

use super::lens_error::Matched;
use dpn_core::camera::CameraModel;
use dpn_core::random::Stream;
use dpn_core::{GrayImage, Stamp};
use dpn_eval::closed_loop::{CameraInput, ClosedLoopError, SequenceSet, Span, TrackedSequence};
use dpn_eval::stats::percentile;
use dpn_vio::estimator::FrontEndObserver;
use dpn_vio::frontend::ransac::{Pair, agree};
use dpn_vio::frontend::{Fed, FrontEndConfig, LostBy};
use nalgebra::{Vector2, Vector3};
use std::collections::BTreeMap;

/// Figures of a camera's images over one span, each with its name.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct CameraFigures([(&'static str, f64); 11]);

impl CameraFigures {
    /// The figures of sequence `index` of `source` with this seed, from the image at `from` to the one at `to`.
    ///
    /// # Errors
    /// No images there; none in which anything can be followed.
    pub(crate) fn of(
        source: &SequenceSet,
        index: usize,
        seed: u64,
        [from, to]: [Stamp; 2],
    ) -> Result<Self, ClosedLoopError> {
        let (watch, tracked) = watched(source, index, seed, [from, to])?;
        let report = tracked.images.expect("images were followed").figures;
        let frames = tracked.frames.len() as f64;
        let images = watch.images.max(1) as f64;
        let [grey, grey_std, dark_share, saturated_share] = watch.exposure.map(|sum| sum / images);
        let residuals_px: Vec<f64> = watch.matched.iter().flat_map(Matched::distances_px).collect();
        let residual = |share| percentile(&residuals_px, share).unwrap_or(f64::NAN);
        Ok(Self([
            // Mean number of handed-over frames in which a track is.
            ("track life, frames handed over", report.track_length),
            // Of the tracks asked, those that agreed on the camera's motion.
            ("share that agrees", report.inlier_share.unwrap_or(f64::NAN)),
            // Of the tracks followed, those that did not come home when followed back.
            ("share not home", report.not_home_share.unwrap_or(f64::NAN)),
            // Distance of a track from the motion that a frame's tracks agree on best, a fundamental matrix of their own; those that do not agree
            // are counted too.
            ("flow residual, median, px", residual(0.5)),
            ("flow residual, 95 %, px", residual(0.95)),
            ("tracks a frame", report.tracks),
            // With which a frame handed over begins, on the mean.
            ("new corners a frame", watch.corners as f64 / frames),
            ("grey, mean", grey),
            // Mean deviation of an image's grey values.
            ("grey, deviation", grey_std),
            // Pixels at 8 or below, and at 250 or above.
            ("share dark", dark_share),
            ("share saturated", saturated_share),
        ]))
    }

    /// The figures with their names, in order.
    pub(crate) fn named(&self) -> [(&'static str, f64); 11] {
        self.0
    }

    /// The mean of several, one a seed.
    ///
    /// # Panics
    /// Of none.
    pub(crate) fn mean(several: &[Self]) -> Self {
        let first = several.first().expect("a mean of something");
        let mean = |at: usize| several.iter().map(|f| f.0[at].1).sum::<f64>() / several.len() as f64;
        Self(std::array::from_fn(|at| (first.0[at].0, mean(at))))
    }
}

/// The frames' matches of sequence `index` of `source`, from the image at `from` to the one at `to`: what `lens_error` is fitted to.
///
/// # Errors
/// As [`CameraFigures::of`].
pub(crate) fn matches(
    source: &SequenceSet,
    index: usize,
    seed: u64,
    span: [Stamp; 2],
) -> Result<Vec<Matched>, ClosedLoopError> {
    Ok(watched(source, index, seed, span)?.0.matched)
}

/// Follows points with the front-end's defaults, looked on.
fn watched(
    source: &SequenceSet,
    index: usize,
    seed: u64,
    [from, to]: [Stamp; 2],
) -> Result<(Watch, TrackedSequence), ClosedLoopError> {
    let recording = source.recording(index, seed)?;
    let CameraInput::Images(mut all) = source.camera_input(index, seed, &Span::from(0.0))? else {
        unreachable!("a source of images");
    };
    // What lies before is not drawn.
    let before_s = all.next().map_or(0.0, |(first, _)| from.seconds_since(first).max(0.0));
    let CameraInput::Images(images) = source.camera_input(index, seed, &Span::from(before_s))? else {
        unreachable!("a source of images");
    };
    let input = CameraInput::Images(Box::new(images.take_while(move |(t, _)| *t <= to)));
    let config = FrontEndConfig::default();
    let mut watch = Watch::new(recording.camera, config.ransac.threshold_px);
    let tracked = input.tracks_watched(&recording, &config, seed, &mut watch)?;
    Ok((watch, tracked))
}

/// Looks on and counts.
struct Watch {
    camera: CameraModel,
    threshold_px: f64,
    images: usize,
    exposure: [f64; 4],
    corners: usize,
    frames: u64,
    /// Where the last frame handed over saw its tracks.
    handed: BTreeMap<u64, Vector3<f64>>,
    matched: Vec<Matched>,
}

impl Watch {
    fn new(camera: CameraModel, threshold_px: f64) -> Self {
        Self {
            camera,
            threshold_px,
            images: 0,
            exposure: [0.0; 4],
            corners: 0,
            frames: 0,
            handed: BTreeMap::new(),
            matched: Vec::new(),
        }
    }

    /// A frame's tracks and what they agree on best; those that the front-end has taken out among them.
    fn matches(&mut self, fed: &Fed) {
        let Some(frame) = &fed.frame else { return };
        let bearing = |px: &Vector2<f64>| self.camera.bearing(px);
        let kept = frame.tracks.iter().map(|track| (track.id, track.px));
        let out = fed.report.lost.iter().filter(|lost| lost.by == LostBy::Ransac).map(|l| (l.id, l.px));
        let pairs: Vec<Pair> = (kept.chain(out))
            .filter_map(|(id, px)| Some(Pair { prev: *self.handed.get(&id)?, cur: bearing(&px)? }))
            .collect();
        let focal = self.camera.px_per_rad();
        let stream = Stream::new(0).named("camera-figures").index(self.frames);
        if let Some(matrix) = agree(&pairs, None, focal, self.threshold_px, 0.0, &stream).essential {
            self.matched.push(Matched { pairs, matrix, px_per_rad: focal });
        }
        self.frames += 1;
        self.handed = frame.tracks.iter().filter_map(|t| Some((t.id, bearing(&t.px)?))).collect();
    }
}

impl FrontEndObserver for Watch {
    fn end(&mut self, _: &GrayImage, fed: &Fed) {
        if let Some(image) = fed.report.image {
            self.images += 1;
            let figures = [image.mean, image.std, image.dark, image.saturated];
            self.exposure.iter_mut().zip(figures).for_each(|(sum, figure)| *sum += figure);
        }
        self.corners += fed.report.new;
        self.matches(fed);
    }
}
