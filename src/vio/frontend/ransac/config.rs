//! How tracks that do not agree are told.

use dpn_core::config::{ConfigFault, ConfigFaults, Validate};
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

/// Settings of the consensus.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct RansacConfig {
    /// What is tried first; without a rotation `two-point` is `fundamental`. Default `two-point`.
    pub geometry: Geometry,
    /// Largest distance of a track that agrees \[px at the image's centre\], above 0, at most 20. Default 1, VINS-Mono's.
    pub threshold_px: f64,
    /// Probability that a sample without a false track was tried, above 0, below 1. Default .99.
    pub confidence: f64,
    /// Most trials, 1 to 10000. Default 200.
    pub most_trials: usize,
    /// Where fewer tracks than this share agree with the gyroscope's rotation, `fundamental` is asked as well and the larger share wins,
    /// 0 to 1: a rotation may be spoilt by a bias nobody knows yet. Default .7.
    pub doubt_share: f64,
}

impl Default for RansacConfig {
    fn default() -> Self {
        Self {
            geometry: Geometry::TwoPoint,
            threshold_px: 1.0,
            confidence: 0.99,
            most_trials: 200,
            doubt_share: 0.7,
        }
    }
}

impl Validate for RansacConfig {
    fn faults(&self) -> Vec<ConfigFault> {
        let mut faults = ConfigFaults::default();
        let (threshold, confidence) = (self.threshold_px, self.confidence);
        faults.check(threshold > 0.0 && threshold <= 20.0, "threshold_px", threshold, "above 0, at most 20");
        faults.check(confidence > 0.0 && confidence < 1.0, "confidence", confidence, "above 0, below 1");
        faults.within("most_trials", self.most_trials, 1, 10_000);
        faults.within("doubt_share", self.doubt_share, 0.0, 1.0);
        faults.0
    }
}
