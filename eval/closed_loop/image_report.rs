//! What became of a recording's images, in figures and events.

use super::rhythm::Rhythm;
use serde::{Deserialize, Serialize};

/// What became of a recording's images.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct ImageReport {
    /// The figures.
    pub figures: FrontEndFigures,
    /// What was wrong with images, in time.
    pub events: Vec<ImageEvent>,
    /// Events beyond those kept.
    pub more_events: usize,
    /// How the images came, whatever became of them.
    #[serde(default)]
    pub rhythm: Rhythm,
    /// By how much brightness changes from an image to the next, median, as a share of it.
    #[serde(default)]
    pub flicker: f64,
}

/// The front-end over a recording, in figures.
///
/// All but `cpu_per_data_s` and `p95_ms` are the same in every run.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FrontEndFigures {
    /// Images that came, in whatever state.
    pub images: usize,
    /// Those that no point was followed into: dark, saturated, repeated, of another size, unreadable.
    pub passed_over: usize,
    /// Mean number of tracks in a frame handed over.
    pub tracks: f64,
    /// Mean number of frames handed over in which a track is.
    pub track_length: f64,
    /// Share of the tracks asked that agreed on the camera's motion; none where none was asked.
    pub inlier_share: Option<f64>,
    /// Share of the frames in which the gyroscope's rotation was what they agreed on; none where none was asked.
    pub by_gyro_share: Option<f64>,
    /// Share of all tracks followed that did not come home when followed back; none where none was followed.
    pub not_home_share: Option<f64>,
    /// CPU seconds a second of data, without getting the images.
    pub cpu_per_data_s: f64,
    /// 95th percentile of an image's CPU time \[ms\].
    pub p95_ms: f64,
}

/// Why nothing was made of an image.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum PassedOver {
    /// It shows nothing: dark, saturated, or all alike.
    Blind,
    /// It is the one before over again.
    Repeated,
    /// It has another size than the camera's calibration says.
    WrongSize,
    /// It is not later than the one before.
    OutOfOrder,
    /// It cannot be read.
    Unreadable,
}

/// Images in a row that were passed over for one reason.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ImageEvent {
    /// Seconds of the first of them after the first image.
    pub from_s: f64,
    /// Of the last.
    pub to_s: f64,
    /// How many.
    pub images: usize,
    /// Why.
    pub reason: PassedOver,
    /// The same in words, of the first of them.
    pub words: String,
}

impl std::fmt::Display for ImageEvent {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { from_s, to_s, images, words, .. } = self;
        if *images == 1 {
            write!(f, "an image passed over at {from_s:.2} s: {words}")
        } else {
            write!(f, "{images} images passed over from {from_s:.2} to {to_s:.2} s: {words}")
        }
    }
}
