//! What lines of the noise have in the covariance of an interval.
//!
//! # Process
//! On every axis `n_k = sigma_k sqrt(share) x_k`, where `(x, y)` is a state of unit variance that turns and decays,
//! ```text
//! (x, y)_{k+1} = a R (x, y)_k + sqrt(1 - a^2) w_k,   a = exp(-dt / decay),   R = turn by 2 pi f dt
//! ```
//! so that `E[x_k x_l] = a^|k-l| cos(2 pi f |t_k - t_l|)`.
//!
//! # Recursion
//! A mid-point step gives both its samples half a weight, `m <- F m + W_0 x_0 + W_1 x_1` with `W_i = G_i sigma_i sqrt(share)` (`G_0`, `G_1`
//! at the head of [`super`]). With `X = E[m x^T]`, `Y = E[m y^T]` before the step and `F` applied to both,
//! ```text
//! E[m x_1^T] = a (c X - s Y) =: U          D = a c
//! P <- F P F^T + sym(X W_0^T + U W_1^T + W_0 D W_1^T) + W_0 W_0^T + W_1 W_1^T        sym(A) = A + A^T
//! X <- U + W_0 D + W_1
//! Y <- a (s X + c Y) + W_0 a s
//! ```
//! column by column, for each axis is a process of its own. What the line says of the next interval is not carried over.

use super::colour::{LINES, NoiseColour, NoiseLine};
use super::levels::NoiseLevels;
use super::linear::{ACCEL, BIAS_DIM, GYRO, MOTION_DIM, Step};
use crate::state::{POSITION, VELOCITY};
use dpn_core::ImuNoise;
use nalgebra::{Matrix3, SMatrix, SVector};
use std::f64::consts::TAU;

type ByAxis = SMatrix<f64, MOTION_DIM, BIAS_DIM>;

/// An interval's covariance from one line of each sensor, as it grows.
#[derive(Debug, Clone)]
pub(super) struct Coloured {
    /// The accelerometer's line, and the gyro's.
    lines: [NoiseLine; 2],
    pub(super) motion: SMatrix<f64, MOTION_DIM, MOTION_DIM>,
    in_phase: ByAxis,
    quadrature: ByAxis,
}

impl Coloured {
    /// Of empty intervals, the lines of both sensors in pairs; none where there is no line. Lines are processes of their own: their covariances add up.
    pub(super) fn all(colour: &NoiseColour) -> Vec<Self> {
        let of = |k: usize| [colour.accel.0[k], colour.gyro.0[k]];
        let with_share = |lines: &[NoiseLine; 2]| lines.iter().any(|line| line.share > 0.0);
        let begun = |lines| Self {
            lines,
            motion: SMatrix::zeros(),
            in_phase: ByAxis::zeros(),
            quadrature: ByAxis::zeros(),
        };
        (0..LINES).map(of).filter(with_share).map(begun).collect()
    }

    /// How a sample at which the body is turned by `rotation` enters the step.
    fn weight(&self, step: &Step, rotation: &Matrix3<f64>, levels: &NoiseLevels, noise: &ImuNoise) -> ByAxis {
        let dt = step.transition.dt;
        let (accel, gyro) = levels.variances(noise);
        let mut weight = ByAxis::zeros();
        weight.fixed_view_mut::<3, 3>(POSITION, ACCEL).copy_from(&((0.25 * dt * dt) * rotation));
        weight.fixed_view_mut::<3, 3>(VELOCITY, ACCEL).copy_from(&((0.5 * dt) * rotation));
        let by_gyro = 0.5 * step.transition.d_motion_d_bias.fixed_view::<MOTION_DIM, 3>(0, GYRO);
        weight.fixed_view_mut::<MOTION_DIM, 3>(0, GYRO).copy_from(&by_gyro);
        for axis in 0..3 {
            let of = |variance: f64, share: f64| (variance * share).sqrt();
            weight.column_mut(ACCEL + axis).scale_mut(of(accel[axis], self.lines[0].share));
            weight.column_mut(GYRO + axis).scale_mut(of(gyro[axis], self.lines[1].share));
        }
        weight
    }

    /// One step further.
    pub(super) fn advance(&mut self, step: &Step, levels: &NoiseLevels, noises: [&ImuNoise; 2]) {
        let dt = step.transition.dt;
        let turn = |part: fn(f64) -> f64| {
            let of = self.lines.map(|line| (-dt / line.decay_s).exp() * part(TAU * line.hz * dt));
            SVector::<f64, BIAS_DIM>::from_fn(|axis, _| of[axis / 3])
        };
        let (cos, sin) = (turn(f64::cos), turn(f64::sin));
        let by_axis = |m: &ByAxis, factor: &SVector<f64, BIAS_DIM>| m * SMatrix::from_diagonal(factor);

        let before = self.weight(step, &step.rotation_0, levels, noises[0]);
        let after = self.weight(step, &step.rotation_1, levels, noises[1]);
        let transition = &step.transition;
        transition.carry(&mut self.motion);
        self.motion = self.motion.transpose();
        transition.carry(&mut self.motion);
        transition.carry(&mut self.in_phase);
        transition.carry(&mut self.quadrature);

        let turned = by_axis(&self.in_phase, &cos) - by_axis(&self.quadrature, &sin);
        let crossed =
            (self.in_phase + by_axis(&after, &cos)) * before.transpose() + turned * after.transpose();
        self.motion += crossed + crossed.transpose();
        self.motion += before * before.transpose() + after * after.transpose();
        self.quadrature =
            by_axis(&self.in_phase, &sin) + by_axis(&self.quadrature, &cos) + by_axis(&before, &sin);
        self.in_phase = turned + by_axis(&before, &cos) + after;
    }
}
