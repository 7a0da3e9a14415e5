//! What every run of the estimator has in common, live or over a recording.

use dpn_core::estimate::NoiseSpec;
use dpn_vio::EstimatorConfig;
use dpn_vio::estimator::FeedError;
use serde::{Deserialize, Serialize};

/// What a live odometry is fed beside samples.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Fed {
    /// Images, which it follows points through; large ones reduced.
    #[default]
    Images,
    /// Tracks of somebody else's front-end.
    Tracks,
}

/// The settings under which `noise` is told: levels are learned where it says so, and nowhere else.
pub fn settings_for(config: &EstimatorConfig, noise: &NoiseSpec) -> EstimatorConfig {
    let components = noise.is_learned().then(|| config.components.unwrap_or_default());
    EstimatorConfig { components, ..config.clone() }
}

/// What was fed went in, or is a single reading that no sensor gives: the estimator counts those, and the run goes on.
///
/// # Errors
/// Any other [`FeedError`].
pub fn pass_over_spikes(fed: Result<(), FeedError>) -> Result<(), FeedError> {
    match fed {
        Err(FeedError::Spike { .. }) => Ok(()),
        fed => fed,
    }
}
