//! An interval of samples, integrated.

use super::config::PreintegrationConfig;
use super::covariance::Covariance;
use super::delta::Delta;
use super::levels::{COMPONENTS, NoiseLevels};
use super::linear::{ACCEL, BIAS_DIM, GYRO, MOTION_DIM, Step};
use super::sample::NoisySample;
use crate::state::{ImuBias, NavState, POSITION, ROTATION, STATE_DIM, VELOCITY};
use dpn_core::geometry::so3;
use dpn_core::noise::units::BadNoise;
use dpn_core::{GRAVITY, ImuNoise, Sensor};
use nalgebra::{Isometry3, SMatrix, SVector, Vector3};
use std::sync::OnceLock;

/// The samples from one instant to another, as one measurement of the motion between.
#[derive(Debug, Clone)]
pub struct Preintegration {
    config: PreintegrationConfig,
    bias: ImuBias,
    levels: NoiseLevels,
    /// Variances of a jump of the biases somewhere in the interval, accelerometer and gyro; zero where none is known of.
    jump: [f64; 2],
    samples: Vec<NoisySample>,
    integral: Integral,
    covariance: OnceLock<SMatrix<f64, STATE_DIM, STATE_DIM>>,
    sqrt_information: OnceLock<Option<SMatrix<f64, STATE_DIM, STATE_DIM>>>,
}

/// All that grows step by step.
#[derive(Debug, Clone)]
struct Integral {
    delta: Delta,
    jacobian: SMatrix<f64, MOTION_DIM, BIAS_DIM>,
    covariance: Covariance,
}

impl Integral {
    fn new(
        config: &PreintegrationConfig,
        levels: NoiseLevels,
        jump_rate: [f64; 2],
        first: &NoisySample,
    ) -> Self {
        Self {
            delta: Delta::identity(),
            jacobian: SMatrix::zeros(),
            covariance: Covariance::new(config, levels, jump_rate, &first.noise),
        }
    }

    fn advance(
        &mut self,
        config: &PreintegrationConfig,
        bias: &ImuBias,
        sample_0: &NoisySample,
        sample_1: &NoisySample,
    ) {
        let step = Step::mid_point(&self.delta, bias, &sample_0.sample, &sample_1.sample);
        step.transition.carry(&mut self.jacobian);
        self.jacobian += step.transition.d_motion_d_bias;
        self.covariance.advance(config, &step, sample_0, sample_1);
        self.delta = step.after;
    }
}

impl Preintegration {
    /// An empty interval that begins at `first`, to be integrated with `bias`.
    pub fn new(config: PreintegrationConfig, bias: ImuBias, first: NoisySample) -> Self {
        Self {
            config,
            bias,
            levels: NoiseLevels::TOLD,
            jump: [0.0; 2],
            integral: Integral::new(&config, NoiseLevels::TOLD, [0.0; 2], &first),
            samples: vec![first],
            covariance: OnceLock::new(),
            sqrt_information: OnceLock::new(),
        }
    }

    /// Integrates from the last sample to this one, by the mid-point of both. Stamps increase, as a recording's do.
    pub fn push(&mut self, sample: NoisySample) {
        if let Some(last) = self.samples.last() {
            self.integral.advance(&self.config, &self.bias, last, &sample);
        }
        self.samples.push(sample);
        self.forget();
    }

    /// Merges the interval that follows, each sample with its own noise, under this interval's bias, levels and configuration. The
    /// sample in which both meet is in both and is taken once. Jumps of the biases in either are in the whole.
    ///
    /// # After the call
    /// The same bits as if all samples had been pushed here.
    pub(crate) fn append(&mut self, later: &Preintegration) {
        let end = self.end();
        let jump = [0, 1].map(|sensor| self.jump[sensor] + later.jump[sensor]);
        if jump != [0.0; 2] {
            self.jump = jump;
            self.samples.extend(later.samples.iter().filter(|s| s.sample.t > end));
            self.reintegrate(self.bias);
            return;
        }
        for sample in later.samples.iter().filter(|s| s.sample.t > end) {
            self.push(*sample);
        }
    }

    /// Integrates the same samples anew, with another bias.
    pub fn reintegrate(&mut self, bias: ImuBias) {
        self.bias = bias;
        let mut integral = Integral::new(&self.config, self.levels, self.jump_rate(), &self.samples[0]);
        for pair in self.samples.windows(2) {
            integral.advance(&self.config, &bias, &pair[0], &pair[1]);
        }
        self.integral = integral;
        self.forget();
    }

    /// Multiplies the noise told, of the samples here and of those to come: integrates anew, where the levels are others.
    pub(crate) fn set_levels(&mut self, levels: NoiseLevels) {
        if levels != self.levels {
            self.levels = levels;
            self.reintegrate(self.bias);
        }
    }

    /// Says that the biases jumped somewhere in the interval, by a change of the deviations `std` an axis, accelerometer \[m/s^2\] and gyro
    /// \[rad/s\]; zeros say that they did not. When is not known: the walks of the interval are raised to have gone as far.
    pub(crate) fn set_jump(&mut self, std: [f64; 2]) {
        self.jump = std.map(|std| std * std);
        self.reintegrate(self.bias);
    }

    /// Variances of a jump of the biases that was said to be in the interval, accelerometer and gyro.
    pub(crate) fn jump(&self) -> [f64; 2] {
        self.jump
    }

    /// Variance that a jump adds to the walks a second.
    fn jump_rate(&self) -> [f64; 2] {
        let duration = self.duration();
        self.jump.map(|variance| if variance == 0.0 { 0.0 } else { variance / duration })
    }

    /// By what the noise told is multiplied.
    pub(crate) fn levels(&self) -> &NoiseLevels {
        &self.levels
    }

    /// What each component has in the covariance, in the order of [`COMPONENTS`]; their sum is [`Self::covariance`], but for a jump's share.
    pub(crate) fn components(&self) -> [SMatrix<f64, STATE_DIM, STATE_DIM>; COMPONENTS] {
        let first = &self.samples[0].noise;
        let mut parts: [Covariance; COMPONENTS] =
            std::array::from_fn(|k| Covariance::new(&self.config, self.levels.only(k), [0.0; 2], first));
        let mut delta = Delta::identity();
        for pair in self.samples.windows(2) {
            let step = Step::mid_point(&delta, &self.bias, &pair[0].sample, &pair[1].sample);
            for part in &mut parts {
                part.advance(&self.config, &step, &pair[0], &pair[1]);
            }
            delta = step.after;
        }
        parts.map(|part| part.assembled())
    }

    /// The same samples integrated with another bias, their noise `accel` and `gyro` times as large.
    ///
    /// # Errors
    /// A factor that makes a deviation negative or not finite.
    pub(crate) fn with_noise_scaled(&self, bias: ImuBias, accel: f64, gyro: f64) -> Result<Self, BadNoise> {
        let scaled = |s: &NoisySample| -> Result<NoisySample, BadNoise> {
            let [a, g] = [(Sensor::Accel, accel), (Sensor::Gyro, gyro)]
                .map(|(sensor, factor)| s.noise.of(sensor).map(|std| factor * std));
            Ok(NoisySample { noise: ImuNoise::from_values(a, g)?, ..*s })
        };
        let mut out = Self::new(self.config, bias, scaled(&self.samples[0])?);
        for sample in &self.samples[1..] {
            out.push(scaled(sample)?);
        }
        Ok(out)
    }

    fn forget(&mut self) {
        self.covariance.take();
        self.sqrt_information.take();
    }

    /// What it was integrated under.
    pub fn config(&self) -> &PreintegrationConfig {
        &self.config
    }

    /// The bias it was integrated with.
    pub(crate) fn bias(&self) -> &ImuBias {
        &self.bias
    }

    /// The samples, oldest first, with their noise; at least one.
    pub fn samples(&self) -> &[NoisySample] {
        &self.samples
    }

    fn end(&self) -> dpn_core::Stamp {
        self.samples[self.samples.len() - 1].sample.t
    }

    /// From the first sample to the last \[s\].
    pub fn duration(&self) -> f64 {
        self.end().seconds_since(self.samples[0].sample.t)
    }

    /// The increments under the bias it was integrated with.
    pub fn delta(&self) -> &Delta {
        &self.integral.delta
    }

    /// The increments under another bias, to first order.
    pub(crate) fn corrected(&self, bias: &ImuBias) -> Delta {
        let mut shift = SVector::<f64, BIAS_DIM>::zeros();
        shift.fixed_rows_mut::<3>(ACCEL).copy_from(&(bias.accel - self.bias.accel));
        shift.fixed_rows_mut::<3>(GYRO).copy_from(&(bias.gyro - self.bias.gyro));
        let moved = self.integral.jacobian * shift;
        let delta = &self.integral.delta;
        Delta {
            rotation: delta.rotation * so3::exp(&moved.fixed_rows::<3>(ROTATION).into_owned()),
            velocity: delta.velocity + moved.fixed_rows::<3>(VELOCITY),
            position: delta.position + moved.fixed_rows::<3>(POSITION),
        }
    }

    /// The covariance of the inertial residual, in the order of [`crate::state`] \[m, rad, m/s, m/s^2, rad/s\].
    pub fn covariance(&self) -> &SMatrix<f64, STATE_DIM, STATE_DIM> {
        self.covariance.get_or_init(|| self.integral.covariance.assembled())
    }

    /// `d (position, rotation, velocity) / d (accelerometer bias, gyro bias)`; the rotation on the right.
    pub fn jacobian(&self) -> &SMatrix<f64, MOTION_DIM, BIAS_DIM> {
        &self.integral.jacobian
    }

    /// The cached square root of the information; see [`crate::factors::inertial::sqrt_information`].
    pub(crate) fn sqrt_information_with(
        &self,
        root: impl FnOnce(&SMatrix<f64, STATE_DIM, STATE_DIM>) -> Option<SMatrix<f64, STATE_DIM, STATE_DIM>>,
    ) -> Option<SMatrix<f64, STATE_DIM, STATE_DIM>> {
        *self.sqrt_information.get_or_init(|| root(self.covariance()))
    }

    /// The state at the interval's end for a state at its beginning, under the latter's bias to first order.
    ///
    /// The inertial residual between both is zero.
    pub fn predict(&self, state_i: &NavState) -> NavState {
        let delta = self.corrected(&state_i.bias);
        let duration = self.duration();
        let gravity_in_world = Vector3::new(0.0, 0.0, -GRAVITY);
        let r_wb = state_i.world_from_body.rotation;
        let position_in_world = state_i.world_from_body.translation.vector
            + state_i.vel_in_world * duration
            + gravity_in_world * (0.5 * duration * duration)
            + r_wb * delta.position;
        NavState {
            world_from_body: Isometry3::from_parts(position_in_world.into(), r_wb * delta.rotation),
            vel_in_world: state_i.vel_in_world + gravity_in_world * duration + r_wb * delta.velocity,
            bias: state_i.bias,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::preint::ImuCov;
    use crate::preint::testing::{config, cube, integrate, lively, random_bias, random_state, rng};
    use dpn_core::ImuSample;
    use dpn_sim::{Flight, FlightConfig, StampPattern, simulate};
    use dpn_testing::check_jacobian;
    use nalgebra::DVector;

    const MODELS: [ImuCov; 3] = [ImuCov::Exact, ImuCov::Euler, ImuCov::Vins];

    fn default(imu_cov: ImuCov) -> PreintegrationConfig {
        PreintegrationConfig { imu_cov, ..PreintegrationConfig::default() }
    }

    fn shifted(bias: &ImuBias, d: &DVector<f64>) -> ImuBias {
        ImuBias {
            accel: bias.accel + Vector3::from_column_slice(&d.as_slice()[ACCEL..ACCEL + 3]),
            gyro: bias.gyro + Vector3::from_column_slice(&d.as_slice()[GYRO..GYRO + 3]),
        }
    }

    fn difference(to: &Delta, from: &Delta) -> DVector<f64> {
        let rotation = so3::log(&(from.rotation.inverse() * to.rotation));
        DVector::from_iterator(
            MOTION_DIM,
            (to.position - from.position)
                .iter()
                .chain(rotation.iter())
                .chain((to.velocity - from.velocity).iter())
                .copied(),
        )
    }

    #[test]
    fn the_bias_jacobian_is_the_derivative_of_what_is_computed() {
        for seed in 0..20 {
            let mut rng = rng("bias jacobian", seed);
            let bias = random_bias(&mut rng);
            let samples = lively(&mut rng, 200.0, 40, true);
            let preint = integrate(default(ImuCov::Exact), bias, &samples);
            check_jacobian("d_delta_d_bias", preint.jacobian(), 1e-8, |d| {
                let mut other = preint.clone();
                other.reintegrate(shifted(&bias, d));
                difference(other.delta(), preint.delta())
            });
        }
    }

    #[test]
    fn the_bias_update_errs_in_second_order_only() {
        for seed in 0..10 {
            let mut rng = rng("bias update", seed);
            let bias = random_bias(&mut rng);
            let preint = integrate(default(ImuCov::Exact), bias, &lively(&mut rng, 200.0, 40, true));
            let direction = ImuBias { accel: cube(&mut rng, 0.1), gyro: cube(&mut rng, 0.05) };
            let error_at = |scale: f64| {
                let moved = ImuBias {
                    accel: bias.accel + scale * direction.accel,
                    gyro: bias.gyro + scale * direction.gyro,
                };
                let mut anew = preint.clone();
                anew.reintegrate(moved);
                difference(&preint.corrected(&moved), anew.delta()).norm()
            };
            let (whole, half) = (error_at(1.0), error_at(0.5));
            // A quarter, and terms of third order beside it.
            assert!((whole / half - 4.0).abs() < 0.2, "seed {seed}: {whole:.3e} and {half:.3e}");
            // 40 steps are .2 s; a bias off by .05 rad/s turns .01 rad, whose square half is 5e-5 of the 2 m/s gained.
            assert!(whole < 3e-4, "seed {seed}: {whole:.3e}");
        }
    }

    #[test]
    fn appending_and_integrating_anew_give_the_bits_of_pushing_all() {
        for imu_cov in MODELS {
            let mut rng = rng("append", 1);
            let bias = random_bias(&mut rng);
            let samples = lively(&mut rng, 200.0, 30, true);
            let all = integrate(default(imu_cov), bias, &samples);
            let mut merged = integrate(default(imu_cov), bias, &samples[..=12]);
            let _ = merged.covariance();
            merged.append(&integrate(default(imu_cov), random_bias(&mut rng), &samples[12..]));
            let mut anew = integrate(default(imu_cov), random_bias(&mut rng), &samples);
            let _ = anew.covariance();
            anew.reintegrate(bias);
            for other in [merged, anew] {
                assert_eq!(other.samples(), all.samples());
                assert_eq!(other.delta(), all.delta());
                assert_eq!(other.jacobian(), all.jacobian());
                assert_eq!(other.covariance(), all.covariance());
                assert_eq!(other.duration().to_bits(), all.duration().to_bits());
            }
        }
    }

    #[test]
    fn levels_are_noise_told_so_and_components_add_up_to_the_covariance() {
        let mut rng = rng("levels", 1);
        let bias = random_bias(&mut rng);
        let samples = lively(&mut rng, 200.0, 30, true);
        let levels = NoiseLevels([3.0, 2.0, 1.0, 0.5, 4.0, 7.0, 20.0, 5.0]);
        let told: Vec<_> = samples
            .iter()
            .map(|s| NoisySample { noise: levels.applied_to(&s.noise).unwrap(), ..*s })
            .collect();
        for imu_cov in MODELS {
            let mut preint = integrate(config(imu_cov, 1e-3, 1e-4), bias, &samples);
            preint.set_levels(levels);
            assert_eq!(preint.delta(), integrate(config(imu_cov, 1e-3, 1e-4), bias, &samples).delta());
            let expected = integrate(config(imu_cov, 2e-2, 5e-4), bias, &told);
            let scale = expected.covariance().diagonal().map(f64::sqrt);
            let off = |a: &SMatrix<f64, STATE_DIM, STATE_DIM>| {
                let difference = a - expected.covariance();
                SMatrix::<f64, STATE_DIM, STATE_DIM>::from_fn(|r, c| {
                    difference[(r, c)] / (scale[r] * scale[c])
                })
                .amax()
            };
            assert!(off(preint.covariance()) < 1e-12);
            assert!(off(&preint.components().iter().sum()) < 1e-12);
        }
    }

    #[test]
    fn noise_scaled_is_noise_told_so_from_the_start() {
        let mut rng = rng("scaled", 1);
        let (bias, other) = (random_bias(&mut rng), random_bias(&mut rng));
        let samples = lively(&mut rng, 200.0, 30, true);
        let told: Vec<_> = samples
            .iter()
            .map(|s| {
                let [accel, gyro] = [(Sensor::Accel, 3.0), (Sensor::Gyro, 0.5)]
                    .map(|(sensor, factor)| s.noise.of(sensor).map(|std| factor * std));
                NoisySample { noise: ImuNoise::from_values(accel, gyro).unwrap(), ..*s }
            })
            .collect();
        for imu_cov in MODELS {
            let preint = integrate(default(imu_cov), other, &samples);
            let scaled = preint.with_noise_scaled(bias, 3.0, 0.5).unwrap();
            let expected = integrate(default(imu_cov), bias, &told);
            assert_eq!(scaled.delta(), expected.delta());
            assert_eq!(scaled.covariance(), expected.covariance());
            assert!(preint.with_noise_scaled(bias, f64::NAN, 1.0).is_err());
        }
    }

    #[test]
    fn a_single_sample_moves_nothing() {
        let mut rng = rng("single", 1);
        let preint = Preintegration::new(
            default(ImuCov::Exact),
            random_bias(&mut rng),
            lively(&mut rng, 200.0, 1, false)[0],
        );
        assert_eq!(preint.delta(), &Delta::identity());
        assert_eq!(preint.duration(), 0.0);
        assert_eq!(preint.covariance().norm(), 0.0);
        let state = random_state(&mut rng);
        assert!(preint.predict(&state).minus(&state).norm() < 1e-15);
    }

    #[test]
    fn the_noise_of_the_samples_does_not_reach_the_mean() {
        let mut rng = rng("mean", 1);
        let bias = random_bias(&mut rng);
        let samples = lively(&mut rng, 200.0, 20, true);
        let loud: Vec<_> = samples
            .iter()
            .map(|s| NoisySample { noise: ImuNoise::from_values([1e9; 3], [1e9; 3]).unwrap(), ..*s })
            .collect();
        for imu_cov in MODELS {
            let (a, b) = (
                integrate(default(imu_cov), bias, &samples),
                integrate(config(ImuCov::Vins, 1e9, 1e9), bias, &loud),
            );
            assert_eq!(a.delta(), b.delta());
            assert_eq!(a.jacobian(), b.jacobian());
        }
    }

    /// Largest error of the predicted position \[m\] and velocity \[m/s\] and rotation \[rad\] over intervals of half a second.
    fn errors_along_a_flight(hz: f64) -> [f64; 3] {
        let mut quiet = FlightConfig {
            rate_hz: dpn_core::SampleRate::from_hz(hz).unwrap(),
            stamps: StampPattern::Exact,
            ..FlightConfig::default()
        };
        // At the frame's shaking, 27 Hz, these rates are too low for the order to be seen.
        quiet.vibration.scale = 0.0;
        let flight = simulate(Flight::ALL[0], 3, &quiet).unwrap();
        let t0 = flight.recording.samples()[0].t;
        let mut worst = [0.0f64; 3];
        for start in [20.0, 30.0, 40.0, 50.0] {
            let state_at = |t: f64| {
                let state = flight.trajectory.state(t);
                NavState {
                    world_from_body: Isometry3::from_parts(
                        state.position_in_world.into(),
                        state.world_from_body,
                    ),
                    vel_in_world: state.vel_in_world,
                    bias: ImuBias::zero(),
                }
            };
            let samples: Vec<_> = (0..=(hz * 0.5) as usize)
                .map(|k| {
                    let t = start + k as f64 / hz;
                    let pose = flight.trajectory.pose(t);
                    let force = flight.trajectory.state(t).acc_in_world + Vector3::new(0.0, 0.0, GRAVITY);
                    let sample = ImuSample {
                        t: t0.plus_seconds(t),
                        gyro: flight.trajectory.state(t).gyro_in_body.into(),
                        accel: (pose.rotation.inverse() * force).into(),
                    };
                    NoisySample { sample, noise: ImuNoise::baseline() }
                })
                .collect();
            let preint = integrate(default(ImuCov::Exact), ImuBias::zero(), &samples);
            let error = state_at(start + 0.5).minus(&preint.predict(&state_at(start)));
            for (worst, row) in worst.iter_mut().zip([POSITION, VELOCITY, ROTATION]) {
                *worst = worst.max(error.fixed_rows::<3>(row).norm());
            }
        }
        worst
    }

    #[test]
    fn true_readings_lead_along_the_true_flight() {
        let (slow, fast) = (errors_along_a_flight(100.0), errors_along_a_flight(200.0));
        for (name, slow, fast) in
            [("m", slow[0], fast[0]), ("m/s", slow[1], fast[1]), ("rad", slow[2], fast[2])]
        {
            // Second order: twice the rate, a quarter of the error.
            assert!((slow / fast - 4.0).abs() < 0.5, "{slow:.3e} and {fast:.3e} {name}");
            assert!(fast < 1e-3, "{fast:.3e} {name}");
        }
    }
}
