//! Noise that is not white: lines beside the white part, as rotors have them.

use dpn_core::config::ConfigFaults;
use serde::{Deserialize, Deserializer, Serialize, Serializer, de};

/// Most lines of a sensor.
pub const LINES: usize = 3;

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

/// The lines of one sensor, on every axis; those that are not given have no share.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct NoiseLines(pub [NoiseLine; LINES]);

impl NoiseLines {
    /// Share of the variance that is white.
    pub fn white_share(&self) -> f64 {
        1.0 - self.0.iter().map(|line| line.share).sum::<f64>()
    }
}

impl From<NoiseLine> for NoiseLines {
    fn from(line: NoiseLine) -> Self {
        Self([line, NoiseLine::default(), NoiseLine::default()])
    }
}

impl Serialize for NoiseLines {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_seq(self.0.iter().filter(|line| line.share != 0.0))
    }
}

impl<'de> Deserialize<'de> for NoiseLines {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let given = Vec::<NoiseLine>::deserialize(deserializer)?;
        if given.len() > LINES {
            let found = given.len();
            return Err(de::Error::invalid_length(found, &format!("at most {LINES} lines").as_str()));
        }
        let mut lines = Self::default();
        lines.0[..given.len()].copy_from_slice(&given);
        Ok(lines)
    }
}

/// The colour of both sensors' noise.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct NoiseColour {
    /// The accelerometer's lines.
    pub accel: NoiseLines,
    /// The gyroscope's.
    pub gyro: NoiseLines,
}

impl NoiseColour {
    /// Whether there is no line.
    pub fn is_white(&self) -> bool {
        self.accel.0.iter().chain(&self.gyro.0).all(|line| line.share == 0.0)
    }

    pub(crate) fn check(&self, faults: &mut ConfigFaults) {
        for (sensor, lines) in [("accel", &self.accel), ("gyro", &self.gyro)] {
            for (k, line) in lines.0.iter().enumerate() {
                let key = |name: &str| format!("imu.colour.{sensor}[{k}].{name}");
                faults.within(key("share"), line.share, 0.0, 1.0);
                faults.not_negative(key("hz"), line.hz);
                faults.positive(key("decay_s"), line.decay_s);
            }
            let white = lines.white_share();
            let key = format!("imu.colour.{sensor}");
            faults.check(
                white >= -1e-9,
                key,
                format!("shares of {}", 1.0 - white),
                "shares of 1 in all, at most",
            );
        }
    }
}
