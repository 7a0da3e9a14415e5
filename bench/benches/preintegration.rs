//! One frame of IMU at 200 Hz and 10 Hz frames: 20 steps pushed, integrated anew, weighed and linearised, per covariance model; one thread.

use dpn_bench::{iterations, time};
use dpn_core::random::Stream;
use dpn_core::{ImuNoise, ImuSample, Stamp};
use dpn_vio::factors::inertial::{inertial_jacobians, sqrt_information};
use dpn_vio::preint::{ImuCov, NoisySample, Preintegration, PreintegrationConfig};
use dpn_vio::state::{ImuBias, NavState};
use rand::Rng;
use std::hint::black_box;

const STEPS: usize = 20;
/// Intervals in one timed iteration: the clock's own cost is spread over them.
const INTERVALS: usize = 100;

fn main() {
    let mut rng = Stream::new(1).named("bench").named("preintegration").rng();
    let samples: Vec<NoisySample> = (0..=STEPS as i64)
        .map(|k| {
            let mut near = |centre: f64| centre + rng.random_range(-1.0..1.0);
            let sample = ImuSample {
                t: Stamp::from_ns(k * 5_000_000),
                gyro: [near(0.0), near(0.0), near(0.0)],
                accel: [near(0.0), near(0.0), near(9.81)],
            };
            NoisySample { sample, noise: ImuNoise::baseline() }
        })
        .collect();
    for imu_cov in [ImuCov::Exact, ImuCov::Euler, ImuCov::Vins] {
        frame(imu_cov, &samples);
    }
}

fn frame(imu_cov: ImuCov, samples: &[NoisySample]) {
    let config = PreintegrationConfig { imu_cov, ..PreintegrationConfig::default() };
    let pushed = || {
        let mut preint = Preintegration::new(config, ImuBias::zero(), samples[0]);
        samples[1..].iter().for_each(|s| preint.push(*s));
        preint
    };
    let mut anew = pushed();
    let i = NavState::identity();
    let j = anew.predict(&i);
    report(imu_cov, "push, a step", STEPS, || {
        black_box(pushed());
    });
    report(imu_cov, "reintegrate, a step", STEPS, || {
        anew.reintegrate(black_box(ImuBias::zero()));
        black_box(&anew);
    });
    report(imu_cov, "push, covariance and square root, an interval", 1, || {
        black_box(sqrt_information(&pushed()));
    });
    report(imu_cov, "residual and Jacobians", 1, || {
        black_box(inertial_jacobians(black_box(&anew), &i, &j));
    });
}

fn report(imu_cov: ImuCov, what: &str, parts: usize, mut work: impl FnMut()) {
    let timing = time(iterations(300), || (0..INTERVALS).for_each(|_| work()));
    let per_part = 1e6 / (INTERVALS * parts) as f64;
    dpn_bench::keep(&format!("preintegration {imu_cov:?}, {what}"), timing.wall_ms * per_part / 1e6);
    println!("preintegration {imu_cov:?}: {what}: median {:.0} ns", timing.wall_ms * per_part);
}
