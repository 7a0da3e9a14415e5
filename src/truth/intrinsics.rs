//! Scale and misalignment of both sensors, beside all else.
//!
//! Readings are `x = (I + M) x_true + b + noise`: of the accelerometer M is lower triangular, which makes its axes the body's; of the gyro it is full. 15 numbers. After the adjustment has come
//! to rest they are asked for together with all its unknowns, in one more Gauss-Newton step whose derivatives by them are differences, by the motion between two keys: of so small numbers the rows are linear.

use crate::adjust::Adjusted;
use crate::chain::Chain;
use crate::layout::{CONSTANTS, KEY_DIM};
use crate::problem::{Problem, add};
use dpn_core::geometry::so3;
use dpn_core::{GRAVITY, ImuSample};
use nalgebra::{Matrix3, SMatrix, Vector3};

/// Unknown numbers of both matrices.
pub(crate) const INTRINSICS: usize = 15;
const ALL: usize = CONSTANTS + INTRINSICS;
/// What is known of each beforehand, a deviation: no sensor that is sold is off by more than some per cent.
pub(crate) const PRIOR: f64 = 0.03;
/// Row and column of each number: accelerometer's, then gyro's.
const PLACES: [(usize, usize, usize); INTRINSICS] = [
    (0, 0, 0),
    (0, 1, 1),
    (0, 2, 2),
    (0, 1, 0),
    (0, 2, 0),
    (0, 2, 1),
    (1, 0, 0),
    (1, 1, 1),
    (1, 2, 2),
    (1, 0, 1),
    (1, 0, 2),
    (1, 1, 0),
    (1, 1, 2),
    (1, 2, 0),
    (1, 2, 1),
];

/// The matrices M and the deviations of their numbers, accelerometer and gyro; 0 where there is none.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Intrinsics {
    pub(crate) value: [Matrix3<f64>; 2],
    pub(crate) std: [Matrix3<f64>; 2],
}

impl Intrinsics {
    pub(crate) fn none() -> Self {
        Self { value: [Matrix3::zeros(); 2], std: [Matrix3::zeros(); 2] }
    }

    /// The samples without them.
    pub(crate) fn taken_out_of(&self, samples: &[ImuSample]) -> Vec<ImuSample> {
        let inverse = self.value.map(|m| {
            (Matrix3::identity() + m).try_inverse().expect("scales within some per cent have an inverse")
        });
        let of = |s: &ImuSample| ImuSample {
            t: s.t,
            accel: (inverse[0] * Vector3::from(s.accel)).into(),
            gyro: (inverse[1] * Vector3::from(s.gyro)).into(),
        };
        samples.iter().map(of).collect()
    }

    /// One more step from `before`, whose matrices were taken out of the samples; none where it is singular.
    pub(crate) fn found(problem: &Problem<'_>, adjusted: &Adjusted, before: &Self) -> Option<Self> {
        /// Of a derivative's difference.
        const STEP: f64 = 1e-4;
        let estimate = &adjusted.estimate;
        let base = problem.linearise(estimate, &adjusted.levels);
        let keys = base.diagonal.len();
        let mut chain = Chain::<KEY_DIM, ALL>::zeros(keys);
        (chain.diagonal, chain.next, chain.gradient) = (base.diagonal, base.next, base.gradient);
        for (into, from) in chain.border.iter_mut().zip(&base.border) {
            into.fixed_rows_mut::<CONSTANTS>(0).copy_from(from);
        }
        chain.corner.fixed_view_mut::<CONSTANTS, CONSTANTS>(0, 0).copy_from(&base.corner);
        chain.gradient_of_constants.fixed_rows_mut::<CONSTANTS>(0).copy_from(&base.gradient_of_constants);
        for k in 0..keys - 1 {
            let Some(link) = problem.link(estimate, k, &adjusted.levels) else { continue };
            // By the motion, not by the readings: their noise in residual and derivative alike would be taken for scale.
            let (first, second) = (&estimate.keys[k].state, &estimate.keys[k + 1].state);
            let span = problem.samples[estimate.keys[k + 1].sample]
                .t
                .seconds_since(problem.samples[estimate.keys[k].sample].t);
            let body_from_world = first.world_from_body.rotation.inverse();
            let gravity_in_world = Vector3::new(0.0, 0.0, -GRAVITY);
            let motion = [
                body_from_world * ((second.vel_in_world - first.vel_in_world) / span - gravity_in_world),
                so3::log(&(body_from_world * second.world_from_body.rotation)) / span,
            ];
            let root = problem.root(estimate, k, &adjusted.levels);
            let mut by = SMatrix::<f64, KEY_DIM, ALL>::zeros();
            for (j, (sensor, row, column)) in PLACES.into_iter().enumerate() {
                let scaled = |step: f64| {
                    problem.rows_with(estimate, k, &adjusted.levels, &|s: &ImuSample| {
                        let mut sample = *s;
                        // Taken out of the reading, to first order.
                        let part = step * motion[sensor][column];
                        match sensor {
                            0 => sample.accel[row] -= part,
                            _ => sample.gyro[row] -= part,
                        }
                        sample
                    })
                };
                let slope = root * (scaled(STEP) - scaled(-STEP)) / (2.0 * STEP);
                by.fixed_view_mut::<15, 1>(0, CONSTANTS + j).copy_from(&slope);
            }
            add(&mut chain.border[k], &by, &link.by_first);
            add(&mut chain.border[k + 1], &by, &link.by_second);
            add(&mut chain.corner, &by, &by);
            add(&mut chain.gradient_of_constants, &by, &link.residual);
        }
        for (j, (sensor, row, column)) in PLACES.into_iter().enumerate() {
            let at = CONSTANTS + j;
            chain.corner[(at, at)] += 1.0 / (PRIOR * PRIOR);
            chain.gradient_of_constants[at] += before.value[sensor][(row, column)] / (PRIOR * PRIOR);
        }
        let factor = chain.factor().ok()?;
        let (_, step) = factor.solve(&chain);
        let covariance = factor.covariance().constants;
        let mut found = Self { value: before.value, std: [Matrix3::zeros(); 2] };
        for (j, (sensor, row, column)) in PLACES.into_iter().enumerate() {
            let at = CONSTANTS + j;
            found.value[sensor][(row, column)] += step[at];
            found.std[sensor][(row, column)] = covariance[(at, at)].max(0.0).sqrt();
        }
        step.iter().all(|s| s.is_finite()).then_some(found)
    }
}
