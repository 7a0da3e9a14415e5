//! The turn between two views, from the planes in which points that stand still lie.
//!
//! A track sees `y = R prev` and `z = cur` as unit vectors, `R` being a turn that is nearly right. The true turn is `Exp(d) R`, and a point that
//! stands still lies in the plane of `z`, `Exp(d) y` and the camera's path `p` (of length one):
//!
//! ```text
//! e = p . ((y + d x y) x z) / |p x y| = 0,   de/dd = ((p . y) z - (y . z) p) / |p x y|
//! ```
//!
//! Gauss-Newton over `d` and the two directions of `p`, with Huber's weights first and Geman and McClure's then, which leave out what moves
//! by itself. At rest and in pure rotation `p` is anything, and the planes still hold `d`.

use nalgebra::{Matrix3, Matrix5, Matrix5x1, SMatrix, Vector3, Vector5};

/// Steps of Gauss-Newton.
const STEPS: usize = 4;
/// Tracks nearer to the path's own direction than this \[rad\] say nothing.
const NEAR_EPIPOLE: f64 = 0.02;

/// What two views say of the turn between them.
#[derive(Debug, Clone, Copy)]
pub(crate) struct TwoView {
    /// The turn `d` that is left after `R` \[rad\].
    pub(crate) turn: Vector3<f64>,
    /// The camera's path, of length one.
    pub(crate) path: Vector3<f64>,
    /// Information about `d`, the path taken out, the prior's with it.
    pub(crate) information: Matrix3<f64>,
    /// Tracks within two deviations of what was found.
    pub(crate) fits: usize,
}

impl TwoView {
    /// From rays `[y, z]`, whose planes err by `std` \[rad\], and a prior of information `prior` about the turn `start`; `path` is where the search begins.
    /// `None` where the equations cannot be solved.
    pub(crate) fn of(
        rays: &[[Vector3<f64>; 2]],
        (start, prior): (Vector3<f64>, Matrix3<f64>),
        mut path: Vector3<f64>,
        std: f64,
    ) -> Option<Self> {
        let mut turn = start;
        let mut information = Matrix3::zeros();
        let mut fits = 0;
        for step in 0..STEPS {
            let basis = [1, 2].map(|k| across(&path, k));
            let mut normal = Matrix5::zeros();
            let mut right: Matrix5x1<f64> = Vector5::zeros();
            fits = 0;
            for [y, z] in rays {
                let Some((residual, slope)) = plane(&path, &basis, &turn, y, z) else { continue };
                let far = (residual / (2.0 * std)).abs();
                fits += usize::from(far < 2.0);
                let weight =
                    if step == 0 { (1.0 / far).min(1.0) } else { (1.0 + far * far).powi(-2) } / (std * std);
                normal += weight * slope * slope.transpose();
                right -= weight * residual * slope;
            }
            let mut corner = normal.fixed_view_mut::<3, 3>(0, 0);
            corner += prior;
            let pull = prior * (start - turn);
            let mut top = right.fixed_rows_mut::<3>(0);
            top += pull;
            // A path that nothing is said of stays where it is.
            normal[(3, 3)] += 1.0;
            normal[(4, 4)] += 1.0;
            let step = normal.cholesky()?.solve(&right);
            turn += step.fixed_rows::<3>(0);
            path = (path + basis[0] * step[3] + basis[1] * step[4]).normalize();
            information = taken_out(&normal);
        }
        Some(Self { turn, path, information, fits })
    }
}

/// Two directions at right angles to `axis` and to each other.
pub(crate) fn across(axis: &Vector3<f64>, which: usize) -> Vector3<f64> {
    let other = if axis.x.abs() < 0.7 { Vector3::x() } else { Vector3::y() };
    let first = axis.cross(&other).normalize();
    if which == 1 { first } else { axis.cross(&first) }
}

/// The residual of one track and its derivatives by the turn and along `basis`; none near the path's direction.
pub(crate) fn plane(
    path: &Vector3<f64>,
    basis: &[Vector3<f64>; 2],
    turn: &Vector3<f64>,
    y: &Vector3<f64>,
    z: &Vector3<f64>,
) -> Option<(f64, Vector5<f64>)> {
    let turned = y + turn.cross(y);
    let across = path.cross(&turned).norm();
    if across < NEAR_EPIPOLE {
        return None;
    }
    let normal = turned.cross(z);
    let by_turn = ((path.dot(y)) * z - (y.dot(z)) * path) / across;
    let by_path = basis.map(|direction| direction.dot(&normal) / across);
    let slope = Vector5::new(by_turn.x, by_turn.y, by_turn.z, by_path[0], by_path[1]);
    Some((path.dot(&normal) / across, slope))
}

/// What the normal matrix says of its first three unknowns, the last two taken out.
fn taken_out(normal: &Matrix5<f64>) -> Matrix3<f64> {
    let cross: SMatrix<f64, 3, 2> = normal.fixed_view::<3, 2>(0, 3).into_owned();
    let rest: SMatrix<f64, 2, 2> = normal.fixed_view::<2, 2>(3, 3).into_owned();
    let corner: Matrix3<f64> = normal.fixed_view::<3, 3>(0, 0).into_owned();
    rest.try_inverse().map_or(corner, |inverse| corner - cross * inverse * cross.transpose())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn derivatives_are_those_of_the_residual() {
        let path = Vector3::new(0.3, -0.8, 0.4).normalize();
        let basis = [1, 2].map(|k| across(&path, k));
        let (y, z) = (Vector3::new(0.2, 0.1, 1.0).normalize(), Vector3::new(0.25, 0.05, 1.0).normalize());
        let of = |turn: Vector3<f64>, path: Vector3<f64>| plane(&path, &basis, &turn, &y, &z).unwrap();
        let (residual, slope) = of(Vector3::zeros(), path);
        // The residual is at 0 turn; its denominator, which is taken for constant, moves little where it is near zero.
        assert!(residual.abs() < 0.1);
        for k in 0..3 {
            let step = Vector3::ith(k, 1e-6);
            let difference = (of(step, path).0 - of(-step, path).0) / 2e-6;
            assert!((difference - slope[k]).abs() < 0.1, "turn {k}: {difference} {}", slope[k]);
        }
        for k in 0..2 {
            let step = basis[k] * 1e-6;
            let difference =
                (of(Vector3::zeros(), path + step).0 - of(Vector3::zeros(), path - step).0) / 2e-6;
            assert!((difference - slope[3 + k]).abs() < 0.1, "path {k}: {difference} {}", slope[3 + k]);
        }
    }
}
