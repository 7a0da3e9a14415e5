//! What gravity says of a gyroscope's slow bias: a body that stays within some metres a second of rest feels gravity, on average.
//!
//! A filter of twelve unknowns, attitude, velocity and the biases of both sensors, that is told every tenth of a second that the velocity is nothing, give or take. A bias across gravity
//! tilts the attitude, and what gravity then seems to accelerate would soon be faster than such a body is. About gravity's own axis nothing is seen, and the prior stays:
//! how far training recordings' biases lie apart. Samples that no such body makes, and holes, let attitude and velocity begin anew.

use crate::course::Course;
use dpn_core::GRAVITY;
use dpn_core::geometry::so3;
use nalgebra::{Matrix3, SMatrix, UnitQuaternion, Vector3};

/// Samples are joined over so long \[s\].
const BLOCK_S: f64 = 0.1;
/// A longer step is a hole \[s\].
const HOLE_S: f64 = 0.5;
/// For so long a velocity resembles itself \[s\]: what is said of it counts for so much less.
const LASTS_S: f64 = 2.0;
/// The bias' prior deviation in those of the training recordings' biases: a new one lies farther off than few known ones.
const WIDER: f64 = 1.5;
/// Deviations at the start: of the attitude about each axis \[rad\], of the accelerometer's bias \[m/s^2\].
const ATTITUDE: f64 = 0.1;
const ACCEL_BIAS: f64 = 0.2;
/// What a second adds, roots of densities: to the attitude \[rad\], the velocity \[m/s\], the gyroscope's bias \[rad/s\] and the accelerometer's \[m/s^2\].
const GROWS: [f64; 4] = [1e-3, 0.05, 5e-5, 1e-4];
/// A velocity whose square in its variances is more than this is none that was foreseen.
const LOST: f64 = 50.0;
const UNKNOWNS: usize = 12;

/// The deviation of a new recording's bias before gravity tells anything.
pub(crate) fn beforehand(spread: &[f64; 3]) -> Vector3<f64> {
    WIDER * Vector3::from(*spread)
}

/// Samples since the last update.
#[derive(Debug)]
struct Block {
    turn: UnitQuaternion<f64>,
    /// Of the specific force, in the frame of its first sample \[m/s\].
    velocity: Vector3<f64>,
    /// The turn's derivative by the bias \[s\].
    by_bias: Matrix3<f64>,
    seconds: f64,
}

impl Block {
    fn new() -> Self {
        Self {
            turn: UnitQuaternion::identity(),
            velocity: Vector3::zeros(),
            by_bias: Matrix3::zeros(),
            seconds: 0.0,
        }
    }
}

/// A filter that is fed samples.
#[derive(Debug)]
pub(crate) struct Gravity {
    /// Deviation of the velocity \[m/s\].
    speed: f64,
    block: Block,
    /// World from body; none before the first block.
    attitude: Option<UnitQuaternion<f64>>,
    velocity: Vector3<f64>,
    bias: Vector3<f64>,
    accel_bias: Vector3<f64>,
    covariance: SMatrix<f64, UNKNOWNS, UNKNOWNS>,
}

impl Gravity {
    /// Before the first sample. Training biases lie `spread` apart \[rad/s\]; the body's velocity has a deviation of `speed` \[m/s\], where 0 leaves the bias alone.
    pub(crate) fn new(spread: &[f64; 3], speed: f64) -> Self {
        let mut covariance = SMatrix::<f64, UNKNOWNS, UNKNOWNS>::zeros();
        covariance.fixed_view_mut::<3, 3>(6, 6).set_diagonal(&beforehand(spread).map(|std| std * std));
        covariance.fixed_view_mut::<3, 3>(9, 9).fill_diagonal(ACCEL_BIAS.powi(2));
        Self {
            speed,
            block: Block::new(),
            attitude: None,
            velocity: Vector3::zeros(),
            bias: Vector3::zeros(),
            accel_bias: Vector3::zeros(),
            covariance,
        }
    }

    /// What is to be added to rates like those it was fed \[rad/s\].
    pub(crate) fn bias(&self) -> Vector3<f64> {
        self.bias
    }

    /// Its deviation by axis.
    pub(crate) fn deviation(&self) -> Vector3<f64> {
        self.covariance.diagonal().fixed_rows::<3>(6).map(f64::sqrt)
    }

    /// Calibrated rate and specific force in the middle of a step, and its seconds.
    pub(crate) fn push(&mut self, rate: &Vector3<f64>, force: &Vector3<f64>, seconds: f64) {
        if self.speed == 0.0 {
            return;
        }
        if seconds > HOLE_S {
            return self.lose();
        }
        let increment = so3::exp(&(rate * seconds));
        let block = &mut self.block;
        block.velocity += block.turn * force * seconds;
        block.by_bias =
            increment.inverse().to_rotation_matrix() * block.by_bias + Matrix3::identity() * seconds;
        block.turn *= increment;
        block.seconds += seconds;
        // A hair's breadth for the sum's rounding.
        if block.seconds > BLOCK_S - 1e-6 {
            self.update();
        }
    }

    /// Attitude and velocity begin anew; the biases stay as they are known.
    fn lose(&mut self) {
        (self.attitude, self.velocity, self.block) = (None, Vector3::zeros(), Block::new());
    }

    fn update(&mut self) {
        let Block { turn, velocity, by_bias, seconds } = std::mem::replace(&mut self.block, Block::new());
        let before = self.attitude.or_else(|| {
            let up = UnitQuaternion::rotation_between(&velocity, &Vector3::z())?;
            let mut fresh = SMatrix::<f64, UNKNOWNS, UNKNOWNS>::zeros();
            fresh.fixed_view_mut::<3, 3>(0, 0).fill_diagonal(ATTITUDE.powi(2));
            fresh.fixed_view_mut::<3, 3>(3, 3).fill_diagonal(self.speed.powi(2));
            fresh.fixed_view_mut::<6, 6>(6, 6).copy_from(&self.covariance.fixed_view::<6, 6>(6, 6));
            self.covariance = fresh;
            Some(up)
        });
        let Some(before) = before else { return };
        let world = before.to_rotation_matrix();
        let turn = turn * so3::exp(&(by_bias * self.bias));
        let change = velocity + self.accel_bias * seconds;
        let mut by = SMatrix::<f64, UNKNOWNS, UNKNOWNS>::identity();
        by.fixed_view_mut::<3, 3>(0, 0).copy_from(turn.inverse().to_rotation_matrix().matrix());
        by.fixed_view_mut::<3, 3>(0, 6).copy_from(&by_bias);
        by.fixed_view_mut::<3, 3>(3, 0).copy_from(&(-world.matrix() * so3::hat(&change)));
        by.fixed_view_mut::<3, 3>(3, 9).copy_from(&(world.matrix() * seconds));
        let mut covariance = by * self.covariance * by.transpose();
        for i in 0..UNKNOWNS {
            covariance[(i, i)] += GROWS[i / 3].powi(2) * seconds;
        }
        let moved = self.velocity + world * change - Vector3::z() * GRAVITY * seconds;
        let told = self.speed.powi(2) * (2.0 * LASTS_S / seconds).max(1.0);
        let inverse = (covariance.fixed_view::<3, 3>(3, 3) + Matrix3::identity() * told).try_inverse();
        // NaN is below nothing.
        let foreseen = inverse.filter(|inverse| moved.dot(&(inverse * moved)) < LOST);
        let Some(inverse) = foreseen else { return self.lose() };
        let gain = covariance.fixed_columns::<3>(3) * inverse;
        let step = -gain * moved;
        let after = covariance - gain * covariance.fixed_rows::<3>(3);
        self.covariance = 0.5 * (after + after.transpose());
        let part = |from: usize| -> Vector3<f64> { step.fixed_rows::<3>(from).into() };
        self.attitude = Some(before * turn * so3::exp(&part(0)));
        self.velocity = moved + part(3);
        self.bias += part(6);
        self.accel_bias += part(9);
    }
}

/// By sample, the rate with the bias that gravity told until then, that bias and its deviation.
pub(crate) fn steadied(
    course: &Course,
    rates: &[Vector3<f64>],
    spread: &[f64; 3],
    speed: f64,
) -> Vec<[Vector3<f64>; 3]> {
    let mut gravity = Gravity::new(spread, speed);
    let one = |(i, rate): (usize, &Vector3<f64>)| {
        let told = [rate + gravity.bias(), gravity.bias(), gravity.deviation()];
        if let Some(step) = course.step_s.get(i) {
            let middle = |here: &Vector3<f64>, next: &Vector3<f64>| 0.5 * (here + next);
            let force = middle(&course.accel[i], &course.accel[i + 1]);
            gravity.push(&middle(rate, &rates[i + 1]), &force, *step);
        }
        told
    };
    rates.iter().enumerate().map(one).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::course::simulated;

    #[test]
    fn a_bias_across_gravity_is_found_and_one_about_it_is_left_to_the_prior() {
        let bias = Vector3::new(0.003, -0.002, 0.001);
        let still = |gravity: &mut Gravity, seconds: f64| {
            for _ in 0..(200.0 * seconds) as usize {
                gravity.push(&-bias, &Vector3::new(0.0, 0.0, GRAVITY), 0.005);
            }
        };
        let mut gravity = Gravity::new(&[0.002; 3], 0.5);
        still(&mut gravity, 60.0);
        let off = gravity.bias() - bias;
        let std = gravity.deviation();
        assert!(off.xy().amax() < 2e-4 && std.xy().amax() < 4e-4 && std.z > 2e-3, "{off} {std}");
        // What no body feels, and a hole, are not learned from.
        let known = gravity.bias();
        gravity.push(&Vector3::zeros(), &Vector3::repeat(1e9), 0.005);
        gravity.push(&Vector3::zeros(), &Vector3::repeat(f64::NAN), 0.005);
        still(&mut gravity, 0.1);
        gravity.push(&Vector3::zeros(), &Vector3::repeat(1e3), 1.0);
        assert_eq!(gravity.bias(), known);
        still(&mut gravity, 10.0);
        assert!((gravity.bias() - bias).xy().amax() < 3e-4);
        let mut none = Gravity::new(&[0.002; 3], 0.0);
        still(&mut none, 1.0);
        assert_eq!(none.bias(), Vector3::zeros());
    }

    #[test]
    fn a_turning_body_tells_all_axes_and_nothing_is_known_beforehand() {
        let bias = Vector3::new(0.002, 0.001, -0.002);
        let course = simulated(60.0, Matrix3::identity(), -bias, 0.002);
        let rates = steadied(&course, &course.gyro, &[0.002; 3], 0.5);
        assert_eq!(rates[19][0], course.gyro[19]);
        let off = rates[11_900][1] - bias;
        assert!(off.amax() < 5e-4, "{off}");
    }
}
