//! A live odometry's settings, as one text that any language can hand over.

use super::error::LiveError;
use super::setup::Fed;
use dpn_core::config::{ConfigFault, ConfigFaults, Validate};
use dpn_core::estimate::NoiseSpec;
use dpn_io::calibration::{self, Calibration};
use dpn_io::config::parse;
use dpn_vio::EstimatorConfig;
use serde::Deserialize;
use serde_json::Value;
use std::path::Path;

/// Settings of an [`Odometry`](crate::Odometry).
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct OdometryConfig {
    /// The camera's: the name of a file as Kalibr, OpenVINS, VINS, ORB-SLAM3, Basalt, OKVIS or ASL write it, or a table with the keys of one.
    calibration: Value,
    /// What it is fed beside samples.
    #[serde(default)]
    pub camera: Fed,
    /// Where every sample's noise comes from: what the samples so far say (`const(0.05,0.004)`, `x4`, `diff2`, `dualpronet`), or `self`, learned while it runs.
    #[serde(default = "learned")]
    pub noise: NoiseSpec,
    /// All chance is a function of it.
    #[serde(default)]
    pub seed: u64,
    /// The estimator's, as `dpn run --config` has them.
    #[serde(default)]
    pub estimator: EstimatorConfig,
}

fn learned() -> NoiseSpec {
    "self".parse().expect("a word of the grammar")
}

impl Validate for OdometryConfig {
    fn faults(&self) -> Vec<ConfigFault> {
        let mut faults = ConfigFaults::default();
        faults.table("estimator", self.estimator.faults());
        faults.0
    }
}

impl OdometryConfig {
    /// Settings of a TOML text.
    ///
    /// # Errors
    /// A text that is no TOML, keys that are not known, values outside their bounds; the calibration is read by [`calibration`](Self::calibration).
    pub fn parse(text: &str) -> Result<Self, LiveError> {
        Ok(parse(text, Path::new("settings"))?)
    }

    /// The calibration, its file read.
    ///
    /// # Errors
    /// A file that cannot be read, or keys that make no camera.
    pub fn calibration(&self) -> Result<Calibration, LiveError> {
        Ok(match &self.calibration {
            Value::String(path) => calibration::read(Path::new(path))?,
            keys => calibration::parse(keys.to_string().as_bytes(), Path::new("calibration"))?,
        })
    }
}
