//! Noise that is not white: a line beside the white part, as rotors have it.

use dpn_core::config::ConfigFaults;
use serde::{Deserialize, Serialize};

/// A share of a sensor's variance whose autocorrelation over a time `t` is `exp(-|t| / decay_s) cos(2 pi hz t)`; the rest is white.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct NoiseLine {
    /// Share of the variance told, from 0 (all is white) to 1.
    pub share: f64,
    /// Frequency as the samples show it, aliased where it is above half of their rate \[Hz\]; 0 is a bias that comes and goes.
    pub hz: f64,
    /// How long the line keeps its phase \[s\].
    pub decay_s: f64,
}

impl Default for NoiseLine {
    fn default() -> Self {
        Self { share: 0.0, hz: 90.0, decay_s: 0.1 }
    }
}

/// The colour of both sensors' noise.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct NoiseColour {
    /// The accelerometer's line, on every axis.
    pub accel: NoiseLine,
    /// The gyroscope's.
    pub gyro: NoiseLine,
}

impl NoiseColour {
    /// Whether there is no line.
    pub fn is_white(&self) -> bool {
        self.accel.share == 0.0 && self.gyro.share == 0.0
    }

    pub(crate) fn check(&self, faults: &mut ConfigFaults) {
        for (sensor, line) in [("accel", &self.accel), ("gyro", &self.gyro)] {
            let key = |name: &str| format!("imu.colour.{sensor}.{name}");
            faults.within(&key("share"), line.share, 0.0, 1.0);
            faults.not_negative(&key("hz"), line.hz);
            faults.positive(&key("decay_s"), line.decay_s);
        }
    }
}
