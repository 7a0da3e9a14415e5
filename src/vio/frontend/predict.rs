//! Where a turned camera sees a point again.

use dpn_core::camera::CameraModel;
use nalgebra::{UnitQuaternion, Vector2, Vector3};

/// A point whose prediction is farther outside the image than this \[px\] is looked for where it was.
const FAR_OUTSIDE: f64 = 40.0;

/// How the camera turned, `cam_cur_from_cam_last`, when the body turned by `body_last_from_body_cur` (what a gyroscope integrates to).
pub(crate) fn turn_of_camera(
    body_last_from_body_cur: &UnitQuaternion<f64>,
    body_from_cam: &UnitQuaternion<f64>,
) -> UnitQuaternion<f64> {
    body_from_cam.inverse() * body_last_from_body_cur.inverse() * body_from_cam
}

/// The pixel of `bearing` after the camera turned; none where it is out of sight.
pub(super) fn turned(
    camera: &CameraModel,
    bearing: &Vector3<f64>,
    cur_from_prev: &UnitQuaternion<f64>,
) -> Option<Vector2<f64>> {
    let seen = cur_from_prev * bearing;
    let px = camera.project(&seen).filter(|px| camera.contains(px, -FAR_OUTSIDE))?;
    // Far outside the image a lens' polynomial folds back; there the way back leads elsewhere.
    let back = camera.bearing(&px)?;
    (back.dot(&seen) > 1.0 - 1e-6).then_some(px)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_turn_to_the_right_moves_points_to_the_left() {
        let camera = CameraModel::euroc_cam0();
        let px = Vector2::new(400.0, 250.0);
        let bearing = camera.bearing(&px).unwrap();
        // The camera turns about its y axis (down) to the right: what it sees turns the other way.
        let cur_from_prev = UnitQuaternion::from_scaled_axis(Vector3::new(0.0, -0.02, 0.0));
        let moved = turned(&camera, &bearing, &cur_from_prev).unwrap();
        assert!((moved.x - (400.0 - 0.02 * 458.654)).abs() < 0.2 && (moved.y - 250.0).abs() < 0.1, "{moved}");
        let back = UnitQuaternion::from_scaled_axis(Vector3::new(0.0, 3.0, 0.0));
        assert_eq!(turned(&camera, &bearing, &back), None);
    }

    #[test]
    fn what_stands_still_in_the_world_is_where_the_turn_of_the_camera_says() {
        let body_from_cam = UnitQuaternion::from_scaled_axis(Vector3::new(0.3, -1.2, 0.7));
        let world_from_last = UnitQuaternion::from_scaled_axis(Vector3::new(0.1, 0.2, -0.4));
        let last_from_cur = UnitQuaternion::from_scaled_axis(Vector3::new(-0.05, 0.02, 0.08));
        let far = Vector3::new(0.2, -0.5, 0.8);
        let in_cam = |world_from_body: UnitQuaternion<f64>| (world_from_body * body_from_cam).inverse() * far;
        let turn = turn_of_camera(&last_from_cur, &body_from_cam);
        assert!((turn * in_cam(world_from_last) - in_cam(world_from_last * last_from_cur)).norm() < 1e-14);
    }

    #[test]
    fn where_the_lens_folds_back_nothing_is_predicted() {
        let camera = CameraModel::euroc_cam0();
        for i in 0..200 {
            let angle = 0.015 * f64::from(i);
            let bearing = Vector3::new(angle.sin(), 0.0, angle.cos());
            if let Some(px) = turned(&camera, &bearing, &UnitQuaternion::identity()) {
                assert!(angle < 0.9, "{angle} rad from the axis is not at {px}");
            }
        }
    }
}
