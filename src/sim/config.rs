//! What a simulated flight is made of: every part of the IMU's noise can be scaled or switched off.

use crate::imu::{BiasConfig, QuantisationConfig, VibrationConfig, WhiteConfig};
use dpn_core::SampleRate;
use dpn_core::config::{ConfigFault, ConfigFaults, Validate};
use serde::{Deserialize, Serialize};

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

dpn_core::settings!(
    /// A simulated flight's settings. A flight is a function of its name, a seed and this.
    pub struct FlightConfig {
        /// IMU rate \[Hz\], 50 to 2000. Default 200, EuRoC's.
        pub rate_hz: SampleRate = SampleRate::HZ_200,
        /// Spacing of the stamps. Default `euroc`.
        pub stamps: StampPattern = StampPattern::Euroc,
        /// Stamp of the first sample \[ns\], not negative. Default 1,400,000,000 s, a multiple of 256 ns.
        pub epoch_ns: i64 = 1_400_000_000_000_000_000,
        /// White noise, and how its deviation changes in time.
        pub white: WhiteConfig = WhiteConfig::default(),
        /// Biases that walk.
        pub bias: BiasConfig = BiasConfig::default(),
        /// Rotor vibration.
        pub vibration: VibrationConfig = VibrationConfig::default(),
        /// Rounding to the sensor's counts.
        pub quantisation: QuantisationConfig = QuantisationConfig::default(),
    }
);

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
}

impl Validate for FlightConfig {
    fn faults(&self) -> Vec<ConfigFault> {
        let mut faults = ConfigFaults::default();
        faults.within("rate_hz", self.rate_hz.hz(), 50.0, 2000.0);
        // Room for the longest flight before 64-bit nanoseconds end.
        faults.within("epoch_ns", self.epoch_ns as f64, 0.0, 9e18);
        let (white, bias) = (&self.white, &self.bias);
        faults.table("white", white.outside().0);
        faults.within("white.accel_sample_std", white.accel_sample_std.get(), 0.0, 1.0);
        faults.within("white.gyro_sample_std", white.gyro_sample_std.get(), 0.0, 1.0);
        faults.table("bias", bias.outside().0);
        faults.within("bias.accel_walk", bias.accel_walk.get(), 0.0, 1.0);
        faults.within("bias.gyro_walk", bias.gyro_walk.get(), 0.0, 1.0);
        faults.table("vibration", self.vibration.outside().0);
        faults.table("quantisation", self.quantisation.outside().0);
        faults.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn defaults_and_presets_are_valid() {
        for config in [FlightConfig::default(), FlightConfig::ideal()] {
            assert_eq!(config.validate(), Ok(()));
        }
    }

    #[test]
    fn all_faults_are_named_at_once_with_value_and_bound() {
        let mut config = FlightConfig::default();
        config.white.scale = -1.0;
        config.vibration.hover_hz = f64::NAN;
        let error = config.validate().unwrap_err();
        assert_eq!(
            error.to_string(),
            "`white.scale` is -1, but must be 0 to 1000; `vibration.hover_hz` is NaN, but must be 10 to 400"
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
