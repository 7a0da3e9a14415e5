//! The window's settings.

use crate::factors::loss::Loss;
use dpn_core::config::Limit;
use serde::{Deserialize, Serialize};

/// What becomes of the landmarks of a key frame that leaves while they are still tracked.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Handover {
    /// Their sightings enter the prior and are used again from the next host: information counted twice, as VINS-Mono does.
    Reuse,
    /// A landmark of `m` sightings enters the prior with `1/(m - 1)` of its information each time it loses its host, and what of a sighting has
    /// entered is no longer counted in the window: each counts once at any time. A track that has ended enters the prior with all that is left of it.
    Split,
    /// Their sightings enter the prior once and whole; the track goes on as a new landmark from the newest frame. Nothing is approximated: what
    /// marginalising is held to by tests.
    Consume,
}

dpn_core::settings!(
    /// Settings of the sliding window and its solver.
    #[derive(Copy)]
    pub struct WindowConfig {
        /// Key frames beside the newest frame; 3 to 30.
        pub key_frames: usize = 10 => 3..=30,
        /// Standard deviation of a track's pixel \[px\].
        pub pixel_std: f64 = 0.7 => Limit::Positive,
        /// How far a large visual residual may pull.
        pub loss: Loss = Loss::Huber,
        /// Where the loss turns \[standard deviations\], of tracks whose sightings err each for itself.
        pub loss_scale: f64 = 1.5 => Limit::Positive,
        /// Where the loss turns where points are followed through images \[px\]: what one is off beyond that is a fault of following, however little its pixels
        /// are believed.
        pub followed_loss_px: f64 = 0.5 => Limit::Positive,
        /// Mean rotation-compensated parallax that makes a key frame \[px\].
        pub key_frame_parallax_px: f64 = 10.0 => Limit::NotNegative,
        /// Fewer tracks than this in common with the last key frame make one.
        pub key_frame_min_tracks: usize = 20,
        /// So does a smaller share of a frame's tracks than this; 0 to 1.
        pub key_frame_min_share: f64 = 0.5 => 0.0..=1.0,
        /// Smallest angle between rays that lets a depth be told \[rad\].
        pub min_triangulation_angle: f64 = 0.01 => Limit::Positive,
        /// A sighting farther than this from its landmark is an outlier and ends the track \[px\].
        pub outlier_px: f64 = 6.0 => Limit::Positive,
        /// Steps of the solver a frame, at most.
        pub max_iterations: usize = 8 => 1..=1000,
        /// The solver stops when a step lowers the cost by less than this share.
        pub cost_tolerance: f64 = 1e-2 => Limit::NotNegative,
        /// Tracks that outlive their host.
        pub handover: Handover = Handover::Split,
        /// Whether the camera's place on the body is estimated.
        pub estimate_extrinsics: bool = false,
        /// Whether the camera clock's offset is estimated.
        pub estimate_time_offset: bool = false,
    }
);
