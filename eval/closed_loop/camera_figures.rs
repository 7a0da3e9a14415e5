//! What a camera's images are like to the front-end: the figures that tell whether a rendered camera is as hard as a real one.
//!
//! Over one span of time, the front-end beginning anew: how long tracks live, what ends them, how well they agree with one camera's
//! motion, and how bright and rich in contrast the images are.

use super::error::ClosedLoopError;
use super::recording::Span;
use super::sequence_set::SequenceSet;
use crate::stats::percentile;
use dpn_core::camera::CameraModel;
use dpn_core::random::Stream;
use dpn_core::{GrayImage, Stamp};
use dpn_vio::estimator::FrontEndObserver;
use dpn_vio::frontend::ransac::{Geometry, Pair, RansacConfig, agree};
use dpn_vio::frontend::{Fed, FrontEndConfig, LostBy};
use nalgebra::{Vector2, Vector3};
use std::collections::BTreeMap;

/// Figures of a camera's images over one span.
#[derive(Debug, Clone, PartialEq)]
pub struct CameraFigures {
    /// Mean number of handed-over frames in which a track is.
    pub track_life: f64,
    /// Share of the tracks asked that agreed on the camera's motion.
    pub agree_share: f64,
    /// Share of the tracks followed that did not come home when followed back.
    pub not_home_share: f64,
    /// Median distance of a track from the motion that a frame's tracks agree on best, a fundamental matrix of their own \[px\]; those that
    /// do not agree are counted too.
    pub flow_median_px: f64,
    /// 95th percentile of the same \[px\].
    pub flow_p95_px: f64,
    /// Mean number of tracks in a frame handed over.
    pub tracks: f64,
    /// Mean number of corners that a frame handed over begins with.
    pub corners: f64,
    /// Mean grey value.
    pub grey: f64,
    /// Mean deviation of an image's grey values.
    pub grey_std: f64,
    /// Share of pixels at 8 or below.
    pub dark_share: f64,
    /// Share of pixels at 250 or above.
    pub saturated_share: f64,
}

impl CameraFigures {
    /// The figures of sequence `index` of `source` with this seed, from the image at `from` to the one at `to`.
    ///
    /// # Errors
    /// No images there; none in which anything can be followed.
    pub fn of(
        source: &SequenceSet,
        index: usize,
        seed: u64,
        [from, to]: [Stamp; 2],
    ) -> Result<Self, ClosedLoopError> {
        let recording = source.recording(index, seed)?;
        let input = source.camera_input(index, seed, &Span::from(0.0))?.between(from, to);
        let config = FrontEndConfig::default();
        let mut watch = Watch::new(recording.camera, config.ransac);
        let tracked = input.tracks_watched(&recording, &config, seed, &mut watch)?;
        let report = tracked.images.expect("images were followed").figures;
        let frames = tracked.frames.len() as f64;
        let images = watch.images.max(1) as f64;
        let [grey, grey_std, dark_share, saturated_share] = watch.exposure.map(|sum| sum / images);
        let residual = |share| percentile(&watch.residuals_px, share).unwrap_or(f64::NAN);
        Ok(Self {
            track_life: report.track_length,
            agree_share: report.inlier_share.unwrap_or(f64::NAN),
            not_home_share: report.not_home_share.unwrap_or(f64::NAN),
            flow_median_px: residual(0.5),
            flow_p95_px: residual(0.95),
            tracks: report.tracks,
            corners: watch.corners as f64 / frames,
            grey,
            grey_std,
            dark_share,
            saturated_share,
        })
    }

    /// The figures with their names, in order.
    pub fn named(&self) -> [(&'static str, f64); 11] {
        [
            ("track life, frames handed over", self.track_life),
            ("share that agrees", self.agree_share),
            ("share not home", self.not_home_share),
            ("flow residual, median, px", self.flow_median_px),
            ("flow residual, 95 %, px", self.flow_p95_px),
            ("tracks a frame", self.tracks),
            ("new corners a frame", self.corners),
            ("grey, mean", self.grey),
            ("grey, deviation", self.grey_std),
            ("share dark", self.dark_share),
            ("share saturated", self.saturated_share),
        ]
    }

    /// The mean of several, one a seed.
    ///
    /// # Panics
    /// Of none.
    pub fn mean(several: &[Self]) -> Self {
        assert!(!several.is_empty(), "a mean of nothing");
        let mean = |value: fn(&Self) -> f64| several.iter().map(value).sum::<f64>() / several.len() as f64;
        Self {
            track_life: mean(|f| f.track_life),
            agree_share: mean(|f| f.agree_share),
            not_home_share: mean(|f| f.not_home_share),
            flow_median_px: mean(|f| f.flow_median_px),
            flow_p95_px: mean(|f| f.flow_p95_px),
            tracks: mean(|f| f.tracks),
            corners: mean(|f| f.corners),
            grey: mean(|f| f.grey),
            grey_std: mean(|f| f.grey_std),
            dark_share: mean(|f| f.dark_share),
            saturated_share: mean(|f| f.saturated_share),
        }
    }
}

/// Looks on and counts.
struct Watch {
    camera: CameraModel,
    config: RansacConfig,
    images: usize,
    exposure: [f64; 4],
    corners: usize,
    frames: u64,
    /// Where the last frame handed over saw its tracks.
    handed: BTreeMap<u64, Vector3<f64>>,
    residuals_px: Vec<f64>,
}

impl Watch {
    fn new(camera: CameraModel, config: RansacConfig) -> Self {
        Self {
            camera,
            config: RansacConfig { geometry: Geometry::Fundamental, ..config },
            images: 0,
            exposure: [0.0; 4],
            corners: 0,
            frames: 0,
            handed: BTreeMap::new(),
            residuals_px: Vec::new(),
        }
    }

    /// Distances of a frame's tracks from what they agree on best; those that the front-end has taken out among them.
    fn residuals(&mut self, fed: &Fed) {
        let Some(frame) = &fed.frame else { return };
        let bearing = |px: &Vector2<f64>| self.camera.bearing(px);
        let kept = frame.tracks.iter().map(|track| (track.id, track.px));
        let out = fed.report.lost.iter().filter(|lost| lost.by == LostBy::Ransac).map(|l| (l.id, l.px));
        let pairs: Vec<Pair> = (kept.chain(out))
            .filter_map(|(id, px)| Some(Pair { prev: *self.handed.get(&id)?, cur: bearing(&px)? }))
            .collect();
        let focal = self.camera.px_per_rad();
        let stream = Stream::new(0).named("camera-figures").index(self.frames);
        if let Some(matrix) = agree(&pairs, None, focal, &self.config, &stream).essential {
            let distance = |pair: &Pair| focal * pair.distance_squared(&matrix).sqrt();
            self.residuals_px.extend(pairs.iter().map(distance));
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
        self.residuals(fed);
    }
}
