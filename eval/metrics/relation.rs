//! What of a pose's error is counted, by the names of evo's `--pose_relation`.
//!
//! Of the error E, a rigid motion with rotation R, angle a and translation t:
//!
//! | name | figure | unit |
//! |---|---|---|
//! | `trans_part` | norm of t | m |
//! | `rot_part` | Frobenius norm of R - I, which is 2 sqrt(2) sin(a / 2) | |
//! | `full` | Frobenius norm of E - I, the root of the sum of both squares | |
//! | `angle_rad`, `angle_deg` | a | rad, deg |
//! | `point_distance` | absolute: norm of t; relative: how much the chord of the stretch differs in length | m |

use super::associate::PosePair;
use super::rpe::relative_error;
use dpn_core::named;
use nalgebra::Isometry3;

named!(
    /// What of a pose's error is counted.
    pub enum PoseRelation {
        /// Translation \[m\].
        TransPart = "trans_part",
        /// Rotation, as the norm of its matrix less the identity.
        RotPart = "rot_part",
        /// Angle of the rotation \[deg\].
        AngleDeg = "angle_deg",
        /// Angle of the rotation \[rad\].
        AngleRad = "angle_rad",
        /// Rotation and translation, as the norm of the 4 by 4 matrix less the identity.
        Full = "full",
        /// Distance of points \[m\].
        PointDistance = "point_distance",
    }
);

impl PoseRelation {
    /// The figure's unit; empty where it has none.
    pub fn unit(self) -> &'static str {
        match self {
            Self::TransPart | Self::PointDistance => "m",
            Self::AngleDeg => "deg",
            Self::AngleRad => "rad",
            Self::RotPart | Self::Full => "",
        }
    }

    fn of(self, error: &Isometry3<f64>) -> f64 {
        let distance = error.translation.vector.norm();
        let angle = error.rotation.angle();
        let rotation = 8f64.sqrt() * (0.5 * angle).sin();
        match self {
            Self::TransPart | Self::PointDistance => distance,
            Self::RotPart => rotation,
            Self::AngleDeg => angle.to_degrees(),
            Self::AngleRad => angle,
            Self::Full => rotation.hypot(distance),
        }
    }

    /// Of one pair, whose estimate has been brought into the truth's world.
    pub(super) fn absolute(self, pair: &PosePair) -> f64 {
        self.of(&pair.true_world_from_body.inv_mul(&pair.est_world_from_body))
    }

    /// Over the stretch from pair `i` to pair `j`.
    pub(super) fn relative(self, i: &PosePair, j: &PosePair) -> f64 {
        if self == Self::PointDistance {
            let chord = |of: fn(&PosePair) -> &Isometry3<f64>| {
                (of(j).translation.vector - of(i).translation.vector).norm()
            };
            return (chord(|p| &p.true_world_from_body) - chord(|p| &p.est_world_from_body)).abs();
        }
        self.of(&relative_error(i, j))
    }
}
