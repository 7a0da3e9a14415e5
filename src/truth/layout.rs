//! What is estimated, and in which order: 24 unknowns a key, 10 constants.
//!
//! ```text
//! key:       position 0   rotation 3   velocity 6   accelerometer bias 9   gyro bias 12
//!            published error: position 15, rotation 18, rate of the position's 21
//! constants: delay 0   mount 1   lever 4   tilt 7   blur 9
//! ```

use dpn_core::geometry::so3;
use dpn_vio::NavState;
use nalgebra::{SVector, UnitQuaternion, Vector3};

/// Unknowns of a key.
pub(crate) const KEY_DIM: usize = 24;
/// Where the published position's slow error stands.
pub(crate) const POSITION_ERROR: usize = 15;
/// Where the published rotation's slow error stands.
pub(crate) const ROTATION_ERROR: usize = 18;
/// Where the rate of the published position's slow error stands.
pub(crate) const ERROR_RATE: usize = 21;

/// Unknown constants.
pub(crate) const CONSTANTS: usize = 10;
/// Where the delay stands.
pub(crate) const DELAY: usize = 0;
/// Where the mount stands.
pub(crate) const MOUNT: usize = 1;
/// Where the lever stands.
pub(crate) const LEVER: usize = 4;
/// Where the tilt about x and y stands.
pub(crate) const TILT: usize = 7;
/// Where the blur stands.
pub(crate) const BLUR: usize = 9;

/// The state at one IMU sample.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Key {
    /// Index of the sample.
    pub(crate) sample: usize,
    /// Pose, velocity, biases.
    pub(crate) state: NavState,
    /// The part of the published position's error that does not change from sample to sample \[m\], published world.
    pub(crate) position_error: Vector3<f64>,
    /// The same of the rotation, on the right \[rad\].
    pub(crate) rotation_error: Vector3<f64>,
    /// Rate of the position's error \[m/s\].
    pub(crate) error_rate: Vector3<f64>,
}

impl Key {
    /// Moved by a step.
    pub(crate) fn plus(&self, d: &SVector<f64, KEY_DIM>) -> Self {
        Self {
            sample: self.sample,
            state: self.state.plus(&d.fixed_rows::<15>(0).into_owned()),
            position_error: self.position_error + d.fixed_rows::<3>(POSITION_ERROR),
            rotation_error: self.rotation_error + d.fixed_rows::<3>(ROTATION_ERROR),
            error_rate: self.error_rate + d.fixed_rows::<3>(ERROR_RATE),
        }
    }
}

/// How the published poses hang on the IMU's: one set for the whole sequence.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Frames {
    /// A published stamp is this much later than the IMU's stamp of the same pose \[s\].
    pub(crate) delay_s: f64,
    /// Points in the published body frame to the IMU's.
    pub(crate) body_from_published_body: UnitQuaternion<f64>,
    /// The published body's origin in the IMU's frame \[m\].
    pub(crate) lever_in_body: Vector3<f64>,
    /// Points in the gravity-aligned world to the published one; same origin, no heading of its own.
    pub(crate) published_world_from_world: UnitQuaternion<f64>,
    /// Half the second moment of the smoothing that published poses went through \[s^2\]. One for positions and rotations: under thrust along
    /// one axis of the body a blur of positions alone cannot be told from a lever along that axis.
    pub(crate) blur_s2: f64,
}

impl Frames {
    /// The same frames and clocks, no smoothing.
    pub(crate) fn identity() -> Self {
        Self {
            delay_s: 0.0,
            body_from_published_body: UnitQuaternion::identity(),
            lever_in_body: Vector3::zeros(),
            published_world_from_world: UnitQuaternion::identity(),
            blur_s2: 0.0,
        }
    }

    /// Moved by a step: mount and tilt on the right, so that the tilt is about the true world's x and y whatever the published one's axes are.
    pub(crate) fn plus(&self, d: &SVector<f64, CONSTANTS>) -> Self {
        let tilt = Vector3::new(d[TILT], d[TILT + 1], 0.0);
        let renormalised = |q: UnitQuaternion<f64>| UnitQuaternion::new_normalize(q.into_inner());
        Self {
            delay_s: self.delay_s + d[DELAY],
            body_from_published_body: renormalised(
                self.body_from_published_body * so3::exp(&d.fixed_rows::<3>(MOUNT).into_owned()),
            ),
            lever_in_body: self.lever_in_body + d.fixed_rows::<3>(LEVER),
            published_world_from_world: renormalised(self.published_world_from_world * so3::exp(&tilt)),
            blur_s2: self.blur_s2 + d[BLUR],
        }
    }
}

/// Constants that are told apart from nothing together: where they stand, how many, the square beyond which chance does not lead (99.9 %).
pub(crate) const CONSTANT_GROUPS: [(usize, usize, f64); 5] =
    [(DELAY, 1, 10.8), (MOUNT, 3, 16.3), (LEVER, 3, 16.3), (TILT, 2, 13.8), (BLUR, 1, 10.8)];

impl Frames {
    /// The step that takes the constants to the neutral ones, group by group where a group is small.
    pub(crate) fn to_neutral(self) -> SVector<f64, CONSTANTS> {
        let mut step = SVector::<f64, CONSTANTS>::zeros();
        step[DELAY] = -self.delay_s;
        step.fixed_rows_mut::<3>(MOUNT).copy_from(&-so3::log(&self.body_from_published_body));
        step.fixed_rows_mut::<3>(LEVER).copy_from(&-self.lever_in_body);
        step.fixed_rows_mut::<2>(TILT).copy_from(&-so3::log(&self.published_world_from_world).xy());
        step[BLUR] = -self.blur_s2;
        step
    }
}
