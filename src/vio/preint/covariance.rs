//! The covariance of an interval under the three models; derived at the head of [`super`].

use super::config::{ImuCov, PreintegrationConfig};
use super::levels::{ACCEL_WALK, GYRO_WALK, NoiseLevels};
use super::linear::{ACCEL, BIAS_DIM, GYRO, MOTION_DIM, Step, Transition};
use super::sample::NoisySample;
use crate::state::{ACCEL_BIAS, GYRO_BIAS, POSITION, ROTATION, STATE_DIM, VELOCITY};
use dpn_core::ImuNoise;
use nalgebra::{Matrix3, SMatrix, Vector3};

/// How one sample's noise enters `x`.
#[derive(Debug, Clone)]
struct Entry {
    /// `body_i_from_body_k` at the sample: the accelerometer's noise enters position and velocity by a multiple of it.
    rotation: Matrix3<f64>,
    /// Position \[m\] per m/s^2 of noise.
    position_weight: f64,
    /// Velocity \[m/s\] per m/s^2 of noise.
    velocity_weight: f64,
    /// From the gyro's noise.
    d_motion_d_gyro: SMatrix<f64, MOTION_DIM, 3>,
}

impl Entry {
    /// No weight yet.
    fn none() -> Self {
        Self {
            rotation: Matrix3::identity(),
            position_weight: 0.0,
            velocity_weight: 0.0,
            d_motion_d_gyro: SMatrix::zeros(),
        }
    }

    /// The half weight that a mid-point step gives to a sample at which the body is turned by `rotation`.
    fn half(step: &Step, rotation: &Matrix3<f64>) -> Self {
        let dt = step.transition.dt;
        Self {
            rotation: *rotation,
            position_weight: 0.25 * dt * dt,
            velocity_weight: 0.5 * dt,
            d_motion_d_gyro: 0.5 * step.transition.d_motion_d_bias.fixed_view::<MOTION_DIM, 3>(0, GYRO),
        }
    }

    /// What becomes of this entry over a step, with the half weight that the step adds to the same sample.
    fn continued(&self, step: &Step) -> Self {
        let mut whole = Self::half(step, &step.rotation_0);
        whole.position_weight += self.position_weight + step.transition.dt * self.velocity_weight;
        whole.velocity_weight += self.velocity_weight;
        let mut carried = self.d_motion_d_gyro;
        step.transition.carry(&mut carried);
        whole.d_motion_d_gyro += carried;
        whole
    }

    /// Adds this entry's covariance for noise of the variances given.
    fn add_to(
        &self,
        motion: &mut SMatrix<f64, MOTION_DIM, MOTION_DIM>,
        accel: &Vector3<f64>,
        gyro: &Vector3<f64>,
    ) {
        let weighted = Matrix3::from_columns(&[
            self.rotation.column(0) * accel.x,
            self.rotation.column(1) * accel.y,
            self.rotation.column(2) * accel.z,
        ]);
        let turned = weighted * self.rotation.transpose();
        let (p, v) = (self.position_weight, self.velocity_weight);
        for (row, column, weight) in [
            (POSITION, POSITION, p * p),
            (POSITION, VELOCITY, p * v),
            (VELOCITY, POSITION, v * p),
            (VELOCITY, VELOCITY, v * v),
        ] {
            let mut block = motion.fixed_view_mut::<3, 3>(row, column);
            block += weight * turned;
        }
        let mut weighted = self.d_motion_d_gyro;
        for axis in 0..3 {
            weighted.column_mut(axis).scale_mut(gyro[axis]);
        }
        *motion += weighted * self.d_motion_d_gyro.transpose();
    }
}

/// The covariance of an interval as it grows, in blocks: the biases' own is a multiple of the identity each.
#[derive(Debug, Clone)]
pub(super) struct Covariance {
    levels: NoiseLevels,
    /// Variance a second that a jump of the biases adds to their walks, accelerometer and gyro.
    jump_rate: [f64; 2],
    motion: SMatrix<f64, MOTION_DIM, MOTION_DIM>,
    motion_bias: SMatrix<f64, MOTION_DIM, BIAS_DIM>,
    accel_bias: f64,
    gyro_bias: f64,
    /// The last sample's weight and variances, which the next step completes; under `exact` alone.
    open: Option<(Entry, ImuNoise)>,
}

impl Covariance {
    /// Of an empty interval that begins with `first`, the noise told multiplied by `levels`, the variances of the biases' walks raised by
    /// `jump_rate` a second.
    pub(super) fn new(
        config: &PreintegrationConfig,
        levels: NoiseLevels,
        jump_rate: [f64; 2],
        first: &ImuNoise,
    ) -> Self {
        Self {
            levels,
            jump_rate,
            motion: SMatrix::zeros(),
            motion_bias: SMatrix::zeros(),
            accel_bias: 0.0,
            gyro_bias: 0.0,
            open: (config.imu_cov == ImuCov::Exact).then(|| (Entry::none(), *first)),
        }
    }

    /// One step further, from sample 0 to sample 1.
    pub(super) fn advance(
        &mut self,
        config: &PreintegrationConfig,
        step: &Step,
        sample_0: &NoisySample,
        sample_1: &NoisySample,
    ) {
        let dt = step.transition.dt;
        let [accel_jump, gyro_jump] = self.jump_rate.map(|rate| rate * dt);
        let accel_walk = (config.accel_bias_walk.get() * self.levels.0[ACCEL_WALK]).powi(2) * dt + accel_jump;
        let gyro_walk = (config.gyro_bias_walk.get() * self.levels.0[GYRO_WALK]).powi(2) * dt + gyro_jump;
        match config.imu_cov {
            ImuCov::Exact => {
                self.carry(&step.transition);
                let half = Entry::half(step, &step.rotation_1);
                if let Some((entry, noise)) = &self.open {
                    let (accel, gyro) = self.levels.variances(noise);
                    entry.continued(step).add_to(&mut self.motion, &accel, &gyro);
                }
                // The walk's increment is in the second sample already, with the weight of its noise and a bias's sign.
                half.add_to(&mut self.motion, &Vector3::repeat(accel_walk), &Vector3::repeat(gyro_walk));
                let mut put = |row, weight: f64| {
                    let mut block = self.motion_bias.fixed_view_mut::<3, 3>(row, ACCEL);
                    block -= (weight * accel_walk) * half.rotation;
                };
                put(POSITION, half.position_weight);
                put(VELOCITY, half.velocity_weight);
                let mut block = self.motion_bias.fixed_view_mut::<MOTION_DIM, 3>(0, GYRO);
                block += gyro_walk * half.d_motion_d_gyro;
                self.open = Some((half, sample_1.noise));
            }
            ImuCov::Vins => {
                self.carry(&step.transition);
                for (rotation, noise) in
                    [(&step.rotation_0, &sample_0.noise), (&step.rotation_1, &sample_1.noise)]
                {
                    let (accel, gyro) = self.levels.variances(noise);
                    Entry::half(step, rotation).add_to(&mut self.motion, &accel, &gyro);
                }
            }
            ImuCov::Euler => {
                let transition = Transition::euler(dt, &step.rotation_0, &step.rate_0, &step.force_0);
                self.carry(&transition);
                let (accel, gyro) = self.levels.variances(&sample_0.noise);
                let mut d_motion_d_gyro = SMatrix::<f64, MOTION_DIM, 3>::zeros();
                d_motion_d_gyro.fixed_view_mut::<3, 3>(ROTATION, 0).fill_diagonal(dt);
                let entry = Entry {
                    rotation: step.rotation_0,
                    position_weight: 0.0,
                    velocity_weight: dt,
                    d_motion_d_gyro,
                };
                entry.add_to(&mut self.motion, &accel, &gyro);
            }
        }
        self.accel_bias += accel_walk;
        self.gyro_bias += gyro_walk;
    }

    /// `F P F^T`, with the bias as part of the state.
    fn carry(&mut self, transition: &Transition) {
        transition.carry(&mut self.motion);
        self.motion = self.motion.transpose();
        transition.carry(&mut self.motion);
        transition.carry(&mut self.motion_bias);
        let mut from_bias = transition.d_motion_d_bias;
        for axis in 0..3 {
            from_bias.column_mut(ACCEL + axis).scale_mut(self.accel_bias);
            from_bias.column_mut(GYRO + axis).scale_mut(self.gyro_bias);
        }
        // F C B^T + B C^T F^T + B D B^T = Y B^T + B Y^T with Y = F C + B D / 2.
        let y = self.motion_bias + 0.5 * from_bias;
        let crossed = y * transition.d_motion_d_bias.transpose();
        self.motion += crossed + crossed.transpose();
        self.motion_bias += from_bias;
    }

    /// The whole, in the order of [`crate::state`].
    pub(super) fn assembled(&self) -> SMatrix<f64, STATE_DIM, STATE_DIM> {
        let mut motion = self.motion;
        if let Some((entry, noise)) = &self.open {
            let (accel, gyro) = self.levels.variances(noise);
            entry.add_to(&mut motion, &accel, &gyro);
        }
        let mut whole = SMatrix::<f64, STATE_DIM, STATE_DIM>::zeros();
        // Symmetric to the last bit.
        whole
            .fixed_view_mut::<MOTION_DIM, MOTION_DIM>(0, 0)
            .copy_from(&(0.5 * (motion + motion.transpose())));
        whole.fixed_view_mut::<MOTION_DIM, BIAS_DIM>(0, ACCEL_BIAS).copy_from(&self.motion_bias);
        whole.fixed_view_mut::<BIAS_DIM, MOTION_DIM>(ACCEL_BIAS, 0).copy_from(&self.motion_bias.transpose());
        whole.fixed_view_mut::<3, 3>(ACCEL_BIAS, ACCEL_BIAS).fill_diagonal(self.accel_bias);
        whole.fixed_view_mut::<3, 3>(GYRO_BIAS, GYRO_BIAS).fill_diagonal(self.gyro_bias);
        whole
    }
}

#[cfg(test)]
mod tests {
    use crate::preint::testing::{config, integrate, lively, random_bias, rng};
    use crate::preint::{ImuCov, NoisySample, Preintegration, PreintegrationConfig};
    use crate::state::{GYRO_BIAS, ImuBias, POSITION, ROTATION, STATE_DIM, VELOCITY};
    use dpn_core::noise::{AccelNoiseDensity, GyroNoiseDensity};
    use dpn_core::{ImuNoise, ImuSample, SampleRate, Stamp};

    const MODELS: [ImuCov; 3] = [ImuCov::Exact, ImuCov::Euler, ImuCov::Vins];

    /// Free fall without turning: nothing but the weights of the samples is left.
    fn falling(imu_cov: ImuCov, steps: i64) -> Preintegration {
        let samples: Vec<_> = (0..=steps)
            .map(|k| NoisySample {
                sample: ImuSample { t: Stamp::from_ns(k * 5_000_000), gyro: [0.0; 3], accel: [0.0; 3] },
                noise: ImuNoise::from_values([0.1, 0.2, 0.3], [0.01, 0.02, 0.03]).unwrap(),
            })
            .collect();
        integrate(config(imu_cov, 0.0, 0.0), ImuBias::zero(), &samples)
    }

    #[test]
    fn without_motion_the_weights_of_the_samples_can_be_summed_by_hand() {
        let (n, dt) = (20.0f64, 0.005f64);
        // Per unit of sample variance: sums of squared weights in velocity (or rotation) and position.
        let steps = || (0..20).map(f64::from);
        let inner = || (1..20).map(f64::from);
        let by_hand = [
            // Half, 1, .., 1, half; a sample k inside moves the position by n - k steps.
            (
                ImuCov::Exact,
                n - 0.5,
                inner().map(|k| (n - k).powi(2)).sum::<f64>() + (0.5 * (n - 0.5)).powi(2) + 0.0625,
            ),
            (ImuCov::Euler, n, steps().map(|k| (n - 1.0 - k).powi(2)).sum()),
            (ImuCov::Vins, n / 2.0, steps().map(|k| (n - k - 0.5).powi(2)).sum::<f64>() / 2.0),
        ];
        for (model, velocity, position) in by_hand {
            let preint = falling(model, 20);
            let covariance = preint.covariance();
            for axis in 0..3 {
                let sigma = 0.1 * (axis + 1) as f64;
                for (row, expected) in [
                    (POSITION, sigma * sigma * dt.powi(4) * position),
                    (VELOCITY, sigma * sigma * dt * dt * velocity),
                    (ROTATION, 0.01 * sigma * sigma * dt * dt * velocity),
                ] {
                    let got = covariance[(row + axis, row + axis)];
                    assert!(
                        (got / expected - 1.0).abs() < 1e-12,
                        "{model:?}, row {row}: {got} for {expected}"
                    );
                }
            }
        }
    }

    #[test]
    fn in_steady_integration_vins_counts_half_of_the_variance_and_euler_all_of_it() {
        for seed in 0..10 {
            let mut rng = rng("half", seed);
            let bias = random_bias(&mut rng);
            let mut samples = lively(&mut rng, 200.0, 100, false);
            for sample in &mut samples {
                sample.noise = ImuNoise::baseline();
            }
            let under = |model| *integrate(config(model, 0.0, 0.0), bias, &samples).covariance();
            let [exact, euler, vins] = MODELS.map(under);
            for row in 0..9 {
                // Off by the two ends, each a step in 100 and by less than twice its share, and by half a step's motion for Euler.
                let half = vins[(row, row)] / exact[(row, row)];
                let whole = euler[(row, row)] / exact[(row, row)];
                assert!((half - 0.5).abs() < 0.01, "row {row}: vins is {half} of exact");
                assert!((whole - 1.0).abs() < 0.04, "row {row}: euler is {whole} of exact");
            }
        }
    }

    #[test]
    fn one_density_gives_one_covariance_at_any_rate() {
        for model in MODELS {
            let at = |hz: f64| {
                let mut rng = rng("rate", 5);
                let bias = random_bias(&mut rng);
                let mut samples = lively(&mut rng, hz, hz as usize, false);
                let rate = SampleRate::from_hz(hz).unwrap();
                let noise = ImuNoise::isotropic(
                    AccelNoiseDensity::EUROC.to_sample_std(rate),
                    GyroNoiseDensity::EUROC.to_sample_std(rate),
                );
                for sample in &mut samples {
                    sample.noise = noise;
                }
                *integrate(PreintegrationConfig { imu_cov: model, ..Default::default() }, bias, &samples)
                    .covariance()
            };
            let (slow, fast) = (at(200.0), at(400.0));
            for row in 0..STATE_DIM {
                let ratio = slow[(row, row)] / fast[(row, row)];
                // A second long: ends weigh 1/200. Euler's position lags by half a step in each of three factors.
                assert!((ratio - 1.0).abs() < 0.015, "{model:?}, row {row}: {ratio}");
                assert!(
                    row < GYRO_BIAS || (ratio - 1.0).abs() < 1e-9,
                    "{model:?}: the walk's variance is a density's"
                );
            }
        }
    }

    #[test]
    fn every_model_reads_the_noise_of_each_sample_it_weighs_and_no_other() {
        let mut rng = rng("which noise", 2);
        let bias = random_bias(&mut rng);
        let samples = lively(&mut rng, 200.0, 10, true);
        let loud = ImuNoise::from_values([7.0; 3], [0.5; 3]).unwrap();
        for model in MODELS {
            let quiet = integrate(config(model, 1e-3, 1e-4), bias, &samples);
            for k in 0..samples.len() {
                let mut changed = samples.clone();
                changed[k].noise = loud;
                let changed = integrate(config(model, 1e-3, 1e-4), bias, &changed);
                let grew = changed.covariance()[(VELOCITY, VELOCITY)]
                    > 1.5 * quiet.covariance()[(VELOCITY, VELOCITY)];
                // Euler takes the reading at the beginning of a step; the last begins none.
                let weighed = model != ImuCov::Euler || k + 1 < samples.len();
                assert_eq!(grew, weighed, "{model:?}, sample {k}");
                assert_eq!(changed.covariance() == quiet.covariance(), !weighed);
            }
        }
    }
}
