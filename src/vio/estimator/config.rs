//! The estimator's settings.

use super::health::HealthConfig;
use crate::init::InitConfig;
use crate::preint::PreintegrationConfig;
use crate::window::WindowConfig;
use serde::{Deserialize, Serialize};

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
    /// Whether every update carries the covariance of its pose: one more linear system a frame.
    pub covariance: bool,
}
