//! Every covariance model against sampled noise: each source alone and all together, at two rates.
//!
//! The model of the samples is written out here anew, as draws; only the mean comes from the code under test (and under `euler`, which
//! is a stochastic difference equation of its own, not even that).

use super::testing::{config, integrate, lively, random_bias, rng};
use super::{Delta, ImuCov, NoisySample};
use crate::factors::inertial::sqrt_information;
use crate::preint::linear::Step;
use crate::state::{ACCEL_BIAS, GYRO_BIAS, ImuBias, POSITION, ROTATION, STATE_DIM, VELOCITY};
use dpn_core::geometry::so3;
use dpn_core::{ImuNoise, Sensor};
use nalgebra::{SMatrix, SVector, UnitQuaternion, Vector3};
use rand::Rng;
use rand_distr::StandardNormal;

type Error = SVector<f64, STATE_DIM>;
type Square = SMatrix<f64, STATE_DIM, STATE_DIM>;

/// Which noise is on: standard deviations of a sample \[m/s^2, rad/s\] (times an axis' own factor), walk densities.
#[derive(Clone, Copy)]
struct Sources {
    accel: f64,
    gyro: f64,
    accel_walk: f64,
    gyro_walk: f64,
}

// Small enough that terms of second order (a rotation error of 1e-5 rad against 1) stay far below the sampling error.
const NONE: Sources = Sources { accel: 0.0, gyro: 0.0, accel_walk: 0.0, gyro_walk: 0.0 };
const SOURCES: [(&str, Sources); 5] = [
    ("accelerometer", Sources { accel: 1e-3, ..NONE }),
    ("gyro", Sources { gyro: 1e-4, ..NONE }),
    ("accelerometer's walk", Sources { accel_walk: 1e-3, ..NONE }),
    ("gyro's walk", Sources { gyro_walk: 1e-4, ..NONE }),
    ("all", Sources { accel: 1e-3, gyro: 1e-4, accel_walk: 1e-3, gyro_walk: 1e-4 }),
];

/// Draws for one case.
const DRAWS: usize = 8_000;

/// Variance of what rounding does to a draw, which shows in rows that a source does not reach.
const ROUNDING: f64 = 1e-28;

/// Noise by axis and sample, from quiet to three times as loud; of one density at any rate.
fn noisy(samples: &mut [NoisySample], sources: Sources, hz: f64) {
    let per_sample = (hz / 200.0).sqrt();
    for (k, sample) in samples.iter_mut().enumerate() {
        let factor = |axis: usize| per_sample * (2.0 + (0.7 * k as f64 + 2.0 * axis as f64).sin());
        let values = |sigma: f64| std::array::from_fn(|axis| sigma * factor(axis));
        sample.noise = ImuNoise::from_values(values(sources.accel), values(sources.gyro)).unwrap();
    }
}

fn normal(rng: &mut impl Rng) -> Vector3<f64> {
    Vector3::from_fn(|_, _| rng.sample(StandardNormal))
}

fn draw(rng: &mut impl Rng, noise: &ImuNoise, sensor: Sensor) -> Vector3<f64> {
    normal(rng).component_mul(&Vector3::from(noise.of(sensor)))
}

fn minus(sample: &NoisySample, accel: &Vector3<f64>, gyro: &Vector3<f64>) -> NoisySample {
    let mut clean = *sample;
    clean.sample.accel = (Vector3::from(clean.sample.accel) - accel).into();
    clean.sample.gyro = (Vector3::from(clean.sample.gyro) - gyro).into();
    clean
}

fn error(truth: &Delta, computed: &Delta, accel_bias: &Vector3<f64>, gyro_bias: &Vector3<f64>) -> Error {
    let mut e = Error::zeros();
    e.fixed_rows_mut::<3>(POSITION).copy_from(&(truth.position - computed.position));
    e.fixed_rows_mut::<3>(ROTATION).copy_from(&so3::log(&(computed.rotation.inverse() * truth.rotation)));
    e.fixed_rows_mut::<3>(VELOCITY).copy_from(&(truth.velocity - computed.velocity));
    e.fixed_rows_mut::<3>(ACCEL_BIAS).copy_from(accel_bias);
    e.fixed_rows_mut::<3>(GYRO_BIAS).copy_from(gyro_bias);
    e
}

/// One draw of the truth about `samples`, whose integral under `bias` is `computed`: true minus computed.
fn sampled(
    rng: &mut impl Rng,
    model: ImuCov,
    sources: Sources,
    samples: &[NoisySample],
    bias: &ImuBias,
    computed: &Delta,
) -> Error {
    let mut accel_bias = Vector3::zeros();
    let mut gyro_bias = Vector3::zeros();
    let mut truth = Delta::identity();
    let first = &samples[0].noise;
    let mut noise_0 = (draw(rng, first, Sensor::Accel), draw(rng, first, Sensor::Gyro));
    for pair in samples.windows(2) {
        let dt = pair[1].sample.t.seconds_since(pair[0].sample.t);
        let accel_step = normal(rng) * (sources.accel_walk * dt.sqrt());
        let gyro_step = normal(rng) * (sources.gyro_walk * dt.sqrt());
        let noise_1 = (draw(rng, &pair[1].noise, Sensor::Accel), draw(rng, &pair[1].noise, Sensor::Gyro));
        let (moved_accel, moved_gyro) = match model {
            // The second sample reads the bias as it is there.
            ImuCov::Exact => (accel_bias + accel_step, gyro_bias + gyro_step),
            ImuCov::Vins | ImuCov::Euler => (accel_bias, gyro_bias),
        };
        let clean_0 = minus(&pair[0], &(accel_bias + noise_0.0), &(gyro_bias + noise_0.1));
        let clean_1 = minus(&pair[1], &(moved_accel + noise_1.0), &(moved_gyro + noise_1.1));
        truth = Step::mid_point(&truth, bias, &clean_0.sample, &clean_1.sample).after;
        noise_0 = match model {
            ImuCov::Exact => noise_1,
            // The same sample, drawn once more.
            ImuCov::Vins | ImuCov::Euler => {
                (draw(rng, &pair[1].noise, Sensor::Accel), draw(rng, &pair[1].noise, Sensor::Gyro))
            }
        };
        accel_bias += accel_step;
        gyro_bias += gyro_step;
    }
    error(&truth, computed, &accel_bias, &gyro_bias)
}

/// One draw of the paper's difference equation `e <- (I + F dt) e + G dt n` along the computed rotations.
fn sampled_euler(
    rng: &mut impl Rng,
    sources: Sources,
    samples: &[NoisySample],
    bias: &ImuBias,
    rotations: &[UnitQuaternion<f64>],
) -> Error {
    let [mut p, mut theta, mut v, mut ba, mut bg] = [Vector3::zeros(); 5];
    for (pair, rotation) in samples.windows(2).zip(rotations) {
        let dt = pair[1].sample.t.seconds_since(pair[0].sample.t);
        let rate = Vector3::from(pair[0].sample.gyro) - bias.gyro;
        let force = Vector3::from(pair[0].sample.accel) - bias.accel;
        let accel = draw(rng, &pair[0].noise, Sensor::Accel);
        let gyro = draw(rng, &pair[0].noise, Sensor::Gyro);
        let v_dot = rotation * (force.cross(&theta) * -1.0 - ba - accel);
        let theta_dot = -rate.cross(&theta) - bg - gyro;
        p += dt * v;
        theta += dt * theta_dot;
        v += dt * v_dot;
        ba += normal(rng) * (sources.accel_walk * dt.sqrt());
        bg += normal(rng) * (sources.gyro_walk * dt.sqrt());
    }
    let mut e = Error::zeros();
    for (row, value) in [(POSITION, p), (ROTATION, theta), (VELOCITY, v), (ACCEL_BIAS, ba), (GYRO_BIAS, bg)] {
        e.fixed_rows_mut::<3>(row).copy_from(&value);
    }
    e
}

/// What one case gives.
struct Case {
    propagated: Square,
    sampled: Square,
    /// Mean of `|S e|^2`, where the square root `S` exists.
    mean_square: Option<f64>,
}

fn case(model: ImuCov, sources: Sources, hz: f64, steps: usize) -> Case {
    let mut rng = rng("monte carlo", steps as u64);
    let bias = random_bias(&mut rng);
    let mut samples = lively(&mut rng, hz, steps, true);
    noisy(&mut samples, sources, hz);
    let preint = integrate(config(model, sources.accel_walk, sources.gyro_walk), bias, &samples);
    let rotations: Vec<_> =
        (1..=steps).map(|n| integrate(*preint.config(), bias, &samples[..n]).delta().rotation).collect();
    let root = sqrt_information(&preint);
    let mut sum = Square::zeros();
    let mut squares = 0.0;
    for _ in 0..DRAWS {
        let e = match model {
            ImuCov::Euler => sampled_euler(&mut rng, sources, &samples, &bias, &rotations),
            _ => sampled(&mut rng, model, sources, &samples, &bias, preint.delta()),
        };
        sum += e * e.transpose();
        squares += root.map_or(0.0, |root| (root * e).norm_squared());
    }
    let draws = DRAWS as f64;
    Case {
        propagated: *preint.covariance(),
        sampled: sum / draws,
        mean_square: root.map(|_| squares / draws),
    }
}

/// Entry by entry. For `N` Gaussian draws the sampled `S_ij` has the variance `(P_ii P_jj + P_ij^2)/N` (Wishart); 5 standard
/// deviations are passed once in 1.7 million entries, and 3,000 are looked at.
fn assert_sampled(name: &str, propagated: &Square, sampled: &Square) {
    for r in 0..STATE_DIM {
        for c in 0..=r {
            let (p, s) = (propagated[(r, c)], sampled[(r, c)]);
            let variance = (propagated[(r, r)] + ROUNDING) * (propagated[(c, c)] + ROUNDING) + p * p;
            let tolerance = 5.0 * (variance / DRAWS as f64).sqrt();
            assert!(
                (p - s).abs() <= tolerance,
                "{name}: ({r}, {c}) is {p:.4e}, sampled {s:.4e} +- {tolerance:.1e}"
            );
        }
    }
}

fn check(model: ImuCov) {
    // As many steps as a frame has; and few, where what happens at the ends weighs most.
    for (hz, steps) in [(200.0, 20), (400.0, 40), (200.0, 3)] {
        for (name, sources) in SOURCES {
            let case = case(model, sources, hz, steps);
            let name = format!("{model:?}, {name}, {steps} steps at {hz} Hz");
            assert_sampled(&name, &case.propagated, &case.sampled);
            if sources.accel > 0.0 && sources.gyro > 0.0 && sources.gyro_walk > 0.0 {
                // Chi-square of 15 degrees of freedom: mean 15, variance 30. This sees the directions whose variance is small.
                let mean_square = case.mean_square.unwrap();
                let tolerance = 5.0 * (30.0 / DRAWS as f64).sqrt();
                assert!(
                    (mean_square - 15.0).abs() < tolerance,
                    "{name}: mean square {mean_square} +- {tolerance}"
                );
            }
        }
    }
}

#[test]
fn exact_is_the_covariance_of_noise_drawn_once_a_sample() {
    check(ImuCov::Exact);
}

#[test]
fn vins_is_the_covariance_of_noise_drawn_anew_for_each_use() {
    check(ImuCov::Vins);
}

#[test]
fn euler_is_the_covariance_of_the_papers_difference_equation() {
    check(ImuCov::Euler);
}

#[test]
fn the_test_tells_the_models_apart() {
    let (_, all) = SOURCES[4];
    let sampled = case(ImuCov::Exact, all, 200.0, 3).sampled;
    assert_sampled("exact", &case(ImuCov::Exact, all, 200.0, 3).propagated, &sampled);
    for other in [ImuCov::Vins, ImuCov::Euler] {
        let propagated = case(other, all, 200.0, 3).propagated;
        assert!(std::panic::catch_unwind(|| assert_sampled("other", &propagated, &sampled)).is_err());
    }
}
