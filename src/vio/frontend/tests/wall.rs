//! A camera in front of a wall with a random pattern: every track's true place is known.

use dpn_core::camera::CameraModel;
use dpn_core::random::Stream;
use dpn_core::{GrayImage, Stamp};
use nalgebra::{Isometry3, UnitQuaternion, Vector2, Vector3};
use rand::Rng;
use rand_distr::StandardNormal;

/// Distance of the wall from the camera's first place \[m\].
const DISTANCE: f64 = 3.0;

/// The wall's coordinates of every pixel's line of sight are found with these.
pub(crate) struct Wall {
    pub(crate) camera: CameraModel,
    bearings: Vec<Vector3<f64>>,
    seed: u64,
    /// Light: grey = gain * pattern + offset.
    pub(crate) gain: f64,
    pub(crate) offset: f64,
    /// Whether pixels have a sensor's noise, as strong as EuRoC's.
    pub(crate) noise: bool,
}

/// EuRoC's camera at half its size.
pub(crate) fn half_camera() -> CameraModel {
    let distortion = [-0.283_408_11, 0.073_959_07, 0.000_193_59, 1.761_871_14e-5, 0.0];
    CameraModel::radtan([376, 240], [229.3, 228.6, 183.6, 124.2], distortion).unwrap()
}

impl Wall {
    pub(crate) fn new(seed: u64) -> Self {
        let camera = half_camera();
        let [width, height] = camera.size();
        let pixels =
            (0..height).flat_map(|y| (0..width).map(move |x| Vector2::new(f64::from(x), f64::from(y))));
        let bearings = pixels.map(|px| camera.bearing(&px).unwrap()).collect();
        Self { camera, bearings, seed, gain: 1.0, offset: 0.0, noise: true }
    }

    /// What the camera sees from a pose (`world_from_cam`; the wall is at z = 3 m); `frame` names the noise.
    pub(crate) fn image(&self, world_from_cam: &Isometry3<f64>, frame: u64) -> GrayImage {
        let mut rng = Stream::new(self.seed).named("noise").index(frame).rng();
        let [width, height] = self.camera.size().map(|side| side as usize);
        let pixels = self.bearings.iter().map(|bearing| {
            let [x, y] = on_wall(world_from_cam, bearing);
            let grey = self.gain * self.pattern(x, y) + self.offset;
            let normal: f64 = if self.noise { rng.sample(StandardNormal) } else { 0.0 };
            (grey + normal * (0.3 + 0.0145 * grey.max(0.0)).sqrt()).round().clamp(0.0, 255.0) as u8
        });
        GrayImage::new(width, height, pixels.collect()).unwrap()
    }

    /// Where a place seen at `px` from one pose is seen from another.
    pub(crate) fn moved(
        &self,
        px: &Vector2<f64>,
        from: &Isometry3<f64>,
        to: &Isometry3<f64>,
    ) -> Vector2<f64> {
        let [x, y] = on_wall(from, &self.camera.bearing(px).unwrap());
        let point = to.inverse_transform_point(&nalgebra::Point3::new(x, y, DISTANCE));
        self.camera.project(&point.coords).unwrap()
    }

    /// Smooth random greys of three sizes \[m\]; a pixel is about 13 mm.
    fn pattern(&self, x: f64, y: f64) -> f64 {
        let octave = |size: f64, salt: u64| lattice(x / size, y / size, self.seed * 8 + salt);
        20.0 + 90.0 * octave(0.25, 1) + 80.0 * octave(0.1, 2) + 50.0 * octave(0.05, 3)
    }
}

fn on_wall(world_from_cam: &Isometry3<f64>, bearing: &Vector3<f64>) -> [f64; 2] {
    let origin = world_from_cam.translation.vector;
    let ray = world_from_cam.rotation * bearing;
    let way = (DISTANCE - origin.z) / ray.z;
    [origin.x + way * ray.x, origin.y + way * ray.y]
}

/// Random values at whole numbers, 0 to 1, joined smoothly.
fn lattice(x: f64, y: f64, seed: u64) -> f64 {
    let (left, top) = (x.floor(), y.floor());
    let smooth = |f: f64| f * f * f * (f * (6.0 * f - 15.0) + 10.0);
    let (fx, fy) = (smooth(x - left), smooth(y - top));
    let corner = |dx: i64, dy: i64| {
        let (x, y) = (left as i64 + dx, top as i64 + dy);
        let mixed = (x as u64).wrapping_mul(0x9e37_79b9_7f4a_7c15)
            ^ (y as u64).wrapping_mul(0xc2b2_ae3d_27d4_eb4f)
            ^ seed.wrapping_mul(0x1656_67b1_9e37_79f9);
        let mixed = (mixed ^ (mixed >> 29)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        ((mixed ^ (mixed >> 32)) & 0xffff) as f64 / 65535.0
    };
    let row = |dy: i64| corner(0, dy) + fx * (corner(1, dy) - corner(0, dy));
    row(0) + fy * (row(1) - row(0))
}

/// A pose on a gentle hand-held path at frame `i` of 20 a second.
pub(crate) fn pose(i: usize) -> Isometry3<f64> {
    let t = 0.05 * i as f64;
    let place = Vector3::new(0.4 * (1.1 * t).sin(), 0.25 * (1.7 * t).sin(), 0.3 * (0.9 * t).sin());
    let turn = Vector3::new(0.15 * (1.3 * t).sin(), 0.2 * (0.8 * t).sin(), 0.3 * (0.7 * t).sin());
    Isometry3::from_parts(place.into(), UnitQuaternion::from_scaled_axis(turn))
}

pub(crate) fn stamp(i: usize) -> Stamp {
    Stamp::from_ns(1_400_000_000_000_000_000 + 50_000_000 * i as i64)
}

/// The camera's turn between two poses.
pub(crate) fn turn(last: &Isometry3<f64>, cur: &Isometry3<f64>) -> UnitQuaternion<f64> {
    cur.rotation.inverse() * last.rotation
}
