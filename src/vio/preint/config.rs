//! How noise enters a pre-integrated interval.

use dpn_core::SampleRate;
use dpn_core::noise::{AccelBiasRateStd, AccelBiasWalkDensity, GyroBiasRateStd, GyroBiasWalkDensity};
use serde::{Deserialize, Serialize};

/// How the noise of the samples becomes the covariance of an interval; the formulas stand at the head of [`super`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum ImuCov {
    /// One draw a sample, shared by the two steps that use it: what Monte Carlo gives.
    #[default]
    Exact,
    /// The paper's equation: forward Euler, one sample a step.
    Euler,
    /// VINS-Mono's: two independent half-weight draws a step, half of the variance.
    Vins,
}

dpn_core::settings!(
    /// What pre-integration has to know besides samples and their noise.
    #[derive(Copy)]
    pub struct PreintegrationConfig {
        /// How sample noise enters the covariance: `exact`, `euler` or `vins`.
        pub imu_cov: ImuCov = ImuCov::default(),
        /// Walk of the accelerometer's bias \[m/s^3/sqrt(Hz)\]: under every model its variance grows by the square of this a second.
        /// Zero makes every covariance singular. Default: VINS-Mono's `acc_w = 4e-5` at its 200 Hz, 2.83e-6.
        pub accel_bias_walk: AccelBiasWalkDensity = AccelBiasRateStd::VINS_MONO.to_density(SampleRate::HZ_200),
        /// Walk of the gyro's bias \[rad/s^2/sqrt(Hz)\], likewise. Default: VINS-Mono's `gyr_w = 2e-6` at its 200 Hz, 1.41e-7.
        pub gyro_bias_walk: GyroBiasWalkDensity = GyroBiasRateStd::VINS_MONO.to_density(SampleRate::HZ_200),
    }
);

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn models_are_spelt_in_small_letters() {
        for (model, name) in
            [(ImuCov::Exact, "\"exact\""), (ImuCov::Euler, "\"euler\""), (ImuCov::Vins, "\"vins\"")]
        {
            assert_eq!(serde_json::to_string(&model).unwrap(), name);
        }
        let config: PreintegrationConfig = serde_json::from_str("{\"imu_cov\": \"euler\"}").unwrap();
        assert_eq!(
            config,
            PreintegrationConfig { imu_cov: ImuCov::Euler, ..PreintegrationConfig::default() }
        );
    }

    #[test]
    fn the_default_walks_step_as_vins_mono_does_at_200_hz() {
        let config = PreintegrationConfig::default();
        assert!((config.accel_bias_walk.step_std(SampleRate::HZ_200) - 4e-5 * 0.005).abs() < 1e-20);
        assert!((config.gyro_bias_walk.step_std(SampleRate::HZ_200) - 2e-6 * 0.005).abs() < 1e-20);
    }
}
