//! What a simulated flight is made of: every part of the IMU's noise can be scaled or switched off.

use crate::imu::{BiasConfig, QuantisationConfig, VibrationConfig, WhiteConfig};
use dpn_core::SampleRate;
use dpn_core::config::{ConfigFault, Validate};
use serde::{Deserialize, Serialize};
use std::fmt;
use thiserror::Error;

/// How stamps are spaced.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum StampPattern {
    /// Multiples of the period, rounded to a nanosecond.
    Exact,
    /// Rounded to 256 ns since the epoch, as EuRoC's are (they went through a 64-bit float): at 200 Hz, steps of
    /// 4,999,936 and 5,000,192 ns.
    Euroc,
}

/// A simulated flight's settings. A flight is a function of its name, a seed and this.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct FlightConfig {
    /// IMU rate \[Hz\], 50 to 2000. Default 200, EuRoC's.
    pub rate_hz: SampleRate,
    /// Spacing of the stamps. Default `euroc`.
    pub stamps: StampPattern,
    /// Stamp of the first sample \[ns\], not negative. Default 1,400,000,000 s, a multiple of 256 ns.
    pub epoch_ns: i64,
    /// White noise, and how its deviation changes in time.
    pub white: WhiteConfig,
    /// Biases that walk.
    pub bias: BiasConfig,
    /// Rotor vibration.
    pub vibration: VibrationConfig,
    /// Rounding to the sensor's counts.
    pub quantisation: QuantisationConfig,
}

impl Default for FlightConfig {
    fn default() -> Self {
        Self {
            rate_hz: SampleRate::HZ_200,
            stamps: StampPattern::Euroc,
            epoch_ns: 1_400_000_000_000_000_000,
            white: WhiteConfig::default(),
            bias: BiasConfig::default(),
            vibration: VibrationConfig::default(),
            quantisation: QuantisationConfig::default(),
        }
    }
}

impl FlightConfig {
    /// An ideal IMU: no noise of any kind.
    pub fn ideal() -> Self {
        let mut config = Self::default();
        config.white.scale = 0.0;
        config.bias.scale = 0.0;
        config.vibration.scale = 0.0;
        config.quantisation.enabled = false;
        config
    }

    /// White noise alone, with its schedule.
    pub fn white_only() -> Self {
        Self { white: WhiteConfig::default(), ..Self::ideal() }
    }

    /// Checks every key.
    ///
    /// # Errors
    /// All faults at once, each with key, value and bound.
    pub fn validate(&self) -> Result<(), ConfigError> {
        let mut faults = Faults::default();
        faults.within("rate_hz", self.rate_hz.hz(), 50.0, 2000.0);
        // Room for the longest flight before 64-bit nanoseconds end.
        faults.within("epoch_ns", self.epoch_ns as f64, 0.0, 9e18);
        self.white.check(&mut faults);
        self.bias.check(&mut faults);
        self.vibration.check(&mut faults);
        self.quantisation.check(&mut faults);
        faults.done()
    }
}

impl Validate for FlightConfig {
    fn faults(&self) -> Vec<ConfigFault> {
        let faults = self.validate().err().map_or_else(Vec::new, |error| error.faults);
        let bound = |fault: &Fault| format!("within {} and {}", fault.low, fault.high);
        faults.iter().map(|fault| ConfigFault::new(fault.key.clone(), fault.value, bound(fault))).collect()
    }
}

/// One key out of its bounds.
#[derive(Debug, Clone, PartialEq)]
pub struct Fault {
    /// Dotted name of the key.
    pub key: String,
    /// What it holds.
    pub value: f64,
    /// Lowest value allowed.
    pub low: f64,
    /// Highest value allowed.
    pub high: f64,
}

impl fmt::Display for Fault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { key, value, low, high } = self;
        write!(f, "`{key}` is {value}; it must be within {low} and {high}")
    }
}

/// A configuration that cannot be flown.
#[derive(Debug, Clone, PartialEq, Error)]
#[error("{}", .faults.iter().map(Fault::to_string).collect::<Vec<_>>().join("\n"))]
pub struct ConfigError {
    /// Every key out of its bounds.
    pub faults: Vec<Fault>,
}

/// Collects faults while the parts check themselves.
#[derive(Debug, Default)]
pub(crate) struct Faults(Vec<Fault>);

impl Faults {
    /// Notes a fault unless `low <= value <= high` (so NaN is one).
    pub(crate) fn within(&mut self, key: impl Into<String>, value: f64, low: f64, high: f64) {
        if !(low..=high).contains(&value) {
            self.0.push(Fault { key: key.into(), value, low, high });
        }
    }

    fn done(self) -> Result<(), ConfigError> {
        if self.0.is_empty() { Ok(()) } else { Err(ConfigError { faults: self.0 }) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn defaults_and_presets_are_valid() {
        for config in [FlightConfig::default(), FlightConfig::ideal(), FlightConfig::white_only()] {
            assert_eq!(config.validate(), Ok(()));
        }
    }

    #[test]
    fn all_faults_are_named_at_once_with_value_and_bound() {
        let mut config = FlightConfig::default();
        config.white.scale = -1.0;
        config.vibration.hover_hz = f64::NAN;
        let error = config.validate().unwrap_err();
        assert_eq!(error.faults.len(), 2);
        assert!(
            error.to_string().starts_with(
                "`white.scale` is -1; it must be within 0 and 1000\n`vibration.hover_hz` is NaN"
            ),
            "{error}"
        );
    }

    #[test]
    fn it_survives_a_file_and_unknown_keys_do_not() {
        let config = FlightConfig::default();
        let text = serde_json::to_string(&config).unwrap();
        assert_eq!(serde_json::from_str::<FlightConfig>(&text).unwrap(), config);
        assert_eq!(serde_json::from_str::<FlightConfig>("{}").unwrap(), config);
        let error = serde_json::from_str::<FlightConfig>(r#"{"vibration": {"scael": 0}}"#).unwrap_err();
        assert!(error.to_string().contains("unknown field `scael`"), "{error}");
    }
}
