//! Biases that start somewhere and walk: b_{k+1} = b_k + w / sqrt(rate) n_k, n_k ~ N(0, 1).
//!
//! Start and walk have a stream each per sensor and axis: ("bias", "start" | "walk", sensor, axis).

use super::series::ImuSeries;
use dpn_core::noise::{AccelBiasWalkDensity, GyroBiasWalkDensity};
use dpn_core::random::Stream;
use dpn_core::{SampleRate, Sensor};
use rand::Rng;
use rand_distr::StandardNormal;

/// Deviations of the first biases, as EuRoC's estimates scatter: accelerometer \[m/s^2\], gyroscope \[rad/s\].
const ACCEL_START: f64 = 0.08;
const GYRO_START: f64 = 0.04;

dpn_core::settings!(
    /// Biases of a simulated IMU.
    pub struct BiasConfig {
        /// Scales starts and walks, 0 to 1000; 0 switches biases off. Default 1.
        pub scale: f64 = 1.0 => 0.0..=1000.0,
        /// Walk of the accelerometer's bias \[m/s^3/sqrt(Hz)\], up to 1. Default 3e-3, EuRoC's sensor.yaml.
        pub accel_walk: AccelBiasWalkDensity = AccelBiasWalkDensity::EUROC,
        /// Walk of the gyroscope's bias \[rad/s^2/sqrt(Hz)\], up to 1. Default 1.9393e-5, EuRoC's sensor.yaml.
        pub gyro_walk: GyroBiasWalkDensity = GyroBiasWalkDensity::EUROC,
    }
);

/// Biases over `n` samples.
pub(crate) fn draw(config: &BiasConfig, rate: SampleRate, n: usize, stream: &Stream) -> ImuSeries {
    let mut bias = ImuSeries::zeros(n);
    for sensor in Sensor::ALL {
        let (start, step) = match sensor {
            Sensor::Accel => (ACCEL_START, config.accel_walk.step_std(rate)),
            Sensor::Gyro => (GYRO_START, config.gyro_walk.step_std(rate)),
        };
        for axis in 0..3 {
            let rng = |what: &str| stream.named(what).named(sensor.name()).index(axis as u64).rng();
            let first: f64 = rng("start").sample(StandardNormal);
            let mut walk = rng("walk");
            let mut at = config.scale * start * first;
            for value in bias.of_mut(sensor) {
                value[axis] = at;
                let draw: f64 = walk.sample(StandardNormal);
                at += config.scale * step * draw;
            }
        }
    }
    bias
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn increments_have_the_deviation_of_the_density_at_two_rates() {
        let n = 20_000;
        for hz in [100.0, 200.0] {
            let rate = SampleRate::from_hz(hz).unwrap();
            let config = BiasConfig::default();
            let bias = draw(&config, rate, n, &Stream::new(8));
            for (sensor, density) in [(Sensor::Accel, 3.0e-3), (Sensor::Gyro, 1.9393e-5)] {
                let step: f64 = density / hz.sqrt();
                for axis in 0..3 {
                    let b = bias.axis(sensor, axis);
                    let variance = b.windows(2).map(|w| (w[1] - w[0]).powi(2)).sum::<f64>() / (n - 1) as f64;
                    // A sampled variance has a relative standard error of sqrt(2 / n); four of them.
                    let bound = 4.0 * (2.0 / (n - 1) as f64).sqrt();
                    assert!((variance / (step * step) - 1.0).abs() < bound, "{sensor} {axis}");
                }
            }
        }
    }

    #[test]
    fn starts_scatter_as_stated() {
        let rate = SampleRate::HZ_200;
        let n = 400;
        let sum: f64 = (0..n)
            .map(|seed| draw(&BiasConfig::default(), rate, 1, &Stream::new(seed)).gyro[0])
            .map(|b| b.iter().map(|v| (v / 0.04).powi(2)).sum::<f64>())
            .sum();
        let m = 3.0 * n as f64;
        assert!((sum - m).abs() < 4.0 * (2.0 * m).sqrt());
    }
}
