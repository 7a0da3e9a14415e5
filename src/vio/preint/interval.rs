//! An interval of samples, integrated.

use super::config::PreintegrationConfig;
use super::covariance::Covariance;
use super::delta::Delta;
use super::linear::{ACCEL, BIAS_DIM, GYRO, MOTION_DIM, Step};
use crate::state::{ImuBias, NavState, POSITION, ROTATION, STATE_DIM, VELOCITY};
use dpn_core::geometry::so3;
use dpn_core::{GRAVITY, ImuNoise, ImuSample};
use nalgebra::{Isometry3, SMatrix, SVector, Vector3};
use std::sync::OnceLock;

/// One sample with the noise in force.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NoisySample {
    /// The reading.
    pub sample: ImuSample,
    /// Its deviations, per axis and per sample.
    pub noise: ImuNoise,
}

/// The samples from one instant to another, as one measurement of the motion between.
#[derive(Debug, Clone)]
pub struct Preintegration {
    config: PreintegrationConfig,
    bias: ImuBias,
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
    fn new(config: &PreintegrationConfig, first: &NoisySample) -> Self {
        Self {
            delta: Delta::identity(),
            jacobian: SMatrix::zeros(),
            covariance: Covariance::new(config, &first.noise),
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
            integral: Integral::new(&config, &first),
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

    /// Merges the interval that follows, each sample with its own noise, under this interval's bias and configuration. The
    /// sample in which both meet is in both and is taken once.
    ///
    /// # After the call
    /// The same bits as if all samples had been pushed here.
    pub fn append(&mut self, later: &Preintegration) {
        let end = self.end();
        for sample in later.samples.iter().filter(|s| s.sample.t > end) {
            self.push(*sample);
        }
    }

    /// Integrates the same samples anew, with another bias.
    pub fn reintegrate(&mut self, bias: ImuBias) {
        self.bias = bias;
        let mut integral = Integral::new(&self.config, &self.samples[0]);
        for pair in self.samples.windows(2) {
            integral.advance(&self.config, &bias, &pair[0], &pair[1]);
        }
        self.integral = integral;
        self.forget();
    }

    fn forget(&mut self) {
        self.covariance.take();
        self.sqrt_information.take();
    }

    /// The bias it was integrated with.
    pub fn bias(&self) -> &ImuBias {
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

    /// The increments under [`bias`](Self::bias).
    pub fn delta(&self) -> &Delta {
        &self.integral.delta
    }

    /// The increments under another bias, to first order.
    pub fn corrected(&self, bias: &ImuBias) -> Delta {
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
