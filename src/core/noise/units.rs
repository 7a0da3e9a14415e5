//! Noise quantities, one type per meaning; a bare `f64` of noise crosses no crate's border.
//!
//! White noise of density `n` sampled at rate `f` has the deviation `sigma = n * sqrt(f)` per sample. A bias walk of
//! density `w` adds, over a step of `1 / f`, an increment of deviation `w / sqrt(f)`. VINS-Mono's `acc_n`, `gyr_n`
//! are per-sample deviations; data sheets, Kalibr, OpenVINS and ORB-SLAM3 give densities (decision 24).

use crate::time::SampleRate;
use serde::{Deserialize, Serialize};

/// A noise value that cannot be.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[error("a noise figure must be finite and not negative, not {0}")]
pub struct BadNoise(pub f64);

macro_rules! quantity {
    ($(#[$doc:meta])* $name:ident) => {
        $(#[$doc])*
        #[derive(Debug, Clone, Copy, PartialEq, PartialOrd, Serialize, Deserialize)]
        #[serde(try_from = "f64", into = "f64")]
        pub struct $name(f64);

        impl $name {
            /// Takes `value` in the unit named above.
            ///
            /// # Errors
            /// Negative, NaN or infinite values.
            pub fn new(value: f64) -> Result<Self, BadNoise> {
                if value.is_finite() && value >= 0.0 { Ok(Self(value)) } else { Err(BadNoise(value)) }
            }

            /// The number in the unit named above.
            pub fn get(self) -> f64 {
                self.0
            }
        }

        impl TryFrom<f64> for $name {
            type Error = BadNoise;
            fn try_from(value: f64) -> Result<Self, BadNoise> {
                Self::new(value)
            }
        }

        impl From<$name> for f64 {
            fn from(value: $name) -> f64 {
                value.0
            }
        }
    };
}

quantity!(
    /// Standard deviation of one accelerometer sample at the sensor's own rate \[m/s^2\].
    AccelSampleStd
);
quantity!(
    /// Standard deviation of one gyroscope sample at the sensor's own rate \[rad/s\].
    GyroSampleStd
);
quantity!(
    /// Density of the accelerometer's white noise \[m/s^2/sqrt(Hz)\].
    AccelNoiseDensity
);
quantity!(
    /// Density of the gyroscope's white noise \[rad/s/sqrt(Hz)\].
    GyroNoiseDensity
);
quantity!(
    /// Density of the accelerometer bias's random walk \[m/s^3/sqrt(Hz)\].
    AccelBiasWalkDensity
);
quantity!(
    /// Density of the gyroscope bias's random walk \[rad/s^2/sqrt(Hz)\].
    GyroBiasWalkDensity
);
quantity!(
    /// Standard deviation of the rate at which the accelerometer's bias changes, a new draw every sample \[m/s^3\]: from one
    /// sample to the next the bias moves by a deviation of this times the step. VINS-Mono's `acc_w`.
    AccelBiasRateStd
);
quantity!(
    /// Standard deviation of the rate at which the gyroscope's bias changes, a new draw every sample \[rad/s^2\]: from one
    /// sample to the next the bias moves by a deviation of this times the step. VINS-Mono's `gyr_w`.
    GyroBiasRateStd
);

macro_rules! white_noise {
    ($sample:ident, $density:ident) => {
        impl $sample {
            /// The same noise as a density: `sigma / sqrt(rate)`.
            pub fn to_density(self, rate: SampleRate) -> $density {
                $density(self.0 / rate.hz().sqrt())
            }
        }

        impl $density {
            /// The same noise per sample at `rate`: `density * sqrt(rate)`.
            pub fn to_sample_std(self, rate: SampleRate) -> $sample {
                $sample(self.0 * rate.hz().sqrt())
            }
        }
    };
}

impl AccelSampleStd {
    /// VINS-Mono's constant for EuRoC, the paper's "x1".
    pub const BASELINE: Self = Self(0.08);
}

impl GyroSampleStd {
    /// VINS-Mono's constant for EuRoC, the paper's "x1".
    pub const BASELINE: Self = Self(0.004);
}

impl AccelNoiseDensity {
    /// EuRoC's `sensor.yaml` (ADIS16448): .0283 m/s^2 per sample at 200 Hz.
    pub const EUROC: Self = Self(2.0e-3);
}

impl GyroNoiseDensity {
    /// EuRoC's `sensor.yaml` (ADIS16448): .0024 rad/s per sample at 200 Hz.
    pub const EUROC: Self = Self(1.6968e-4);
}

impl AccelBiasWalkDensity {
    /// EuRoC's `sensor.yaml` (ADIS16448).
    pub const EUROC: Self = Self(3.0e-3);
}

impl GyroBiasWalkDensity {
    /// EuRoC's `sensor.yaml` (ADIS16448).
    pub const EUROC: Self = Self(1.9393e-5);
}

white_noise!(AccelSampleStd, AccelNoiseDensity);
white_noise!(GyroSampleStd, GyroNoiseDensity);
// The rate of a bias is white noise like any other; its density is the density of the bias's walk.
white_noise!(AccelBiasRateStd, AccelBiasWalkDensity);
white_noise!(GyroBiasRateStd, GyroBiasWalkDensity);

impl AccelBiasRateStd {
    /// VINS-Mono's constant for EuRoC: at 200 Hz a walk of 2.8e-6 m/s^3/sqrt(Hz).
    pub const VINS_MONO: Self = Self(4.0e-5);
}

impl GyroBiasRateStd {
    /// VINS-Mono's constant for EuRoC: at 200 Hz a walk of 1.4e-7 rad/s^2/sqrt(Hz).
    pub const VINS_MONO: Self = Self(2.0e-6);
}

macro_rules! bias_walk {
    ($walk:ident) => {
        impl $walk {
            /// Deviation of the bias's increment from one sample to the next: `density / sqrt(rate)`.
            pub fn step_std(self, rate: SampleRate) -> f64 {
                self.0 / rate.hz().sqrt()
            }
        }
    };
}

bias_walk!(AccelBiasWalkDensity);
bias_walk!(GyroBiasWalkDensity);

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_euroc_data_sheet_gives_its_known_sample_deviation() {
        let accel = AccelNoiseDensity::new(2.0e-3).unwrap().to_sample_std(SampleRate::HZ_200);
        let gyro = GyroNoiseDensity::new(1.6968e-4).unwrap().to_sample_std(SampleRate::HZ_200);
        assert!((accel.get() - 0.0283).abs() < 5e-5);
        assert!((gyro.get() - 0.0024).abs() < 5e-6);
    }

    #[test]
    fn density_and_back_is_the_same_at_any_rate() {
        for hz in [100.0, 199.4, 200.0, 1000.0] {
            let rate = SampleRate::from_hz(hz).unwrap();
            let sigma = AccelSampleStd::new(0.08).unwrap();
            assert!((sigma.to_density(rate).to_sample_std(rate).get() - 0.08).abs() < 1e-15);
        }
    }

    #[test]
    fn a_rate_drawn_every_sample_walks_as_far_as_its_density_says() {
        let rate = SampleRate::HZ_200;
        let a_step = AccelBiasRateStd::VINS_MONO.get() * rate.period();
        assert!((AccelBiasRateStd::VINS_MONO.to_density(rate).step_std(rate) - a_step).abs() < 1e-20);
    }

    #[test]
    fn negative_and_nan_are_no_noise() {
        assert!(AccelSampleStd::new(-0.1).is_err());
        assert!(GyroSampleStd::new(f64::NAN).is_err());
    }
}
