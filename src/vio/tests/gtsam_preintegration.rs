//! Pre-integration against GTSAM; the cases are described in `golden/gtsam_preintegration/make.py`.

use dpn_core::geometry::so3;
use dpn_core::noise::{
    AccelBiasWalkDensity, AccelNoiseDensity, GyroBiasWalkDensity, GyroNoiseDensity, ImuNoise,
};
use dpn_core::{ImuSample, SampleRate, Stamp};
use dpn_vio::preint::{ImuCov, NoisySample, Preintegration, PreintegrationConfig};
use dpn_vio::state::{GYRO_BIAS, ImuBias, NavState, POSITION, ROTATION, VELOCITY};
use nalgebra::{DMatrix, Isometry3, Matrix, Quaternion, RawStorage, UnitQuaternion, Vector3};
use serde::Deserialize;

#[derive(Deserialize)]
struct Golden {
    steps: Vec<Steps>,
    continuum: Vec<Continuum>,
}

#[derive(Deserialize)]
struct Pose {
    rotation_wxyz: [f64; 4],
    position: [f64; 3],
    velocity: [f64; 3],
}

#[derive(Deserialize)]
struct Steps {
    t_ns: Vec<i64>,
    gyro: Vec<[f64; 3]>,
    accel: Vec<[f64; 3]>,
    accel_bias: [f64; 3],
    gyro_bias: [f64; 3],
    #[serde(flatten)]
    delta: Pose,
    state_i: Pose,
    state_j: Pose,
}

#[derive(Deserialize)]
struct Continuum {
    duration: f64,
    gyro_waves: [[f64; 4]; 3],
    accel_waves: [[f64; 4]; 3],
    accel_bias: [f64; 3],
    gyro_bias: [f64; 3],
    accel_density: [f64; 3],
    gyro_density: [f64; 3],
    accel_walk: f64,
    gyro_walk: f64,
    expected: Expected,
}

#[derive(Deserialize)]
struct Expected {
    rotation_vector: [f64; 3],
    position: [f64; 3],
    velocity: [f64; 3],
    jacobian: Vec<Vec<f64>>,
    covariance_white: Vec<Vec<f64>>,
    covariance: Vec<Vec<f64>>,
}

fn golden() -> Golden {
    dpn_testing::golden("gtsam_preintegration")
}

fn rotation(wxyz: [f64; 4]) -> UnitQuaternion<f64> {
    UnitQuaternion::new_normalize(Quaternion::new(wxyz[0], wxyz[1], wxyz[2], wxyz[3]))
}

fn state(pose: &Pose, bias: ImuBias) -> NavState {
    NavState {
        world_from_body: Isometry3::from_parts(
            Vector3::from(pose.position).into(),
            rotation(pose.rotation_wxyz),
        ),
        vel_in_world: pose.velocity.into(),
        bias,
    }
}

fn pushed(config: PreintegrationConfig, bias: ImuBias, samples: &[NoisySample]) -> Preintegration {
    let mut preint = Preintegration::new(config, bias, samples[0]);
    samples[1..].iter().for_each(|s| preint.push(*s));
    preint
}

#[test]
fn increments_and_predicted_states_are_gtsams() {
    for case in golden().steps {
        let samples: Vec<_> = case
            .t_ns
            .iter()
            .zip(case.gyro.iter().zip(&case.accel))
            .map(|(&t, (&gyro, &accel))| NoisySample {
                sample: ImuSample { t: Stamp::from_ns(t), gyro, accel },
                noise: ImuNoise::baseline(),
            })
            .collect();
        let bias = ImuBias { accel: case.accel_bias.into(), gyro: case.gyro_bias.into() };
        let preint = pushed(PreintegrationConfig::default(), bias, &samples);
        let delta = preint.delta();
        let turned = so3::log(&(rotation(case.delta.rotation_wxyz).inverse() * delta.rotation));
        assert!(turned.norm() < 1e-13, "{turned}");
        assert!((delta.position - Vector3::from(case.delta.position)).norm() < 1e-13);
        assert!((delta.velocity - Vector3::from(case.delta.velocity)).norm() < 1e-13);

        let end = preint.predict(&state(&case.state_i, bias));
        let off = end.minus(&state(&case.state_j, bias));
        assert!(off.norm() < 1e-12, "{off}");
    }
}

impl Continuum {
    fn integrated(&self, hz: f64, imu_cov: ImuCov, walks: bool) -> Preintegration {
        let wave = |c: &[[f64; 4]; 3], t: f64| c.map(|c| c[0] + c[1] * (c[2] * t + c[3]).sin());
        let rate = SampleRate::from_hz(hz).unwrap();
        let noise = ImuNoise {
            accel: self.accel_density.map(|d| AccelNoiseDensity::new(d).unwrap().to_sample_std(rate)),
            gyro: self.gyro_density.map(|d| GyroNoiseDensity::new(d).unwrap().to_sample_std(rate)),
        };
        let samples: Vec<_> = (0..=(self.duration * hz).round() as usize)
            .map(|k| {
                let t = k as f64 / hz;
                let sample = ImuSample {
                    t: Stamp::from_ns(0).plus_seconds(t),
                    gyro: wave(&self.gyro_waves, t),
                    accel: wave(&self.accel_waves, t),
                };
                NoisySample { sample, noise }
            })
            .collect();
        let on = f64::from(u8::from(walks));
        let config = PreintegrationConfig {
            imu_cov,
            accel_bias_walk: AccelBiasWalkDensity::new(on * self.accel_walk).unwrap(),
            gyro_bias_walk: GyroBiasWalkDensity::new(on * self.gyro_walk).unwrap(),
        };
        let bias = ImuBias { accel: self.accel_bias.into(), gyro: self.gyro_bias.into() };
        pushed(config, bias, &samples)
    }
}

/// The corner of `got` that `expected` covers, over `factor`; each entry relative to the root of its row's and its column's diagonal.
fn largest_off<R: nalgebra::Dim, C: nalgebra::Dim, S: RawStorage<f64, R, C>>(
    got: &Matrix<f64, R, C, S>,
    factor: f64,
    expected: &[Vec<f64>],
) -> f64 {
    let n = expected.len();
    let scale = |k: usize| expected[k][k].sqrt();
    (0..n)
        .flat_map(|r| (0..n).map(move |c| (r, c)))
        .map(|(r, c)| (got[(r, c)] / factor - expected[r][c]).abs() / (scale(r) * scale(c)))
        .fold(0.0, f64::max)
}

#[test]
fn mean_and_bias_jacobian_go_to_gtsams_limit_in_second_order() {
    for case in golden().continuum {
        let expected = &case.expected;
        let limit = DMatrix::from_fn(9, 6, |r, c| expected.jacobian[r][c]);
        let errors = |hz: f64| {
            let preint = case.integrated(hz, ImuCov::Vins, false);
            let delta = preint.delta();
            let turned = so3::exp(&Vector3::from(expected.rotation_vector)).inverse() * delta.rotation;
            [
                (delta.position - Vector3::from(expected.position)).norm(),
                so3::log(&turned).norm(),
                (delta.velocity - Vector3::from(expected.velocity)).norm(),
                (DMatrix::from_fn(9, 6, |r, c| preint.jacobian()[(r, c)]) - &limit).norm(),
            ]
        };
        let (slow, fast) = (errors(200.0), errors(400.0));
        for (quantity, (slow, fast)) in slow.into_iter().zip(fast).enumerate() {
            // 200 Hz, waves of up to 20 rad/s: (w dt)^2/12 = 8e-4 of what the wave adds.
            assert!(slow < 1e-3, "quantity {quantity}: {slow:.3e}");
            assert!((slow / fast - 4.0).abs() < 0.1, "quantity {quantity}: {slow:.3e}, {fast:.3e}");
        }
    }
}

#[test]
fn covariances_go_to_gtsams_limit_and_that_of_vins_to_half_of_it() {
    for case in golden().continuum {
        for (model, share) in [(ImuCov::Exact, 1.0), (ImuCov::Euler, 1.0), (ImuCov::Vins, 0.5)] {
            let off = |hz: f64| {
                let preint = case.integrated(hz, model, false);
                largest_off(preint.covariance(), share, &case.expected.covariance_white)
            };
            let (slow, fast) = (off(1000.0), off(2000.0));
            // First order at worst: the ends' half samples, Euler's lag.
            assert!(fast < 0.01 && fast < 0.6 * slow, "{model:?}: off by {slow:.2e}, then {fast:.2e}");
        }
        for model in [ImuCov::Exact, ImuCov::Euler] {
            let off = |hz: f64| {
                largest_off(case.integrated(hz, model, true).covariance(), 1.0, &case.expected.covariance)
            };
            let (slow, fast) = (off(1000.0), off(2000.0));
            assert!(fast < 0.01 && fast < 0.6 * slow, "{model:?}, walks: off by {slow:.2e}, then {fast:.2e}");
        }
    }
}

#[test]
fn walks_weigh_enough_in_the_golden_cases_to_be_seen() {
    for case in golden().continuum {
        let without = case.integrated(1000.0, ImuCov::Exact, false);
        for row in [POSITION, ROTATION, VELOCITY] {
            let whole = case.expected.covariance[row][row];
            assert!(without.covariance()[(row, row)] < 0.97 * whole, "row {row}");
        }
        assert!(largest_off(without.covariance(), 1.0, &case.expected.covariance) > 0.1);
        assert!(case.expected.covariance[GYRO_BIAS][ROTATION] < 0.0, "the sign is that of true - computed");
    }
}
