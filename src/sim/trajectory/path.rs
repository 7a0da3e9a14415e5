//! A multirotor's trajectory: a position spline, a heading spline, and everything that follows from them.
//!
//! World z up, gravity (0, 0, -9.81), body = IMU with z along the thrust. Position is C^4, hence orientation C^2 and
//! body rate C^1. An ideal IMU reads R_bw (a - g): at rest and level (0, 0, +9.81). What shakes the body is added (`shaking`).

use super::attitude::{Attitude, attitude};
use super::bspline::UniformSpline;
use super::shaking::Shaking;
use super::state::State;
use dpn_core::GRAVITY;
use nalgebra::{Isometry3, Rotation3, Translation3, UnitQuaternion, Vector3};

/// A smooth trajectory over \[0, duration\] seconds; before and after, the body stands at its ends.
#[derive(Debug, Clone, PartialEq)]
pub struct Trajectory {
    position: UniformSpline<3>,
    yaw: UniformSpline<1>,
    shaking: Option<Shaking>,
}

/// Step of the difference that gives the angular acceleration \[s\]: it only meets displacements of a tenth of a millimetre, where its error is
/// below 1e-9 m/s^2.
const STEP_S: f64 = 1e-4;

impl Trajectory {
    /// From a position spline \[m\] and a heading spline \[rad\], both over the same span.
    pub fn new(position: UniformSpline<3>, yaw: UniformSpline<1>) -> Self {
        Self { position, yaw, shaking: None }
    }

    /// The same, shaken.
    pub(crate) fn shaken(self, shaking: Shaking) -> Self {
        Self { shaking: Some(shaking), ..self }
    }

    /// Length in time \[s\].
    pub fn duration(&self) -> f64 {
        self.position.duration()
    }

    /// The whole state `t` seconds after the start.
    pub fn state(&self, t: f64) -> State {
        let p = self.position.jet(t);
        let turned = self.attitude(t);
        let base = State {
            position_in_world: p.value,
            vel_in_world: p.first,
            acc_in_world: p.second,
            world_from_body: UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(
                turned.world_from_body,
            )),
            gyro_in_body: turned.gyro_in_body,
            specific_force_in_body: turned.specific_force_in_body,
        };
        match &self.shaking {
            None => base,
            Some(shaking) => {
                let (before, after) = (self.attitude(t - STEP_S), self.attitude(t + STEP_S));
                let angular_acceleration = (after.gyro_in_body - before.gyro_in_body) / (2.0 * STEP_S);
                shaking.add_to(&base, angular_acceleration, t)
            }
        }
    }

    /// Pose `t` seconds after the start: maps points of the body frame into the world.
    pub fn pose(&self, t: f64) -> Isometry3<f64> {
        let state = self.state(t);
        Isometry3::from_parts(Translation3::from(state.position_in_world), state.world_from_body)
    }

    /// Thrust over weight: |a - g| / 9.81; 1 in hover. Shaking is none of it.
    pub(crate) fn thrust_ratio(&self, t: f64) -> f64 {
        (self.position.jet(t).second + Vector3::new(0.0, 0.0, GRAVITY)).norm() / GRAVITY
    }

    fn attitude(&self, t: f64) -> Attitude {
        let p = self.position.jet(t);
        let heading = self.yaw.jet(t);
        attitude(p.second, p.third, heading.value[0], heading.first[0], Vector3::new(0.0, 0.0, -GRAVITY))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use dpn_core::random::Stream;
    use nalgebra::Vector1;
    use rand::Rng;

    /// Lively: accelerations of several m/s^2, headings that turn by a radian a second.
    fn lively(seed: u64) -> Trajectory {
        let mut rng = Stream::new(seed).named("trajectory").rng();
        let mut draw = |half: f64| rng.random_range(-half..half);
        let position = (0..40)
            .map(|k| {
                let a = 0.5 * f64::from(k);
                Vector3::new(a.cos() + draw(0.3), a.sin() + draw(0.3), 1.0 + draw(0.2))
            })
            .collect();
        let yaw = (0..40).map(|k| Vector1::new(0.3 * f64::from(k) + draw(0.3))).collect();
        Trajectory::new(UniformSpline::new(0.4, position), UniformSpline::new(0.4, yaw))
    }

    /// The same with a body that turns by a degree and moves by a centimetre within half a second.
    fn shaken(seed: u64) -> Trajectory {
        let mut rng = Stream::new(seed).named("shaking").rng();
        let mut spline = |half: f64| {
            let controls = (0..80).map(|_| Vector3::from_fn(|_, _| rng.random_range(-half..half)));
            UniformSpline::new(0.25, controls.collect())
        };
        let (angle, displacement) = (spline(0.02), spline(0.01));
        lively(seed).shaken(Shaking { angle, displacement })
    }

    #[test]
    fn velocity_acceleration_and_body_rate_agree_with_central_differences() {
        let h = 1e-5;
        for path in (0..5).flat_map(|seed| [lively(seed), shaken(seed)]) {
            for i in 1..130 {
                let t = 0.1 * f64::from(i) + 0.007;
                let (a, b, at) = (path.pose(t - h), path.pose(t + h), path.state(t));
                let vel = (b.translation.vector - a.translation.vector) / (2.0 * h);
                let acc = (path.state(t + h).vel_in_world - path.state(t - h).vel_in_world) / (2.0 * h);
                let rate = (a.rotation.inverse() * b.rotation).scaled_axis() / (2.0 * h);
                // Rounding: 1e-16 over 1e-5 s; truncation: h^2 times third derivatives below 1e3.
                assert!((vel - at.vel_in_world).norm() < 1e-6);
                assert!((acc - at.acc_in_world).norm() < 1e-6);
                assert!((rate - at.gyro_in_body).norm() < 1e-6, "{rate} {}", at.gyro_in_body);
                let force = at.world_from_body * at.specific_force_in_body;
                assert!((force - Vector3::new(0.0, 0.0, GRAVITY) - at.acc_in_world).norm() < 1e-12);
            }
        }
    }

    /// Position, velocity and angle by which integrating the ideal IMU over 12 s in steps of `h` misses the path.
    fn missed(path: &Trajectory, h: f64) -> [f64; 3] {
        let start = path.state(0.5);
        let (mut p, mut v, mut q) = (start.position_in_world, start.vel_in_world, start.world_from_body);
        let steps = (12.0 / h).round() as u32;
        for i in 0..steps {
            let t = 0.5 + h * f64::from(i);
            let middle = path.state(t + 0.5 * h);
            let half = UnitQuaternion::from_scaled_axis(path.state(t + 0.25 * h).gyro_in_body * (0.5 * h));
            let acc = q * half * middle.specific_force_in_body - Vector3::new(0.0, 0.0, GRAVITY);
            p += v * h + acc * (0.5 * h * h);
            v += acc * h;
            q *= UnitQuaternion::from_scaled_axis(middle.gyro_in_body * h);
        }
        let end = path.state(0.5 + h * f64::from(steps));
        [(p - end.position_in_world).norm(), (v - end.vel_in_world).norm(), q.angle_to(&end.world_from_body)]
    }

    #[test]
    fn integrating_an_ideal_imu_returns_the_trajectory() {
        for path in [lively(3), shaken(3)] {
            let (coarse, fine) = (missed(&path, 1e-3), missed(&path, 5e-4));
            for (what, bound) in [2e-5, 1e-5, 1e-6].into_iter().enumerate() {
                assert!(fine[what] < bound, "{fine:?}");
                // The mid-point rule is of second order: nothing else may be left over.
                assert!((3.5..4.5).contains(&(coarse[what] / fine[what])), "{coarse:?} {fine:?}");
            }
        }
    }
}
