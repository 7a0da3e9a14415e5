//! A point as direction and inverse distance from a fixed origin, and what a frame sees of it.
//!
//! ```text
//! point = origin + u / rho            u a unit vector, rho >= 0 for a point before the origin, 0 at infinity
//! w = u + rho (origin - c)            direction from the camera's centre c, without dividing by rho
//! r = B(f)^T n,  n = m/|m|,  m = R_cw w
//! ```
//! `f` is the measured direction, `B(f)` an orthonormal basis of its tangent plane: the residual is the angle between them in two
//! directions \[rad\], for small ones. The origin is one fixed place in the world for all points, near the cameras: so a far
//! point is as well conditioned as a near one, and a residual depends on one frame alone. `rho` may go below 0 while a distance
//! is not observable; that keeps its error symmetric.

use dpn_core::geometry::so3::hat;
use dpn_core::geometry::sphere::tangent_basis;
use nalgebra::{Isometry3, Matrix2x3, Matrix3, SMatrix, Vector2, Vector3};

/// A point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Landmark {
    /// Unit vector from the origin, world frame.
    pub direction: Vector3<f64>,
    /// Inverse distance from the origin \[1/m\].
    pub inverse_distance: f64,
}

impl Landmark {
    /// The point moved by `d` in the tangent plane of its direction and along its inverse distance.
    pub(crate) fn plus(&self, d: &Vector3<f64>) -> Self {
        let moved = self.direction + tangent_basis(&self.direction) * d.fixed_rows::<2>(0);
        Self { direction: moved.normalize(), inverse_distance: self.inverse_distance + d.z }
    }

    /// Where it is; `None` unless it has a finite distance before the origin.
    pub(crate) fn point(&self, origin: &Vector3<f64>) -> Option<Vector3<f64>> {
        (self.inverse_distance > 1e-9).then(|| origin + self.direction / self.inverse_distance)
    }
}

/// A frame's camera, prepared for many points.
#[derive(Debug, Clone)]
pub(crate) struct Camera {
    r_bw: Matrix3<f64>,
    r_cb: Matrix3<f64>,
    r_cw: Matrix3<f64>,
    hat_cam_in_body: Matrix3<f64>,
    /// Its centre, world frame.
    pub centre: Vector3<f64>,
}

/// A view's residual and derivatives.
#[derive(Debug, Clone)]
pub(crate) struct ViewRows {
    /// Angle between measured and predicted direction \[rad\].
    pub residual: Vector2<f64>,
    /// By the frame's pose: position, rotation.
    pub d_pose: SMatrix<f64, 2, 6>,
    /// By the point.
    pub d_point: Matrix2x3<f64>,
}

impl Camera {
    /// The camera of a body at `world_from_body`.
    pub(crate) fn new(world_from_body: &Isometry3<f64>, body_from_cam: &Isometry3<f64>) -> Self {
        let r_bw = world_from_body.rotation.inverse().to_rotation_matrix().into_inner();
        let r_cb = body_from_cam.rotation.inverse().to_rotation_matrix().into_inner();
        let cam_in_body = body_from_cam.translation.vector;
        Self {
            r_cw: r_cb * r_bw,
            hat_cam_in_body: hat(&cam_in_body),
            centre: world_from_body * nalgebra::Point3::from(cam_in_body) - nalgebra::Point3::origin(),
            r_bw,
            r_cb,
        }
    }

    /// From the camera's frame to the world's.
    pub(crate) fn to_world(&self, direction: &Vector3<f64>) -> Vector3<f64> {
        self.r_cw.tr_mul(direction)
    }

    /// The residual of `measured`; `None` where the point is behind the camera or on its centre.
    pub(crate) fn residual(
        &self,
        origin: &Vector3<f64>,
        point: &Landmark,
        measured: &Vector3<f64>,
    ) -> Option<Vector2<f64>> {
        let in_cam = self.r_cw * (point.direction + point.inverse_distance * (origin - self.centre));
        let norm = in_cam.norm();
        (in_cam.dot(measured) > 1e-9).then(|| tangent_basis(measured).tr_mul(&in_cam) / norm)
    }

    /// As [`Self::residual`], with derivatives.
    pub(crate) fn rows(
        &self,
        origin: &Vector3<f64>,
        point: &Landmark,
        measured: &Vector3<f64>,
    ) -> Option<ViewRows> {
        let to_origin = origin - self.centre;
        let direction = point.direction + point.inverse_distance * to_origin;
        let in_cam = self.r_cw * direction;
        let norm = in_cam.norm();
        if in_cam.dot(measured) <= 1e-9 {
            return None;
        }
        let basis = tangent_basis(measured).transpose();
        let seen = in_cam / norm;
        let d_in_cam: Matrix2x3<f64> = (basis - basis * seen * seen.transpose()) / norm;
        let d_direction = d_in_cam * self.r_cw;

        let mut d_pose = SMatrix::<f64, 2, 6>::zeros();
        d_pose.fixed_columns_mut::<3>(0).copy_from(&(-point.inverse_distance * d_direction));
        let d_rotation =
            self.r_cb * (hat(&(self.r_bw * direction)) + point.inverse_distance * self.hat_cam_in_body);
        d_pose.fixed_columns_mut::<3>(3).copy_from(&(d_in_cam * d_rotation));

        let mut d_point = Matrix2x3::zeros();
        d_point.fixed_columns_mut::<2>(0).copy_from(&(d_direction * tangent_basis(&point.direction)));
        d_point.set_column(2, &(d_direction * to_origin));
        Some(ViewRows { residual: basis * seen, d_pose, d_point })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::state::pose_plus;
    use dpn_core::geometry::so3;
    use dpn_testing::check_jacobian;
    use nalgebra::{DVector, SVector};
    use proptest::prelude::*;

    fn pose(v: &[f64]) -> Isometry3<f64> {
        Isometry3::from_parts(
            Vector3::new(v[0], v[1], v[2]).into(),
            so3::exp(&Vector3::new(v[3], v[4], v[5])),
        )
    }

    proptest! {
        #[test]
        fn the_rows_are_the_residuals_derivatives(
            body in prop::array::uniform6(-1.0..1.0f64),
            extrinsics in prop::array::uniform6(-0.5..0.5f64),
            origin in prop::array::uniform3(-1.0..1.0f64),
            in_cam in prop::array::uniform2(-0.6..0.6f64),
            inverse_distance in -0.02..0.4f64,
            noise in prop::array::uniform2(-0.05..0.05f64),
        ) {
            let (world_from_body, body_from_cam) = (pose(&body), pose(&extrinsics));
            let origin = Vector3::from(origin);
            let camera = Camera::new(&world_from_body, &body_from_cam);
            let direction = camera.to_world(&Vector3::new(in_cam[0], in_cam[1], 1.0)).normalize();
            let point = Landmark { direction, inverse_distance };
            let measured = Vector3::new(in_cam[0] + noise[0], in_cam[1] + noise[1], 1.0).normalize();
            let Some(rows) = camera.rows(&origin, &point, &measured) else { return Ok(()) };
            let alone = camera.residual(&origin, &point, &measured).unwrap();
            prop_assert!((rows.residual - alone).norm() < 1e-15);
            let as_dynamic = |r: Vector2<f64>| DVector::from_column_slice(r.as_slice());
            check_jacobian("d_res_d_pose", &rows.d_pose, 1e-6, |d| {
                let moved = pose_plus(&world_from_body, &SVector::<f64, 6>::from_column_slice(d.as_slice()));
                as_dynamic(Camera::new(&moved, &body_from_cam).residual(&origin, &point, &measured).unwrap())
            });
            check_jacobian("d_res_d_point", &rows.d_point, 1e-6, |d| {
                let moved = point.plus(&Vector3::from_column_slice(d.as_slice()));
                as_dynamic(camera.residual(&origin, &moved, &measured).unwrap())
            });
        }
    }

    #[test]
    fn a_point_seen_where_it_is_has_no_residual_and_one_behind_has_none_at_all() {
        let world_from_body = pose(&[0.3, -0.2, 0.5, 0.1, 0.2, -0.1]);
        let body_from_cam = pose(&[0.02, 0.06, -0.01, 0.0, 0.0, 1.5]);
        let camera = Camera::new(&world_from_body, &body_from_cam);
        let origin = Vector3::new(0.1, 0.1, 0.1);
        let in_cam = nalgebra::Point3::new(0.4, -0.3, 4.0);
        let offset = (world_from_body * body_from_cam * in_cam).coords - origin;
        let point = Landmark { direction: offset.normalize(), inverse_distance: 1.0 / offset.norm() };
        let measured = in_cam.coords.normalize();
        assert!(camera.residual(&origin, &point, &measured).unwrap().norm() < 1e-14);
        assert!(camera.residual(&origin, &point, &-measured).is_none());
        assert!((point.point(&origin).unwrap() - (offset + origin)).norm() < 1e-12);
    }
}
