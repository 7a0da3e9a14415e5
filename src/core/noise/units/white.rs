//! White noise: per sample and as a density.

use super::quantity::quantity;
use crate::time::SampleRate;

quantity!(
    /// Standard deviation of one accelerometer sample at the sensor's own rate \[m/s^2\].
    AccelSampleStd;
    /// Standard deviation of one gyroscope sample at the sensor's own rate \[rad/s\].
    GyroSampleStd;
    /// Density of the accelerometer's white noise \[m/s^2/sqrt(Hz)\].
    AccelNoiseDensity;
    /// Density of the gyroscope's white noise \[rad/s/sqrt(Hz)\].
    GyroNoiseDensity;
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

white_noise!(AccelSampleStd, AccelNoiseDensity);
white_noise!(GyroSampleStd, GyroNoiseDensity);

impl AccelSampleStd {
    /// VINS-Mono's constant for EuRoC, the paper's "x1".
    pub(crate) const BASELINE: Self = Self(0.08);
}

impl GyroSampleStd {
    /// VINS-Mono's constant for EuRoC, the paper's "x1".
    pub(crate) const BASELINE: Self = Self(0.004);
}

impl AccelNoiseDensity {
    /// EuRoC's `sensor.yaml` (ADIS16448): .0283 m/s^2 per sample at 200 Hz.
    pub const EUROC: Self = Self(2.0e-3);
}

impl GyroNoiseDensity {
    /// EuRoC's `sensor.yaml` (ADIS16448): .0024 rad/s per sample at 200 Hz.
    pub const EUROC: Self = Self(1.6968e-4);
}

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
    fn negative_and_nan_are_no_noise() {
        assert!(AccelSampleStd::new(-0.1).is_err());
        assert!(GyroSampleStd::new(f64::NAN).is_err());
    }
}
