//! What happened to one image.

use super::image::ImageStats;
use super::ransac::Geometry;
use dpn_core::Stamp;
use nalgebra::{Vector2, Vector3};
use serde::Serialize;
use std::time::Duration;

/// What was made of an image.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[serde(rename_all = "kebab-case", tag = "status")]
pub enum Status {
    /// Tracks were followed into it.
    Tracked,
    /// The same, and a frame was handed over.
    HandedOver,
    /// It shows nothing: too dark, too bright, or all alike. Tracks wait for the next.
    Blind,
    /// It is the last one over again. Tracks wait for the next.
    Repeated,
    /// It has another size than the camera. It was not looked at.
    WrongSize {
        /// Its width \[px\].
        width: usize,
        /// Its height \[px\].
        height: usize,
    },
    /// It was not taken later than the last one. It was not looked at.
    OutOfOrder {
        /// The last one's stamp \[ns\].
        last_ns: i64,
    },
}

/// Why a track ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum LostBy {
    /// It left the image.
    Outside,
    /// Its window has lost its texture.
    Flat,
    /// What was found does not look like it.
    Unlike,
    /// Tracked back, it did not come home.
    Back,
    /// It does not agree with the others on the camera's motion.
    Ransac,
    /// It came too near to an older one.
    Crowded,
    /// Images showed nothing for too long.
    Blind,
}

/// A track that ended.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Lost {
    /// Its number.
    pub id: u64,
    /// Where it was last \[px\]; for one that did not agree, where it was found.
    pub px: Vector2<f64>,
    /// Why it ended.
    pub by: LostBy,
}

/// What the tracks agreed on.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Agreement {
    /// What was asked, or won.
    pub geometry: Geometry,
    /// Tracks that were asked.
    pub asked: usize,
    /// Tracks that agreed.
    pub agreed: usize,
    /// Samples tried.
    pub trials: usize,
}

/// Wall time of the stages; what was not done took none.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize)]
pub struct StageTimes {
    /// Figures of the image, pyramid.
    pub image: Duration,
    /// Tracking and tracking back.
    pub track: Duration,
    /// Consensus.
    pub ransac: Duration,
    /// New points.
    pub corners: Duration,
}

impl StageTimes {
    /// All stages.
    pub fn total(&self) -> Duration {
        self.image + self.track + self.ransac + self.corners
    }
}

/// What happened to one image.
#[derive(Debug, Clone, PartialEq)]
pub struct FrameReport {
    /// The image's stamp.
    pub t: Stamp,
    /// What was made of it.
    pub status: Status,
    /// Figures of its pixels; none where it was not looked at.
    pub image: Option<ImageStats>,
    /// Tracks before it.
    pub before: usize,
    /// Tracks that were followed into it and kept.
    pub kept: usize,
    /// Tracks that ended, in the order of their numbers as they were before.
    pub lost: Vec<Lost>,
    /// Tracks that begin here.
    pub new: usize,
    /// Mean number of images in which the tracks have been seen, this one among them; 0 without tracks.
    pub mean_age: f64,
    /// Median distance that kept tracks moved since the last image that was tracked \[px\]; 0 without tracks.
    pub motion_px: f64,
    /// What tracks agreed on; none where they were not asked.
    pub agreement: Option<Agreement>,
    /// The gyroscope's bias in the camera's frame as the tracks have shown it \[rad/s\]; 0 where they were not asked.
    pub gyro_bias: Vector3<f64>,
    /// Wall time of the stages. The only part that differs between two runs.
    pub times: StageTimes,
}

impl FrameReport {
    pub(super) fn new(t: Stamp, status: Status, before: usize) -> Self {
        Self {
            t,
            status,
            image: None,
            before,
            kept: 0,
            lost: Vec::new(),
            new: 0,
            mean_age: 0.0,
            motion_px: 0.0,
            agreement: None,
            gyro_bias: Vector3::zeros(),
            times: StageTimes::default(),
        }
    }

    /// How many tracks ended for this reason.
    pub fn lost_by(&self, by: LostBy) -> usize {
        self.lost.iter().filter(|lost| lost.by == by).count()
    }
}
