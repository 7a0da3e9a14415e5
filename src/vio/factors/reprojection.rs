//! Visual residual: a landmark, anchored by inverse depth on the ray of the first frame that saw it, seen again by another frame.
//!
//! ```text
//! u = R_bc m + l t_bc                                  the landmark in the host's body frame, times l
//! w = R_wb,j^T (R_wb,i u + l (p_i + e_i v_i - p_j - e_j v_j))   in the target's body frame, times l
//! q = R_bc^T (w - l t_bc)                              in the target's camera, times l
//! r = M (q/|q| - b)                                    2 rows, in standard deviations
//! ```
//! `m = (x, y, 1)` is the host's ray, `l` the inverse depth along the camera's z \[1/m\], `b` the unit bearing measured in the target,
//! `M` = (pixels per radian on the tangent plane at b, through the lens) / (deviation of a pixel). Everything is multiplied by `l`, so
//! that a point at infinity (`l = 0`) is a point like others. Source: Qin et al. 2018, sec. VI-C, for the unit sphere; inverse depth
//! as in Civera et al. 2008.
//!
//! `e` is how long after its frame's stamp a measurement's line was exposed, `v` the velocity of the camera's centre in the world then: where
//! lines are taken one after the other the camera moves meanwhile. (Its turn is taken out of the bearings before; see `frontend::line_turns`.)
//! Of `v` no derivative is taken: a tenth off, it moves the camera by a millimetre. All `e` are 0 where an image is taken at once.
//!
//! The camera clock's offset `s` moves both measurements along the track's own velocity: `m(s) = m + s m'`, `b(s)` likewise
//! (Qin and Shen 2018, eq. 3).

use dpn_core::camera::CameraModel;
use dpn_core::geometry::{so3::hat, sphere::tangent_basis};
use nalgebra::{Isometry3, Matrix2, Matrix2x3, Matrix3, Vector2, Vector3};

/// One frame's measurement of one track, made ready for the residual.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sighting {
    /// The ray `(x, y, 1)` in the camera's frame.
    pub ray: Vector3<f64>,
    /// The unit vector along it.
    pub bearing: Vector3<f64>,
    /// `M` above \[1/rad\].
    pub whiten: Matrix2x3<f64>,
    /// How far `(x, y)` of the ray moves when the pixel is one deviation off.
    pub spread: Matrix2<f64>,
    /// How the ray moves \[1/s\]; zero where the track has no neighbour in time.
    pub ray_rate: Vector3<f64>,
    /// How long after the frame's stamp it was exposed \[s\].
    pub delay_s: f64,
    /// The part of its information that no prior holds yet, 0 to 1.
    pub left: f64,
}

impl Sighting {
    /// The measurement at pixel `px`, good to `px_std` \[px\]; `None` where the lens has no inverse.
    pub fn new(camera: &CameraModel, px: &Vector2<f64>, px_std: f64) -> Option<Self> {
        let normalised = camera.normalise(px)?;
        let ray = Vector3::new(normalised.x, normalised.y, 1.0);
        let bearing = ray.normalize();
        let (_, d_px_d_point) = camera.project_with_jacobian(&bearing)?;
        // A pixel moves with the point's depth along the ray only: at depth 1 the first two columns are the derivative by (x, y).
        let (_, d_px_d_ray) = camera.project_with_jacobian(&ray)?;
        let spread = d_px_d_ray.fixed_columns::<2>(0).try_inverse()? * px_std;
        let basis = tangent_basis(&bearing);
        let whiten = d_px_d_point * basis * basis.transpose() / px_std;
        Some(Self { ray, bearing, whiten, spread, ray_rate: Vector3::zeros(), delay_s: 0.0, left: 1.0 })
    }

    /// The measurement of a unit `bearing`, good to `std` \[rad\] across it; `None` unless it is before the camera.
    pub(crate) fn from_bearing(bearing: &Vector3<f64>, std: f64) -> Option<Self> {
        if bearing.z.is_nan() || bearing.z < 1e-3 {
            return None;
        }
        let ray = bearing / bearing.z;
        let basis = tangent_basis(bearing);
        let spread = Matrix2::from_fn(|r, c| (basis[(r, c)] - ray[r] * basis[(2, c)]) / bearing.z) * std;
        let whiten = basis.transpose() / std;
        Some(Self {
            ray,
            bearing: *bearing,
            whiten,
            spread,
            ray_rate: Vector3::zeros(),
            delay_s: 0.0,
            left: 1.0,
        })
    }

    /// Says that it is `factor` times as far off as thought.
    pub(crate) fn rescale(&mut self, factor: f64) {
        self.whiten /= factor;
        self.spread *= factor;
    }
}

/// Columns of [`PairGeometry::by_q`].
const BY_Q: usize = 12;

/// What all landmarks of one host and one target share.
#[derive(Debug, Clone, Copy)]
pub(crate) struct PairGeometry {
    /// `R_bc^T R_wb,j^T`: world to the target's camera.
    cam_from_world: Matrix3<f64>,
    /// `R_bc^T R_wb,j^T R_wb,i`.
    cam_from_host: Matrix3<f64>,
    /// `R_bc^T R_wb,j^T R_wb,i R_bc`: the host's camera to the target's.
    cam_from_host_cam: Matrix3<f64>,
    /// `dq/dl`: the host camera's origin in the target's camera.
    host_cam_in_cam: Vector3<f64>,
    body_from_cam: Matrix3<f64>,
    cam_in_body: Vector3<f64>,
    /// Row by row `[R_bc^T R_wb,j^T, R_bc^T R_wb,j^T R_wb,i, R_bc^T, R_bc^T R_wb,j^T R_wb,i R_bc]`: what a derivative by `q` is multiplied with for
    /// those by the host's position, its rotation, the target's rotation and the host's ray, side by side, so that it is done once, in vectors.
    by_q: [[f64; BY_Q]; 3],
    /// Velocities of the host's camera and of the target's, both in the target's camera.
    velocities: [Vector3<f64>; 2],
}

impl PairGeometry {
    /// From both bodies' poses and the camera's place on the body.
    pub(crate) fn new(
        world_from_host: &Isometry3<f64>,
        world_from_target: &Isometry3<f64>,
        body_from_cam: &Isometry3<f64>,
    ) -> Self {
        let r_wi = world_from_host.rotation.to_rotation_matrix().into_inner();
        let r_wj = world_from_target.rotation.to_rotation_matrix().into_inner();
        let r_bc = body_from_cam.rotation.to_rotation_matrix().into_inner();
        let t_bc = body_from_cam.translation.vector;
        let target_from_host = r_wj.tr_mul(&r_wi);
        let offset = world_from_host.translation.vector - world_from_target.translation.vector;
        let host_in_target = r_wj.tr_mul(&offset);
        let cam_from_world = (r_wj * r_bc).transpose();
        let cam_from_host = r_bc.tr_mul(&target_from_host);
        let cam_from_host_cam = cam_from_host * r_bc;
        let side_by_side = [cam_from_world, cam_from_host, r_bc.transpose(), cam_from_host_cam];
        Self {
            cam_from_world,
            cam_from_host,
            cam_from_host_cam,
            by_q: std::array::from_fn(|r| std::array::from_fn(|c| side_by_side[c / 3][(r, c % 3)])),
            host_cam_in_cam: r_bc.tr_mul(&(target_from_host * t_bc + host_in_target - t_bc)),
            body_from_cam: r_bc,
            cam_in_body: t_bc,
            velocities: [Vector3::zeros(); 2],
        }
    }

    /// With the velocities of the host's and of the target's camera in the world \[m/s\].
    pub(crate) fn moving(self, host: &Vector3<f64>, target: &Vector3<f64>) -> Self {
        Self { velocities: [host, target].map(|velocity| self.cam_from_world * velocity), ..self }
    }

    /// How far the host's camera has moved against the target's at their measurements' instants, in the target's camera; `None` where both are
    /// at their frames' stamps.
    #[inline(always)]
    fn moved(&self, host: &Sighting, target: &Sighting) -> Option<Vector3<f64>> {
        let [of_host, of_target] = &self.velocities;
        (host.delay_s != 0.0 || target.delay_s != 0.0)
            .then(|| host.delay_s * of_host - target.delay_s * of_target)
    }

    /// The residual alone \[standard deviations\].
    #[inline(always)]
    pub(crate) fn residual(&self, host: &Sighting, target: &Sighting, inverse_depth: f64) -> Vector2<f64> {
        self.project(host, target, inverse_depth).residual
    }

    /// Where the target's camera has the point, and the residual there.
    #[inline(always)]
    pub(crate) fn project(&self, host: &Sighting, target: &Sighting, inverse_depth: f64) -> Projected {
        let mut host_cam = self.host_cam_in_cam;
        if let Some(moved) = self.moved(host, target) {
            host_cam += moved;
        }
        let q = self.cam_from_host_cam * host.ray + inverse_depth * host_cam;
        let inverse_norm = 1.0 / q.norm();
        let direction = q * inverse_norm;
        let residual = target.whiten * (direction - target.bearing);
        Projected { residual, host_cam, q, direction, inverse_norm }
    }

    /// The residual and its derivatives.
    pub(crate) fn linearise(&self, host: &Sighting, target: &Sighting, inverse_depth: f64) -> Linearised {
        self.derive(&self.project(host, target, inverse_depth), host, target, inverse_depth)
    }

    /// The derivatives at what was [projected](Self::project).
    #[inline(always)]
    pub(crate) fn derive(
        &self,
        projected: &Projected,
        host: &Sighting,
        target: &Sighting,
        inverse_depth: f64,
    ) -> Linearised {
        let Projected { residual, host_cam, q, direction, inverse_norm } = *projected;
        let u = self.body_from_cam * host.ray + inverse_depth * self.cam_in_body;
        let w = self.body_from_cam * q + inverse_depth * self.cam_in_body;
        // M (I - d d^T)/|q|
        let d_q = (target.whiten - (target.whiten * direction) * direction.transpose()) * inverse_norm;
        let d_depth = d_q * host_cam;
        let mut host_rows = [[0.0; 6]; 2];
        let mut target_rows = [[0.0; 6]; 2];
        let mut ray_rows = [[0.0; 3]; 2];
        for r in 0..2 {
            let by = self.times_by_q([d_q[(r, 0)], d_q[(r, 1)], d_q[(r, 2)]]);
            // A row times hat(v) is the cross product of the row with v.
            let turn_host = u.cross(&Vector3::new(by[3], by[4], by[5]));
            let turn_target = Vector3::new(by[6], by[7], by[8]).cross(&w);
            for k in 0..3 {
                host_rows[r][k] = by[k] * inverse_depth;
                host_rows[r][3 + k] = turn_host[k];
                target_rows[r][k] = -host_rows[r][k];
                target_rows[r][3 + k] = turn_target[k];
                ray_rows[r][k] = by[9 + k];
            }
        }
        let depth = [d_depth.x, d_depth.y];
        Linearised { residual, host: host_rows, target: target_rows, depth, d_ray: ray_rows, d_q, q }
    }

    /// A row by `q`, multiplied with [`Self::by_q`].
    #[inline(always)]
    fn times_by_q(&self, row: [f64; 3]) -> [f64; BY_Q] {
        let [a, b, c] = &self.by_q;
        std::array::from_fn(|k| row[0] * a[k] + row[1] * b[k] + row[2] * c[k])
    }

    /// Derivative by the camera's place on the body: its position, then its rotation on the right.
    pub(crate) fn d_camera(&self, at: &Linearised, ray: &Vector3<f64>, inverse_depth: f64) -> [[f64; 6]; 2] {
        let d_position = at.d_q * (self.cam_from_host - self.body_from_cam.transpose()) * inverse_depth;
        // Once through R_bc^T on the left of everything, once through R_bc on the ray.
        let d_rotation = at.d_q * (hat(&at.q) - self.cam_from_host_cam * hat(ray));
        let mut rows = [[0.0; 6]; 2];
        for r in 0..2 {
            for k in 0..3 {
                rows[r][k] = d_position[(r, k)];
                rows[r][3 + k] = d_rotation[(r, k)];
            }
        }
        rows
    }

    /// Derivative by the camera clock's offset, both measurements moving along their tracks.
    pub(crate) fn d_offset(&self, at: &Linearised, host: &Sighting, target: &Sighting) -> [f64; 2] {
        let d_ray = at.d_q * (self.cam_from_host_cam * host.ray_rate);
        let along =
            (target.ray_rate - target.bearing * target.bearing.dot(&target.ray_rate)) / target.ray.norm();
        let d_bearing = target.whiten * along;
        [d_ray.x - d_bearing.x, d_ray.y - d_bearing.y]
    }
}

/// A point as the target's camera has it.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Projected {
    /// In standard deviations.
    pub(crate) residual: Vector2<f64>,
    /// The host's camera in the target's.
    host_cam: Vector3<f64>,
    q: Vector3<f64>,
    /// `q/|q|`.
    direction: Vector3<f64>,
    /// `1/|q|`.
    inverse_norm: f64,
}

/// A residual and its derivatives: rows as arrays, for the normal equations.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Linearised {
    /// In standard deviations.
    pub residual: Vector2<f64>,
    /// By the host's position and rotation.
    pub host: [[f64; 6]; 2],
    /// By the target's position and rotation.
    pub target: [[f64; 6]; 2],
    /// By the inverse depth.
    pub depth: [f64; 2],
    /// By the host's ray.
    d_ray: [[f64; 3]; 2],
    d_q: Matrix2x3<f64>,
    q: Vector3<f64>,
}

impl Linearised {
    /// Derivative by the host's own pixel \[deviations of it\]: the measurement that anchors a landmark is as noisy as the others.
    #[inline(always)]
    pub(crate) fn d_host_pixel(&self, spread: &Matrix2<f64>) -> [[f64; 2]; 2] {
        self.d_ray.map(|by| [0, 1].map(|k| by[0] * spread[(0, k)] + by[1] * spread[(1, k)]))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::state::{pose_minus, pose_plus};
    use dpn_core::random::Stream;
    use dpn_testing::check_jacobian;
    use nalgebra::{DVector, Matrix2x6, SVector, Vector6};
    use rand::Rng;

    struct Case {
        host: Isometry3<f64>,
        target: Isometry3<f64>,
        body_from_cam: Isometry3<f64>,
        seen_by_host: Sighting,
        seen_by_target: Sighting,
        inverse_depth: f64,
        /// Of both cameras, in the world.
        velocities: [Vector3<f64>; 2],
    }

    impl Case {
        fn random(seed: u64) -> Self {
            let mut rng = Stream::new(seed).named("reprojection").rng();
            let mut vector = |scale: f64| Vector6::from_fn(|_, _| scale * rng.random_range(-1.0..1.0));
            let host = pose_plus(&Isometry3::identity(), &vector(2.0));
            let target = pose_plus(&host, &vector(0.3));
            let body_from_cam = pose_plus(&Isometry3::identity(), &vector(1.0));
            let camera = CameraModel::euroc_cam0();
            let mut px = || Vector2::new(rng.random_range(200.0..550.0), rng.random_range(100.0..380.0));
            let mut seen_by_host = Sighting::new(&camera, &px(), 0.7).unwrap();
            let mut seen_by_target = Sighting::new(&camera, &px(), 0.7).unwrap();
            seen_by_host.ray_rate = Vector3::new(0.3, -0.2, 0.0);
            seen_by_target.ray_rate = Vector3::new(-0.5, 0.4, 0.0);
            let inverse_depth = [0.0, 0.05, 0.4, 1.5][seed as usize % 4];
            // Half of the cases are of an image taken at once.
            let mut velocity = || Vector3::from_fn(|_, _| rng.random_range(-2.0..2.0));
            let velocities = [velocity(), velocity()];
            if seed % 8 > 3 {
                (seen_by_host.delay_s, seen_by_target.delay_s) = (0.012, -0.015);
            }
            Self { host, target, body_from_cam, seen_by_host, seen_by_target, inverse_depth, velocities }
        }

        fn geometry(&self) -> PairGeometry {
            let [host, target] = &self.velocities;
            PairGeometry::new(&self.host, &self.target, &self.body_from_cam).moving(host, target)
        }

        fn residual(&self) -> DVector<f64> {
            let r = self.geometry().residual(&self.seen_by_host, &self.seen_by_target, self.inverse_depth);
            DVector::from_column_slice(r.as_slice())
        }
    }

    fn matrix(rows: &[[f64; 6]; 2]) -> Matrix2x6<f64> {
        Matrix2x6::from_fn(|r, c| rows[r][c])
    }

    fn six(d: &DVector<f64>) -> SVector<f64, 6> {
        SVector::from_column_slice(d.as_slice())
    }

    /// Far from the measured bearing the residual is large and curved; 1e-6 of the largest entry is what differences can show.
    const TOLERANCE: f64 = 1e-6;

    #[test]
    fn jacobians_are_the_derivatives() {
        for seed in 0..40 {
            let case = Case::random(seed);
            let geometry = case.geometry();
            let at = geometry.linearise(&case.seen_by_host, &case.seen_by_target, case.inverse_depth);
            assert!((DVector::from_column_slice(at.residual.as_slice()) - case.residual()).amax() < 1e-12);
            check_jacobian("d_res_d_host", &matrix(&at.host), TOLERANCE, |d| {
                Case { host: pose_plus(&case.host, &six(d)), ..Case::random(seed) }.residual()
            });
            check_jacobian("d_res_d_target", &matrix(&at.target), TOLERANCE, |d| {
                Case { target: pose_plus(&case.target, &six(d)), ..Case::random(seed) }.residual()
            });
            let d_camera = geometry.d_camera(&at, &case.seen_by_host.ray, case.inverse_depth);
            check_jacobian("d_res_d_camera", &matrix(&d_camera), TOLERANCE, |d| {
                Case { body_from_cam: pose_plus(&case.body_from_cam, &six(d)), ..Case::random(seed) }
                    .residual()
            });
            check_jacobian("d_res_d_depth", &Vector2::from(at.depth), TOLERANCE, |d| {
                Case { inverse_depth: case.inverse_depth + d[0], ..Case::random(seed) }.residual()
            });
            let d_pixel = at.d_host_pixel(&case.seen_by_host.spread);
            check_jacobian("d_res_d_host_pixel", &Matrix2::from_fn(|r, c| d_pixel[r][c]), TOLERANCE, |d| {
                let mut moved = Case::random(seed);
                let camera = CameraModel::euroc_cam0();
                let px = camera.project(&moved.seen_by_host.ray).unwrap() + 0.7 * Vector2::new(d[0], d[1]);
                let delay_s = moved.seen_by_host.delay_s;
                moved.seen_by_host = Sighting { delay_s, ..Sighting::new(&camera, &px, 0.7).unwrap() };
                moved.residual()
            });
            let d_offset = geometry.d_offset(&at, &case.seen_by_host, &case.seen_by_target);
            check_jacobian("d_res_d_offset", &Vector2::from(d_offset), TOLERANCE, |d| {
                let mut moved = Case::random(seed);
                moved.seen_by_host.ray += d[0] * moved.seen_by_host.ray_rate;
                let ray = moved.seen_by_target.ray + d[0] * moved.seen_by_target.ray_rate;
                moved.seen_by_target.bearing = ray.normalize();
                moved.residual()
            });
        }
    }

    #[test]
    fn a_bearing_is_a_sighting_whose_deviations_are_angles() {
        for seed in 0..20 {
            let mut rng = Stream::new(seed).named("bearing").rng();
            let bearing =
                Vector3::new(rng.random_range(-1.0..1.0), rng.random_range(-1.0..1.0), 1.5f64).normalize();
            let std = 3e-3;
            let seen = Sighting::from_bearing(&bearing, std).unwrap();
            let moved = |d: &DVector<f64>| {
                (bearing + tangent_basis(&bearing) * Vector2::new(d[0], d[1]) * std).normalize()
            };
            // Its own pixel, one deviation off, and what it says of a point seen elsewhere.
            check_jacobian("d_ray_d_pixel", &seen.spread, 1e-6, |d| {
                let ray = moved(d) / moved(d).z;
                DVector::from_column_slice(&[ray.x, ray.y])
            });
            check_jacobian("d_res_d_bearing", &Matrix2::identity(), 1e-6, |d| {
                DVector::from_column_slice((seen.whiten * (moved(d) - seen.bearing)).as_slice())
            });
            let mut louder = seen;
            louder.rescale(2.0);
            let again = Sighting::from_bearing(&bearing, 2.0 * std).unwrap();
            assert!(
                (louder.whiten - again.whiten).amax() < 1e-9 && (louder.spread - again.spread).amax() < 1e-15
            );
        }
        assert_eq!(Sighting::from_bearing(&Vector3::x(), 1e-3), None);
        assert_eq!(Sighting::from_bearing(&-Vector3::z(), 1e-3), None);
    }

    #[test]
    fn a_true_landmark_has_no_residual_and_a_pixel_off_is_one_over_its_deviation() {
        let camera = CameraModel::euroc_cam0();
        let body_from_cam = Case::random(3).body_from_cam;
        let host = Case::random(3).host;
        // One metre to the camera's right, looking the same way.
        let shift = body_from_cam.rotation * Vector3::x();
        let target = host * nalgebra::Translation3::from(shift);
        assert!(pose_minus(&target, &host).norm() > 0.9);
        let point = Vector3::new(0.5, -0.4, 4.0);
        let seen_by_host = Sighting::new(&camera, &camera.project(&point).unwrap(), 0.5).unwrap();
        let px = camera.project(&(point - Vector3::x())).unwrap();
        let geometry = PairGeometry::new(&host, &target, &body_from_cam);
        let seen = Sighting::new(&camera, &px, 0.5).unwrap();
        assert!(geometry.residual(&seen_by_host, &seen, 0.25).norm() < 1e-9);
        let off = Sighting::new(&camera, &(px + Vector2::new(0.6, 0.8)), 0.5).unwrap();
        assert!((geometry.residual(&seen_by_host, &off, 0.25).norm() - 2.0).abs() < 0.01);
    }

    #[test]
    fn a_line_taken_late_is_seen_from_where_the_camera_was_then() {
        let camera = CameraModel::euroc_cam0();
        for seed in 0..20 {
            let case = Case::random(seed);
            let delays = [0.014, -0.011];
            // Where both cameras were when their lines were exposed; they do not turn.
            let late = |body: &Isometry3<f64>, k: usize| {
                let cam = body * case.body_from_cam;
                nalgebra::Translation3::from(case.velocities[k] * delays[k]) * cam
            };
            let (host_cam, target_cam) = (late(&case.host, 0), late(&case.target, 1));
            let in_host = case.seen_by_host.ray * 3.0;
            let in_target = target_cam.inverse() * (host_cam * nalgebra::Point3::from(in_host));
            let Some(px) = camera.project(&in_target.coords) else { continue };
            let seen = Sighting { delay_s: delays[1], ..Sighting::new(&camera, &px, 0.5).unwrap() };
            let host = Sighting { delay_s: delays[0], ..case.seen_by_host };
            let inverse_depth = 1.0 / 3.0;
            assert!(case.geometry().residual(&host, &seen, inverse_depth).norm() < 1e-6);
            let at_once = Sighting { delay_s: 0.0, ..seen };
            assert!(case.geometry().residual(&host, &at_once, inverse_depth).norm() > 0.1);
        }
    }
}
