//! Which points of the world the camera sees, and where.

use super::camera::{BadCameraSettings, CameraSettings};
use super::world::Points;
use dpn_core::camera::{CameraModel, Lens, WIDEST_RAD};
use nalgebra::{Isometry3, Vector2, Vector3};

/// Nearest depth at which a point is seen \[m\].
const NEAREST_M: f64 = 0.3;

/// Nothing is seen closer to the image's border \[px\].
const BORDER_PX: f64 = 10.0;

/// Points worked on at a time: three axes of a block fit the fastest cache.
const BLOCK: usize = 512;

/// A point that is not seen.
const NOWHERE: u32 = u32::MAX;

/// What the camera sees of the world at one instant; kept from frame to frame for its room.
pub(super) struct Sight<'a> {
    points: &'a Points,
    model: CameraModel,
    body_from_cam: Isometry3<f64>,
    /// Largest x/z and y/z inside the image, or of use: beyond, a distortion's polynomial may fold back into it.
    reach: Vector2<f64>,
    /// Points in the camera's frame, a block at a time.
    block: [Vec<f64>; 3],
    /// Seen points and their true pixels, by point.
    seen: Vec<(u32, Vector2<f64>)>,
    /// For every point its place in `seen`.
    place: Vec<u32>,
}

impl<'a> Sight<'a> {
    pub(super) fn new(points: &'a Points, camera: &CameraSettings) -> Result<Self, BadCameraSettings> {
        let model = camera.model()?;
        Ok(Self {
            points,
            model,
            body_from_cam: camera.body_from_cam()?,
            reach: reach(&model),
            block: std::array::from_fn(|_| vec![0.0; BLOCK]),
            seen: Vec::new(),
            place: vec![NOWHERE; points.len()],
        })
    }

    /// The camera's lens.
    pub(super) fn model(&self) -> &CameraModel {
        &self.model
    }

    /// Looks from a body at `world_from_body`.
    pub(super) fn look(&mut self, world_from_body: &Isometry3<f64>) {
        for (point, _) in self.seen.drain(..) {
            self.place[point as usize] = NOWHERE;
        }
        let cam_from_world = (world_from_body * self.body_from_cam).inverse();
        let rotation = cam_from_world.rotation.to_rotation_matrix().into_inner();
        let offset = cam_from_world.translation.vector;
        let n = self.points.len();
        for first in (0..n).step_by(BLOCK) {
            let range = first..(first + BLOCK).min(n);
            let (x, y, z) =
                (&self.points.x[range.clone()], &self.points.y[range.clone()], &self.points.z[range.clone()]);
            for (row, out) in self.block.iter_mut().enumerate() {
                let (a, b, c, d) = (rotation[(row, 0)], rotation[(row, 1)], rotation[(row, 2)], offset[row]);
                for (((out, x), y), z) in out.iter_mut().zip(x).zip(y).zip(z) {
                    *out = a * x + b * y + c * z + d;
                }
            }
            let [cam_x, cam_y, cam_z] = &self.block;
            for i in 0..range.len() {
                let (x, y, z) = (cam_x[i], cam_y[i], cam_z[i]);
                if z > NEAREST_M
                    && x.abs() < self.reach.x * z
                    && y.abs() < self.reach.y * z
                    && let Some(px) = self.model.project(&Vector3::new(x, y, z))
                    && self.model.contains(&px, BORDER_PX)
                {
                    self.place[first + i] = self.seen.len() as u32;
                    self.seen.push(((first + i) as u32, px));
                }
            }
        }
    }

    /// The points seen, in the world's order, and their true pixels.
    pub(super) fn seen(&self) -> &[(u32, Vector2<f64>)] {
        &self.seen
    }

    /// Where a point is seen.
    pub(super) fn px(&self, point: u32) -> Option<Vector2<f64>> {
        let place = *self.place.get(point as usize)?;
        self.seen.get(place as usize).map(|(_, px)| *px)
    }
}

/// The largest x/z and y/z that the image's border sees, in size. Where a pinhole's lens has no inverse, the pinhole's own; of a lens with
/// pixels that see nothing of use, the widest of use.
fn reach(model: &CameraModel) -> Vector2<f64> {
    if !matches!(model.lens(), Lens::Radtan(_)) && !model.sees_all() {
        return Vector2::repeat(WIDEST_RAD.tan());
    }
    const STEPS: u32 = 64;
    let [width, height] = model.size().map(|size| f64::from(size - 1));
    let along = (0..=STEPS).map(|i| f64::from(i) / f64::from(STEPS));
    let border =
        along.flat_map(|s| [(s * width, 0.0), (s * width, height), (0.0, s * height), (width, s * height)]);
    border.fold(Vector2::zeros(), |reach, (u, v)| {
        let px = Vector2::new(u, v);
        let pinhole = || (px - model.principal()).component_div(&model.focal());
        reach.sup(&model.normalise(&px).unwrap_or_else(pinhole).abs())
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tracks::World;
    use crate::tracks::path::Bounds;
    use dpn_core::random::Stream;

    #[test]
    fn what_is_seen_is_what_projects_into_the_image() {
        let bounds = Bounds { low: Vector3::zeros(), high: Vector3::new(4.0, 3.0, 1.0) };
        let points = Points::around(&bounds, World::Room, &Stream::new(1));
        let camera = CameraSettings::default();
        let mut sight = Sight::new(&points, &camera).unwrap();
        let model = camera.model().unwrap();
        for turn in 0..6 {
            let pose =
                Isometry3::new(Vector3::new(1.0, 1.5, 0.5), Vector3::new(0.2, 0.3, 1.1) * f64::from(turn));
            sight.look(&pose);
            let cam_from_world = (pose * camera.body_from_cam().unwrap()).inverse();
            let mut count = 0;
            for i in 0..points.len() {
                let point = Vector3::new(points.x[i], points.y[i], points.z[i]);
                let in_cam = cam_from_world * nalgebra::Point3::from(point);
                // 60 degrees off the axis is outside the image and inside the fold.
                let near_axis = in_cam.z > NEAREST_M && in_cam.xy().coords.norm() < 1.73 * in_cam.z;
                let px = model
                    .project(&(cam_from_world.rotation * point + cam_from_world.translation.vector))
                    .filter(|px| near_axis && px.x > 10.0 && px.x < 741.0 && px.y > 10.0 && px.y < 469.0);
                assert_eq!(sight.px(i as u32).is_some(), px.is_some(), "point {i}: {in_cam} {px:?}");
                if let (Some(found), Some(px)) = (sight.px(i as u32), px) {
                    assert!((found - px).norm() < 1e-9);
                    count += 1;
                }
            }
            assert_eq!(count, sight.seen().len());
            assert!(count > 100, "{count}");
        }
    }
}
