//! How tracks that do not agree are told.

use dpn_core::config::Limit;
use serde::{Deserialize, Serialize};

/// What is known of the motion between two frames.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Geometry {
    /// Its rotation, from the gyroscope.
    TwoPoint,
    /// Nothing.
    Fundamental,
}

dpn_core::settings!(
    /// Settings of the consensus.
    #[derive(Copy)]
    pub struct RansacConfig {
        /// Largest distance of a track that agrees \[px at the image's centre\], above 0, at most 20. Default 1, VINS-Mono's.
        pub threshold_px: f64 = 1.0 => Limit::AtMost(20.0),
    }
    impl Validate
);
