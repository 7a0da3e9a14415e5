//! Small, quick motion on top of a trajectory: the body turns by an angle vector th(t) and moves by d(t), both in its own frame.
//!
//! With R, w, al, p, a, f of the trajectory (al = w') the shaken body has
//!
//! R_s = R Exp(th),   p_s = p + R d,   v_s = v + R (d' + w x d),   a_s = a + R q,   q = d'' + 2 w x d' + al x d + w x (w x d)
//!
//! w_s = Exp(-th) w + J_r(th) th',   f_s = Exp(-th) (f + q)
//!
//! so that an ideal IMU and a camera on it see one and the same motion.

use super::bspline::UniformSpline;
use super::state::State;
use dpn_core::geometry::so3;
use nalgebra::Vector3;

/// Angle vector \[rad\] and displacement \[m\], both in the body frame, over the span of a trajectory.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Shaking {
    pub(crate) angle: UniformSpline<3>,
    pub(crate) displacement: UniformSpline<3>,
}

impl Shaking {
    /// The state of a body that shakes about `base`, which turns with `angular_acceleration` \[rad/s^2\].
    pub(super) fn add_to(&self, base: &State, angular_acceleration: Vector3<f64>, t: f64) -> State {
        let (turn, shift) = (self.angle.jet(t), self.displacement.jet(t));
        let (r_wb, w, d) = (base.world_from_body, base.gyro_in_body, shift.value);
        let relative = shift.first + w.cross(&d);
        let quick = shift.second
            + 2.0 * w.cross(&shift.first)
            + angular_acceleration.cross(&d)
            + w.cross(&w.cross(&d));
        let turned = so3::exp(&turn.value);
        State {
            position_in_world: base.position_in_world + r_wb * d,
            vel_in_world: base.vel_in_world + r_wb * relative,
            acc_in_world: base.acc_in_world + r_wb * quick,
            world_from_body: r_wb * turned,
            gyro_in_body: turned.inverse() * w + so3::right_jacobian(&turn.value) * turn.first,
            specific_force_in_body: turned.inverse() * (base.specific_force_in_body + quick),
        }
    }
}
