//! The freedom between the estimate's world and the truth's, removed by least squares over the positions.
//!
//! minimise sum |y - (s R x + t)|^2 over x = estimated, y = true positions, all in closed form:
//! * t = mean(y) - s R mean(x) for every kind; below, x and y are centred.
//! * `Se3`: R from the quaternion that is the eigenvector of the largest eigenvalue of Horn's symmetric 4x4 matrix (B. K. P. Horn,
//!   "Closed-form solution of absolute orientation using unit quaternions", JOSA A 1987, sec. 4). The eigenvalue is
//!   sum y . R x; the gap to the next tells how well the positions determine R: it is zero for a point and for a line.
//! * `Sim3`: the same R, s = sum y . R x / sum |x|^2 (S. Umeyama, PAMI 1991, eq. 42, in other words).
//! * `YawPosition`: R = Rz(a), a = atan2(sum x_x y_y - x_y y_x, sum x_x y_x + x_y y_y). Both worlds have z up.
//! * `Position`: R = I.
//!
//! Orientations have no say, as in evo: an error of orientation stays an error. A visual-inertial estimator knows gravity, so what is
//! free in it is yaw and position; SE(3) forgives tilt as well and is what papers report.

use super::associate::PosePair;
use super::error::MetricsError;
use dpn_core::named;
use nalgebra::{
    Isometry3, Matrix3, Matrix4, Quaternion, SymmetricEigen, Translation3, UnitQuaternion, Vector3,
};
use serde::{Deserialize, Serialize};

named!(
    /// What may be moved to make an estimate fit the truth.
    #[derive(PartialOrd, Ord, Serialize, Deserialize)]
    #[serde(rename_all = "kebab-case")]
    pub enum AlignmentKind {
        /// Position: 3 degrees of freedom.
        Position = "alignment of position",
        /// Yaw and position: 4, what a visual-inertial estimator cannot know.
        YawPosition = "alignment of yaw and position",
        /// Rotation and position: 6, what papers report.
        Se3 = "SE(3) alignment",
        /// Rotation, position and scale: 7, for monocular vision alone.
        Sim3 = "Sim(3) alignment",
    }
);

impl AlignmentKind {
    /// The fewest pairs that can determine it.
    fn pairs_needed(self) -> usize {
        match self {
            Self::Position => 1,
            Self::YawPosition => 2,
            Self::Se3 | Self::Sim3 => 3,
        }
    }
}

/// A map from the estimate's world to the truth's: `p -> scale * R p + t`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Alignment {
    /// R and t.
    pub true_world_from_est_world: Isometry3<f64>,
    /// Metres of the truth to one metre of the estimate.
    pub scale: f64,
}

impl Alignment {
    /// Nothing is moved: both worlds are the same, as in a simulation that starts from the true pose.
    pub fn identity() -> Self {
        Self { true_world_from_est_world: Isometry3::identity(), scale: 1.0 }
    }

    /// An estimated pose seen in the truth's world.
    pub fn apply(&self, est_world_from_body: &Isometry3<f64>) -> Isometry3<f64> {
        let r = self.true_world_from_est_world.rotation;
        let position = r * est_world_from_body.translation.vector * self.scale
            + self.true_world_from_est_world.translation.vector;
        Isometry3::from_parts(Translation3::from(position), r * est_world_from_body.rotation)
    }
}

/// A gap below this leaves a rotation undetermined: positions in files carry six or more digits, and their rounding opens a gap of 1e-12.
const GAP: f64 = 1e-9;

/// Positions this near to their mean, relative to its distance from the origin, are all the same.
const ROUNDING: f64 = 1e-14;

/// The alignment of `kind` that brings the estimated positions nearest to the true ones.
///
/// # Errors
/// Too few pairs; positions on a point or a line (seen from above for yaw), which leave a rotation undetermined.
pub fn align(pairs: &[PosePair], kind: AlignmentKind) -> Result<Alignment, MetricsError> {
    let needed = kind.pairs_needed();
    if pairs.len() < needed {
        return Err(MetricsError::TooFewPairs { what: kind.name(), needed, found: pairs.len() });
    }
    let moments = Moments::of(pairs);
    let (rotation, scale) = match kind {
        AlignmentKind::Position => (UnitQuaternion::identity(), 1.0),
        AlignmentKind::YawPosition => (moments.yaw()?, 1.0),
        AlignmentKind::Se3 => (moments.rotation()?.0, 1.0),
        AlignmentKind::Sim3 => {
            // With a rotation determined, the estimate is no point and its square is not zero.
            let (rotation, along) = moments.rotation()?;
            (rotation, along / moments.est_square)
        }
    };
    let offset = moments.true_mean - rotation * moments.est_mean * scale;
    Ok(Alignment {
        true_world_from_est_world: Isometry3::from_parts(Translation3::from(offset), rotation),
        scale,
    })
}

/// Means and second moments of both sets of positions about their means.
struct Moments {
    est_mean: Vector3<f64>,
    true_mean: Vector3<f64>,
    /// sum |x|^2
    est_square: f64,
    /// sum |y|^2
    true_square: f64,
    /// sum x y^T
    cross: Matrix3<f64>,
}

impl Moments {
    fn of(pairs: &[PosePair]) -> Self {
        let n = pairs.len() as f64;
        let x = |p: &PosePair| p.est_world_from_body.translation.vector;
        let y = |p: &PosePair| p.true_world_from_body.translation.vector;
        let est_mean = pairs.iter().map(x).sum::<Vector3<f64>>() / n;
        let true_mean = pairs.iter().map(y).sum::<Vector3<f64>>() / n;
        let mut moments =
            Self { est_mean, true_mean, est_square: 0.0, true_square: 0.0, cross: Matrix3::zeros() };
        for pair in pairs {
            let (x, y) = (x(pair) - est_mean, y(pair) - true_mean);
            moments.est_square += x.norm_squared();
            moments.true_square += y.norm_squared();
            moments.cross += x * y.transpose();
        }
        // Positions that differ by the rounding of their mean alone are one point.
        let rounding = |mean: &Vector3<f64>| n * (ROUNDING * mean.norm()).powi(2);
        if moments.est_square <= rounding(&est_mean) || moments.true_square <= rounding(&true_mean) {
            moments.est_square = 0.0;
        }
        moments
    }

    /// The gap relative to the extent of both sets; refuses one that leaves `what` undetermined.
    fn determined(&self, gap: f64, what: &'static str) -> Result<(), MetricsError> {
        let extent = (self.est_square * self.true_square).sqrt();
        let gap = if extent > 0.0 { gap / extent } else { 0.0 };
        if gap > GAP { Ok(()) } else { Err(MetricsError::Degenerate { what, gap }) }
    }

    fn yaw(&self) -> Result<UnitQuaternion<f64>, MetricsError> {
        let s = &self.cross;
        let (sine, cosine) = (s[(0, 1)] - s[(1, 0)], s[(0, 0)] + s[(1, 1)]);
        self.determined(sine.hypot(cosine), "yaw")?;
        Ok(UnitQuaternion::from_axis_angle(&Vector3::z_axis(), sine.atan2(cosine)))
    }

    /// The rotation and sum y . R x.
    fn rotation(&self) -> Result<(UnitQuaternion<f64>, f64), MetricsError> {
        let s = &self.cross;
        let (xx, xy, xz) = (s[(0, 0)], s[(0, 1)], s[(0, 2)]);
        let (yx, yy, yz) = (s[(1, 0)], s[(1, 1)], s[(1, 2)]);
        let (zx, zy, zz) = (s[(2, 0)], s[(2, 1)], s[(2, 2)]);
        #[rustfmt::skip]
        let horn = Matrix4::new(
            xx + yy + zz, yz - zy,      zx - xz,      xy - yx,
            yz - zy,      xx - yy - zz, xy + yx,      zx + xz,
            zx - xz,      xy + yx,      yy - xx - zz, yz + zy,
            xy - yx,      zx + xz,      yz + zy,      zz - xx - yy,
        );
        // Ten or so sweeps do; the limit is there for overflow alone.
        let undetermined = MetricsError::Degenerate { what: "the rotation", gap: 0.0 };
        let eigen = SymmetricEigen::try_new(horn, f64::EPSILON, 1000).ok_or(undetermined)?;
        let best = eigen.eigenvalues.imax();
        let along = eigen.eigenvalues[best];
        let next =
            (0..4).filter(|&i| i != best).map(|i| eigen.eigenvalues[i]).fold(f64::NEG_INFINITY, f64::max);
        self.determined(along - next, "the rotation")?;
        let q = eigen.eigenvectors.column(best);
        Ok((UnitQuaternion::new_normalize(Quaternion::new(q[0], q[1], q[2], q[3])), along))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use dpn_core::Stamp;
    use proptest::prelude::*;

    fn pairs_of(
        points: &[Vector3<f64>],
        true_from_est: impl Fn(Vector3<f64>) -> Vector3<f64>,
    ) -> Vec<PosePair> {
        let pair = |(i, x): (usize, &Vector3<f64>)| PosePair {
            t: Stamp::from_ns(i as i64),
            estimate_index: i,
            true_world_from_body: Translation3::from(true_from_est(*x)).into(),
            est_world_from_body: Translation3::from(*x).into(),
        };
        points.iter().enumerate().map(pair).collect()
    }

    fn cost(pairs: &[PosePair], alignment: &Alignment) -> f64 {
        let square = |p: &PosePair| {
            let moved = alignment.apply(&p.est_world_from_body).translation.vector;
            (p.true_world_from_body.translation.vector - moved).norm_squared()
        };
        pairs.iter().map(square).sum()
    }

    fn vectors(n: std::ops::Range<usize>) -> impl Strategy<Value = Vec<Vector3<f64>>> {
        prop::collection::vec(prop::array::uniform3(-5.0..5.0_f64).prop_map(Vector3::from), n)
    }

    proptest! {
        /// What moved the estimate away is found again, by every kind that may move that much.
        #[test]
        fn a_moved_trajectory_is_moved_back(
            points in vectors(4..30), turn in prop::array::uniform3(-1.7..1.7_f64), offset in prop::array::uniform3(-9.0..9.0_f64),
            scale in 0.2..4.0_f64,
        ) {
            let offset = Vector3::from(offset);
            for kind in AlignmentKind::ALL {
                let r = match kind {
                    AlignmentKind::Position => UnitQuaternion::identity(),
                    AlignmentKind::YawPosition => UnitQuaternion::from_scaled_axis(Vector3::z() * 1.8 * turn[2]),
                    _ => UnitQuaternion::from_scaled_axis(turn.into()),
                };
                let scale = if kind == AlignmentKind::Sim3 { scale } else { 1.0 };
                let pairs = pairs_of(&points, |x| r * x * scale + offset);
                let got = align(&pairs, kind).unwrap();
                prop_assert!((got.scale - scale).abs() < 1e-9, "{kind}: {got:?}");
                prop_assert!(got.true_world_from_est_world.rotation.angle_to(&r) < 1e-7, "{kind}: {got:?}");
                prop_assert!(cost(&pairs, &got) < 1e-15, "{kind}: {}", cost(&pairs, &got));
            }
        }

        /// At the minimum every step that the kind allows costs more; mirrored points included, where a plain SVD gives a reflection.
        #[test]
        fn no_step_that_is_allowed_makes_it_better(
            points in vectors(4..12), noise in vectors(12..13), mirror in any::<bool>(), step in prop::array::uniform3(-1.0..1.0_f64),
        ) {
            let mut k = 0;
            let noise = &noise;
            let pairs: Vec<_> = pairs_of(&points, |x| if mirror { Vector3::new(x.x, x.y, -x.z) } else { x })
                .into_iter()
                .map(|mut p| {
                    p.true_world_from_body.translation.vector += noise[k] * 0.3;
                    k += 1;
                    p
                })
                .collect();
            for kind in AlignmentKind::ALL {
                let Ok(best) = align(&pairs, kind) else { continue };
                let lowest = cost(&pairs, &best);
                for size in [1e-3, -1e-3] {
                    let mut other = best;
                    other.true_world_from_est_world.translation.vector += Vector3::from(step) * size;
                    prop_assert!(cost(&pairs, &other) >= lowest - 1e-9, "{kind}: position");
                    let mut other = best;
                    let axis = match kind {
                        AlignmentKind::Position => continue,
                        AlignmentKind::YawPosition => Vector3::z(),
                        _ => Vector3::from(step),
                    };
                    let turn = UnitQuaternion::from_scaled_axis(axis * size);
                    other.true_world_from_est_world.rotation = turn * best.true_world_from_est_world.rotation;
                    prop_assert!(cost(&pairs, &recentred(&pairs, other)) >= lowest - 1e-9, "{kind}: rotation");
                    if kind == AlignmentKind::Sim3 {
                        let mut other = best;
                        other.scale *= 1.0 + size;
                        prop_assert!(cost(&pairs, &recentred(&pairs, other)) >= lowest - 1e-9, "{kind}: scale");
                    }
                }
            }
        }
    }

    /// The same rotation and scale with the offset that suits them best.
    fn recentred(pairs: &[PosePair], mut alignment: Alignment) -> Alignment {
        let off: Vector3<f64> = pairs
            .iter()
            .map(|p| {
                p.true_world_from_body.translation.vector
                    - alignment.apply(&p.est_world_from_body).translation.vector
            })
            .sum();
        alignment.true_world_from_est_world.translation.vector += off / pairs.len() as f64;
        alignment
    }

    #[test]
    fn a_point_and_a_line_are_refused_where_they_leave_a_rotation_open() {
        let line: Vec<_> = (0..9).map(|i| Vector3::new(1.0, 2.0, 3.0) * f64::from(i) / 7.0).collect();
        let upright: Vec<_> = (0..9).map(|i| Vector3::z() * f64::from(i)).collect();
        let point = vec![Vector3::new(0.1, 0.2, 0.3); 9];
        let fails = |points: &[Vector3<f64>], kind| align(&pairs_of(points, |x| x), kind).is_err();
        for kind in [AlignmentKind::Se3, AlignmentKind::Sim3] {
            assert!(fails(&line, kind) && fails(&upright, kind) && fails(&point, kind), "{kind}");
        }
        assert!(fails(&upright, AlignmentKind::YawPosition) && fails(&point, AlignmentKind::YawPosition));
        assert!(!fails(&line, AlignmentKind::YawPosition));
        assert!(!fails(&point, AlignmentKind::Position));
        let plane: Vec<_> = (0..9).map(|i| Vector3::new(f64::from(i), f64::from(i * i), 0.0)).collect();
        assert!(!fails(&plane, AlignmentKind::Se3));
        let error = align(&pairs_of(&line[..2], |x| x), AlignmentKind::Se3).unwrap_err();
        assert!(error.to_string().starts_with("2 pairs of poses; SE(3) alignment needs 3"), "{error}");
    }
}
