//! The direction of motion when the rotation is known.

// With indices the loops read as the formulas do, and the compiler makes vectors of them.
#![allow(clippy::needless_range_loop)]

use super::pair::Pair;
use nalgebra::{Matrix3, SymmetricEigen, UnitQuaternion, Vector3};

/// Pairs with the rotation taken out.
pub(super) struct Derotated {
    rotation: Matrix3<f64>,
    /// Each earlier bearing, turned into the later frame.
    turned: Vec<Vector3<f64>>,
    /// Normals of the planes that hold both bearings and the path; their length is the sine of the angle between them.
    normals: Vec<Vector3<f64>>,
}

impl Derotated {
    pub(super) fn new(pairs: &[Pair], cur_from_prev: &UnitQuaternion<f64>) -> Self {
        let turned: Vec<_> = pairs.iter().map(|pair| cur_from_prev * pair.prev).collect();
        let normals = turned.iter().zip(pairs).map(|(turned, pair)| turned.cross(&pair.cur)).collect();
        Self { rotation: cur_from_prev.to_rotation_matrix().into_inner(), turned, normals }
    }

    /// The matrix for a direction of motion.
    fn essential(&self, direction: &Vector3<f64>) -> Matrix3<f64> {
        direction.cross_matrix() * self.rotation
    }

    /// The motion two tracks say; none where they say the same or nothing.
    pub(super) fn solve(&self, [a, b]: [usize; 2]) -> Option<Matrix3<f64>> {
        let direction = self.normals[a].cross(&self.normals[b]).try_normalize(1e-16)?;
        Some(self.essential(&direction))
    }

    /// The motion that `inliers` say together: across all their normals, as well as can be.
    pub(super) fn refit(
        &self,
        pairs: &[Pair],
        inliers: &[bool],
        near: &Matrix3<f64>,
    ) -> Option<Matrix3<f64>> {
        let mut scatter = Matrix3::zeros();
        for (i, pair) in pairs.iter().enumerate().filter(|(i, _)| inliers[*i]) {
            let scale = (near * pair.prev).norm_squared() + near.tr_mul(&pair.cur).norm_squared();
            if scale > 0.0 {
                scatter += self.normals[i] * self.normals[i].transpose() / scale;
            }
        }
        let eigen = SymmetricEigen::new(scatter);
        let smallest = eigen.eigenvalues.imin();
        let direction = eigen.eigenvectors.column(smallest).into_owned();
        direction.iter().all(|v| v.is_finite()).then(|| self.essential(&direction))
    }

    /// Takes out tracks that moved by more than twice the threshold \[rad\] towards where the camera came from: no point in front
    /// of it does so. Which of the two ends of the path that is, most of the others say.
    pub(super) fn reject_wrong_way(
        &self,
        pairs: &[Pair],
        essential: &Matrix3<f64>,
        threshold: f64,
        inliers: &mut [bool],
    ) {
        // E = hat(t) R; t from the matrix's antisymmetric part.
        let hat = essential * self.rotation.transpose();
        let path = Vector3::new(hat[(2, 1)], hat[(0, 2)], hat[(1, 0)]);
        // From depth_prev * turned + t = depth_cur * cur, crossed with cur: depth_prev * normal = -t x cur.
        let side = |i: usize| -path.cross(&pairs[i].cur).dot(&self.normals[i]);
        let moved =
            |i: usize| self.normals[i].norm() > 2.0 * threshold && self.turned[i].dot(&pairs[i].cur) > 0.0;
        let votes: i32 = (0..pairs.len())
            .filter(|&i| inliers[i] && moved(i))
            .map(|i| if side(i) > 0.0 { 1 } else { -1 })
            .sum();
        let sign = f64::from(votes.signum());
        for i in 0..pairs.len() {
            if moved(i) && side(i) * sign < 0.0 {
                inliers[i] = false;
            }
        }
    }
}
