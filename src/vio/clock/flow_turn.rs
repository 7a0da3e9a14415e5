//! How a camera turned between two frames, from their tracks alone.
//!
//! First a rotation fitted to all rays beside a translation before points of one distance, the worst rays left out; from there the planes of points
//! that stand still (`frontend::two_view`), which hold whatever their distances are, and say how well the turn is known about each axis.
//!
//! A turn and a path move points much alike, above all before a wall, and from that first rotation the planes lead to a turn that is off by 5 degrees and fits less
//! well, in a third of the pairs of a hand-held phone. So they are followed from what the gyroscope turned as well, and what fits best is taken.

use crate::frontend::{TwoView, two_view};
use dpn_core::camera::CameraModel;
use dpn_core::geometry::nearest::nearest_orthogonal;
use dpn_core::geometry::so3;
use dpn_core::{Stamp, TrackFrame};
use nalgebra::{Matrix3, Matrix3x6, Matrix6, UnitQuaternion, Vector2, Vector3, Vector6};

/// Fewest tracks that two frames must share.
const FEWEST_TRACKS: usize = 12;
/// Share of the rays that is left out of the first fit as the worst.
const LEFT_OUT: f64 = 0.3;
/// Frames farther apart are not compared \[s\].
const LONGEST_S: f64 = 0.25;
/// Deviation of a ray from its plane \[px at the image's centre\].
pub(super) const TRACK_STD_PX: f64 = 0.5;
/// A turn that the planes move farther than this from the first fit is none \[rad\].
const FARTHEST: f64 = 0.1;
/// Of turns that leave up to so many times the least the likeliest is taken.
const ALIKE: f64 = 1.2;
/// No turn is known better than this \[rad\]: pixels of one image are off together.
const FLOOR: f64 = 3e-4;

/// A camera's turn from one frame to the next.
#[derive(Debug, Clone, Copy)]
pub(crate) struct FlowTurn {
    /// The frames' stamps.
    pub(crate) from: Stamp,
    pub(crate) to: Stamp,
    /// The camera's rotation, `Exp(turn) = from_from_to`, in its own axes \[rad\].
    pub(crate) turn: Vector3<f64>,
    /// Its information, as the planes have it \[1/rad^2\].
    pub(crate) information: Matrix3<f64>,
    /// The direction of the camera's path in its axes at `to`, of length one.
    pub(crate) path: Vector3<f64>,
}

impl FlowTurn {
    /// From frame to frame \[s\].
    pub(crate) fn seconds(&self) -> f64 {
        self.to.seconds_since(self.from)
    }
}

/// The rays that two frames share, until a turn is made of them.
#[derive(Debug, Clone)]
pub(crate) struct SharedRays {
    pub(crate) from: Stamp,
    pub(crate) to: Stamp,
    rays: Vec<[Vector3<f64>; 2]>,
    /// Deviation of a ray from its plane \[rad\].
    std: f64,
}

impl SharedRays {
    /// From what two frames share, as [`TrackFrame::shared`] gives it; `None` where they are too far apart.
    pub(crate) fn of(
        (a, b): (&TrackFrame, &TrackFrame),
        shared: &[(Vector2<f64>, Vector2<f64>)],
        camera: &CameraModel,
    ) -> Option<Self> {
        let seconds = b.t.seconds_since(a.t);
        if !(seconds > 0.0 && seconds <= LONGEST_S) {
            return None;
        }
        let ray = |px| camera.bearing(px);
        let rays = shared.iter().filter_map(|(before, px)| Some([ray(before)?, ray(px)?]));
        Some(Self { from: a.t, to: b.t, rays: rays.collect(), std: TRACK_STD_PX / camera.px_per_rad() })
    }

    /// The turn, where they are enough for one. `foretold` are turns `to_from_from` of the camera to look near as well, the likeliest first.
    pub(crate) fn turn(mut self, foretold: &[UnitQuaternion<f64>]) -> Option<FlowTurn> {
        let (first, path) = rotation_of(&mut self.rays)?;
        let alone = self.near(first, path.try_normalize(1e-9).unwrap_or_else(Vector3::x));
        let foretold = foretold.iter().filter_map(|turn| self.near(*turn, path_beside(&self.rays, turn)));
        let found: Vec<Near> = foretold.chain(alone).collect();
        let least = found.iter().map(|found| found.left).fold(f64::INFINITY, f64::min);
        let found = found.iter().find(|found| found.left <= ALIKE * least)?;
        let covariance = found.information.try_inverse()? + Matrix3::identity() * (FLOOR * FLOOR);
        Some(FlowTurn {
            from: self.from,
            to: self.to,
            // A camera turning by d carries points by the inverse.
            turn: so3::log(&found.b_from_a.inverse()),
            information: covariance.try_inverse()?,
            path: found.path,
        })
    }

    /// What the planes hold near a turn; none where they lead far away.
    fn near(&self, first: UnitQuaternion<f64>, mut path: Vector3<f64>) -> Option<Near> {
        let (mut b_from_a, mut information) = (first, Matrix3::zeros());
        // The planes' equations are of small turns: once more from where they led.
        for _ in 0..2 {
            let turned: Vec<_> = self.rays.iter().map(|[prev, cur]| [b_from_a * prev, *cur]).collect();
            let found = TwoView::of(&turned, (Vector3::zeros(), Matrix3::zeros()), path, self.std)?;
            b_from_a = so3::exp(&found.turn) * b_from_a;
            (path, information) = (found.path, found.information);
        }
        let sane = b_from_a.angle_to(&first) < FARTHEST && information.iter().all(|v| v.is_finite());
        let basis = [1, 2].map(|k| two_view::across(&path, k));
        let left = self.rays.iter().filter_map(|[a, b]| {
            let (residual, _) = two_view::plane(&path, &basis, &Vector3::zeros(), &(b_from_a * a), b)?;
            let square = (residual / (2.0 * self.std)).powi(2);
            Some(square / (1.0 + square))
        });
        let left = left.sum();
        sane.then_some(Near { b_from_a, path, information, left })
    }
}

/// A turn that the planes hold.
#[derive(Debug, Clone, Copy)]
struct Near {
    b_from_a: UnitQuaternion<f64>,
    path: Vector3<f64>,
    information: Matrix3<f64>,
    /// The planes' residuals by the measure of Geman and McClure, each less than 1.
    left: f64,
}

/// The path of a camera that turns by `b_from_a`: what is most nearly across all that points move by beside.
fn path_beside(rays: &[[Vector3<f64>; 2]], b_from_a: &UnitQuaternion<f64>) -> Vector3<f64> {
    let normals = rays.iter().map(|[a, b]| (b_from_a * a).cross(b));
    let squares: Matrix3<f64> = normals.map(|normal| normal * normal.transpose()).sum();
    let eigen = squares.symmetric_eigen();
    eigen.eigenvectors.column(eigen.eigenvalues.imin()).into_owned()
}

/// The rotation that carries the first rays to the second, beside a translation before points of one distance; the worst rays left out.
fn rotation_of(rays: &mut [[Vector3<f64>; 2]]) -> Option<(UnitQuaternion<f64>, Vector3<f64>)> {
    let keep = ((1.0 - LEFT_OUT) * rays.len() as f64) as usize;
    if keep < FEWEST_TRACKS {
        return None;
    }
    let cross = rays.iter().map(|[a, b]| b * a.transpose()).sum::<Matrix3<f64>>();
    let mut rotation = UnitQuaternion::from_rotation_matrix(&nearest_orthogonal(&cross).0);
    let mut shift = Vector3::zeros();
    for round in 0..3 {
        let used = if round == 0 { rays.len() } else { keep };
        let (turn, moved) = step(&rays[..used], &rotation)?;
        rotation = so3::exp(&turn) * rotation;
        shift = moved;
        // A square's bits are in its order.
        rays.sort_by_cached_key(|[a, b]| across(b, &(rotation * a + shift)).norm_squared().to_bits());
    }
    shift.iter().all(|v| v.is_finite()).then_some((rotation, shift))
}

/// What of `v` is across the ray `b`.
fn across(b: &Vector3<f64>, v: &Vector3<f64>) -> Vector3<f64> {
    v - b * b.dot(v)
}

/// Least squares over a small turn `d` and a translation `t` in units of the points' distance: across b, `b = Exp(d) R a + t`.
fn step(rays: &[[Vector3<f64>; 2]], rotation: &UnitQuaternion<f64>) -> Option<(Vector3<f64>, Vector3<f64>)> {
    let (mut normal, mut right) = (Matrix6::zeros(), Vector6::zeros());
    for [a, b] in rays {
        let turned = rotation * a;
        let project = Matrix3::identity() - b * b.transpose();
        let mut rows = Matrix3x6::zeros();
        // Exp(d) r = r - hat(r) d
        rows.fixed_view_mut::<3, 3>(0, 0).copy_from(&(-project * turned.cross_matrix()));
        rows.fixed_view_mut::<3, 3>(0, 3).copy_from(&project);
        normal += rows.transpose() * rows;
        right -= rows.transpose() * (project * turned);
    }
    let found = normal.cholesky()?.solve(&right);
    Some((found.fixed_rows::<3>(0).into_owned(), found.fixed_rows::<3>(3).into_owned()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use dpn_core::Track;
    use dpn_core::random::Stream;
    use rand::Rng;
    use rand_distr::StandardNormal;

    /// What frames a tenth of a second apart share of points, the second one turned and `path` on: a point, and how far it is off in the second one \[px\].
    fn views(
        count: u64,
        (a_from_b, path): (&UnitQuaternion<f64>, &Vector3<f64>),
        camera: &CameraModel,
        normal: &mut impl FnMut() -> f64,
        mut point: impl FnMut(u64, &mut dyn FnMut() -> f64) -> (Vector3<f64>, f64),
    ) -> SharedRays {
        let (mut a, mut b) = (Vec::new(), Vec::new());
        for id in 0..count {
            let (point, off) = point(id, normal);
            let mut seen = |point: &Vector3<f64>, noise: f64| {
                let px = camera.project(point).filter(|px| camera.contains(px, 0.0))?;
                Some(Track { id, px: px + Vector2::new(normal(), normal()) * noise })
            };
            let pair = seen(&point, 0.35).zip(seen(&(a_from_b.inverse() * (point - path)), off));
            a.extend(pair.map(|pair| pair.0));
            b.extend(pair.map(|pair| pair.1));
        }
        let a = TrackFrame::new(Stamp::from_ns(0), a);
        let b = TrackFrame::new(Stamp::from_ns(100_000_000), b);
        SharedRays::of((&a, &b), &b.shared(&a), camera).unwrap()
    }

    /// Of two hundred pairs of views before points 1 to 9 m away, half a pixel of noise and a tenth of wrong tracks: none is lost, and of a camera that only turns
    /// the deviation is what it says. Beside a path, depths that differ make it two to three times that: a delay's deviation is scaled by what its fit leaves over.
    #[test]
    fn turns_are_found_beside_a_path_and_without_one_are_known_as_well_as_they_say() {
        let mut rng = Stream::new(3).named("flow turns").rng();
        let mut normal = move || -> f64 { rng.sample(StandardNormal) };
        let camera = CameraModel::euroc_cam0();
        for path_m in [0.0, 0.03] {
            let (mut squares, mut lost) = (Vec::new(), 0);
            for _ in 0..200 {
                let turn = Vector3::from_fn(|_, _| 0.05 * normal());
                let a_from_b = so3::exp(&turn);
                let path = Vector3::from_fn(|_, _| normal()).normalize() * path_m;
                let rays = views(120, (&a_from_b, &path), &camera, &mut normal, |id, normal| {
                    let ray = Vector3::new(0.5 * normal(), 0.3 * normal(), 1.0);
                    (ray * (5.0 + 4.0 * normal().tanh()), if id % 10 == 0 { 8.0 } else { 0.35 })
                });
                let found = rays.turn(&[]).unwrap();
                let off = found.turn - turn;
                lost += usize::from(off.norm() > 0.03);
                squares.push(off.dot(&(found.information * off)));
            }
            squares.sort_by(f64::total_cmp);
            assert_eq!(lost, 0, "{path_m} m");
            // The median of chi-squared with three degrees of freedom is 2.37; less, for no turn is said to be known to better than .0003 rad.
            let most = if path_m == 0.0 { 3.5 } else { 40.0 };
            assert!((0.3..most).contains(&squares[100]), "{path_m} m: {}", squares[100]);
        }
    }

    /// A camera that passes a wall 2 m away by 8 to 20 cm, its gyroscope's turn off by a degree as a clock that is off by 40 ms makes it.
    #[test]
    fn before_a_wall_a_turn_is_found_near_what_the_gyroscope_turned_and_lost_without_it() {
        let mut rng = Stream::new(4).named("flow turns before a wall").rng();
        let mut normal = move || -> f64 { rng.sample(StandardNormal) };
        let camera = CameraModel::euroc_cam0();
        let mut lost = [0, 0];
        for _ in 0..100 {
            let turn = Vector3::from_fn(|_, _| 0.03 * normal());
            let a_from_b = so3::exp(&turn);
            let path = Vector3::new(normal(), normal(), 0.3 * normal()).normalize()
                * (0.14 + 0.06 * normal().tanh());
            let tilt = so3::exp(&(Vector3::new(normal(), normal(), 0.0) * 0.3)) * Vector3::z();
            let rays = views(80, (&a_from_b, &path), &camera, &mut normal, |_, normal| {
                let ray = Vector3::new(0.5 * normal(), 0.3 * normal(), 1.0);
                (ray * (2.0 * tilt.z / tilt.dot(&ray)), 0.35)
            });
            let off = Vector3::from_fn(|_, _| 0.01 * normal());
            let foretold = [so3::exp(&(turn + off)).inverse()];
            for (lost, foretold) in lost.iter_mut().zip([&foretold[..], &[]]) {
                let found = rays.clone().turn(foretold);
                *lost += usize::from(found.is_none_or(|found| (found.turn - turn).norm() > 0.02));
            }
        }
        assert!(lost[0] == 0 && lost[1] >= 5, "lost {lost:?}");
    }
}
