//! The walk of a bias: as a density, and as VINS-Mono writes it.

use super::quantity::quantity;
use crate::time::SampleRate;

quantity!(
    /// Density of the accelerometer bias's random walk \[m/s^3/sqrt(Hz)\].
    AccelBiasWalkDensity;
    /// Density of the gyroscope bias's random walk \[rad/s^2/sqrt(Hz)\].
    GyroBiasWalkDensity;
    /// Deviation of the accelerometer bias's rate of change, one value a sample, as VINS-Mono's `acc_w` \[m/s^3\].
    AccelBiasRateStd;
    /// Deviation of the gyroscope bias's rate of change, one value a sample, as VINS-Mono's `gyr_w` \[rad/s^2\].
    GyroBiasRateStd;
);

macro_rules! bias_walk {
    ($walk:ident, $rate_std:ident) => {
        impl $walk {
            /// Deviation of the bias's increment from one sample to the next: `density / sqrt(rate)`.
            pub fn step_std(self, rate: SampleRate) -> f64 {
                self.0 / rate.hz().sqrt()
            }
        }

        impl $rate_std {
            /// The same walk as a density: over a step of `1 / rate` the bias moves by this divided by the rate, so
            /// `rate_std / sqrt(rate)`.
            pub fn to_density(self, rate: SampleRate) -> $walk {
                $walk(self.0 / rate.hz().sqrt())
            }
        }
    };
}

bias_walk!(AccelBiasWalkDensity, AccelBiasRateStd);
bias_walk!(GyroBiasWalkDensity, GyroBiasRateStd);

impl AccelBiasRateStd {
    /// VINS-Mono's constant for EuRoC: at 200 Hz a walk of 2.8e-6 m/s^3/sqrt(Hz).
    pub const VINS_MONO: Self = Self(4.0e-5);
}

impl GyroBiasRateStd {
    /// VINS-Mono's constant for EuRoC: at 200 Hz a walk of 1.4e-7 rad/s^2/sqrt(Hz).
    pub const VINS_MONO: Self = Self(2.0e-6);
}

impl AccelBiasWalkDensity {
    /// EuRoC's `sensor.yaml` (ADIS16448).
    pub const EUROC: Self = Self(3.0e-3);
}

impl GyroBiasWalkDensity {
    /// EuRoC's `sensor.yaml` (ADIS16448).
    pub const EUROC: Self = Self(1.9393e-5);
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The field's reading of VINS-Mono's EuRoC file: 137 and 1060 times below the data sheet.
    #[test]
    fn vins_monos_walks_lie_far_below_the_data_sheet() {
        let gyro = GyroBiasRateStd::new(2e-6).unwrap().to_density(SampleRate::HZ_200);
        let accel = AccelBiasRateStd::new(4e-5).unwrap().to_density(SampleRate::HZ_200);
        assert!((GyroBiasWalkDensity::EUROC.get() / gyro.get() - 137.1).abs() < 0.1);
        assert!((AccelBiasWalkDensity::EUROC.get() / accel.get() - 1060.7).abs() < 0.1);
    }
}
