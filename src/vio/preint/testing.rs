//! Readings for the tests of this crate's inertial parts.

use super::{ImuCov, NoisySample, Preintegration, PreintegrationConfig};
use crate::state::{ImuBias, NavState};
use dpn_core::noise::{AccelBiasWalkDensity, GyroBiasWalkDensity};
use dpn_core::random::{Stream, StreamRng};
use dpn_core::{ImuNoise, ImuSample, Stamp};
use nalgebra::{SVector, Vector3};
use rand::Rng;

/// The generator of one test's case.
pub(crate) fn rng(test: &str, seed: u64) -> StreamRng {
    Stream::new(seed).named("preint").named(test).rng()
}

/// Uniform in a cube of half this side.
pub(crate) fn cube(rng: &mut impl Rng, half: f64) -> Vector3<f64> {
    Vector3::from_fn(|_, _| rng.random_range(-half..half))
}

/// A bias of the size real sensors have.
pub(crate) fn random_bias(rng: &mut impl Rng) -> ImuBias {
    ImuBias { accel: cube(rng, 0.3), gyro: cube(rng, 0.1) }
}

/// A state anywhere, turned any way.
pub(crate) fn random_state(rng: &mut impl Rng) -> NavState {
    let d = SVector::from_fn(|_, _| rng.random_range(-2.0..2.0));
    NavState { bias: random_bias(rng), ..NavState::identity().plus(&d) }
}

/// `steps + 1` readings of a lively flight, smooth in time, whatever the rate: up to 2 rad/s and 5 m/s^2 off gravity on every axis.
/// Noise differs by axis and sample. `uneven` moves stamps by up to a fifth of the step.
pub(crate) fn lively(rng: &mut impl Rng, hz: f64, steps: usize, uneven: bool) -> Vec<NoisySample> {
    let waves: Vec<[f64; 4]> = (0..6)
        .map(|_| {
            [
                rng.random_range(-1.0..1.0),
                rng.random_range(-1.0..1.0),
                rng.random_range(3.0..20.0),
                rng.random_range(0.0..6.0),
            ]
        })
        .collect();
    let wave = |axis: usize, t: f64| {
        let [offset, height, rate, phase] = waves[axis];
        offset + height * (rate * t + phase).sin()
    };
    (0..=steps)
        .map(|k| {
            let shift = if uneven { rng.random_range(-0.2..0.2) } else { 0.0 };
            let t = (k as f64 + shift) / hz;
            let accel = [2.5 * wave(3, t), 2.5 * wave(4, t), 9.81 + 2.5 * wave(5, t)];
            let sample = ImuSample {
                t: Stamp::from_ns(1_403_636_579_000_000_000).plus_seconds(t),
                gyro: [wave(0, t), wave(1, t), wave(2, t)],
                accel,
            };
            let mut sigma = |low: f64| std::array::from_fn(|_| low * rng.random_range(0.5..2.0));
            let noise = ImuNoise::from_values(sigma(0.08), sigma(0.004)).unwrap();
            NoisySample { sample, noise }
        })
        .collect()
}

/// All samples pushed.
pub(crate) fn integrate(
    config: PreintegrationConfig,
    bias: ImuBias,
    samples: &[NoisySample],
) -> Preintegration {
    let mut preint = Preintegration::new(config, bias, samples[0]);
    samples[1..].iter().for_each(|s| preint.push(*s));
    preint
}

/// A configuration with walks of these densities.
pub(crate) fn config(imu_cov: ImuCov, accel_walk: f64, gyro_walk: f64) -> PreintegrationConfig {
    PreintegrationConfig {
        imu_cov,
        accel_bias_walk: AccelBiasWalkDensity::new(accel_walk).unwrap(),
        gyro_bias_walk: GyroBiasWalkDensity::new(gyro_walk).unwrap(),
    }
}
