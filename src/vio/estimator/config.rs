//! The estimator's settings.

use super::delayed::DelayedConfig;
use super::health::HealthConfig;
use crate::components::ComponentsConfig;
use crate::frontend::FrontEndConfig;
use crate::init::InitConfig;
use crate::lens::LensConfig;
use crate::preint::PreintegrationConfig;
use crate::window::{Handover, WindowConfig};
use serde::{Deserialize, Serialize};

/// What the tracks are that are fed as such.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum FedTracks {
    /// Each sighting errs for itself, as simulated ones do.
    #[default]
    White,
    /// Followed through images before: what a point is off lasts and is shared by its neighbours, as of images that are fed.
    Followed,
}

/// All settings of the estimator.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct EstimatorConfig {
    /// How samples and their noise become inertial measurements.
    pub imu: PreintegrationConfig,
    /// The sliding window and its solver.
    pub window: WindowConfig,
    /// When first states are believed.
    pub init: InitConfig,
    /// When an estimate is given up.
    pub health: HealthConfig,
    /// Whether, and how, the prior is made again from key frames that have left.
    pub delayed: DelayedConfig,
    /// What is learned of the lens beyond its calibration.
    pub lens: LensConfig,
    /// What follows points through images, where images are fed and not tracks.
    pub front_end: FrontEndConfig,
    /// What tracks are that are fed as such.
    pub fed_tracks: FedTracks,
    /// Whether every update carries the covariance of its pose: one more linear system a frame.
    pub covariance: bool,
    /// How levels of the noise are learned; `None`: what is told is in force.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub components: Option<ComponentsConfig>,
}

impl EstimatorConfig {
    /// What settings that are allowed do not do together, for people.
    pub fn warnings(&self) -> Vec<String> {
        let twice = self.covariance && self.window.handover == Handover::Reuse;
        let words = "covariances are some 2 times too small in deviation with `window.handover = \"reuse\"`, which counts sightings twice (NEES 9 to 14 where 3 is right); \"split\", the default, does not";
        twice.then(|| words.to_owned()).into_iter().collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn covariances_of_sightings_counted_twice_are_warned_of() {
        let mut config = EstimatorConfig { covariance: true, ..EstimatorConfig::default() };
        assert!(config.warnings().is_empty());
        config.window.handover = Handover::Reuse;
        assert!(config.warnings()[0].contains("\"split\", the default, does not"));
        config.covariance = false;
        assert!(config.warnings().is_empty());
        config = EstimatorConfig { covariance: true, ..EstimatorConfig::default() };
        config.components = Some(ComponentsConfig::default());
        assert!(config.warnings().is_empty());
    }
}
