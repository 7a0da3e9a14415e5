//! The camera: images of a world along a path, and the truth about them.

use super::config::{GapConfig, RenderConfig};
use super::exposure::{Exposure, Setting};
use super::lens_blur::LensBlur;
use super::raster::{Frame, Lens, NoLineOfSight, Uncalibrated};
use super::scene::{Course, Scene};
use super::sensor::{Exposed, Sensor};
use crate::tracks::{BadCameraSettings, CameraPath, CameraSettings, World};
use dpn_core::camera::CameraModel;
use dpn_core::config::{ConfigFaults, Validate};
use dpn_core::random::Stream;
use dpn_core::{GrayImage, Stamp};
use nalgebra::{Isometry3, Point3, Vector2};
use rand::Rng;
use std::sync::Arc;
use thiserror::Error;

/// The exposure is settled on an image as many times smaller a side.
const COARSE: usize = 16;

/// A point is seen where the line of sight ends as near to it as this \[m\].
const SEEN_M: f64 = 1e-3;

/// Motion that an image without blur may hold \[px\].
const SHARP_PX: f64 = 0.7;

/// Rounds in which the line that sees a point is found.
const LINE_ROUNDS: usize = 12;

/// Depth that motion is judged at \[m\].
const MIDDLE_DEPTH_M: f64 = 3.0;

/// Why nothing is rendered.
#[derive(Debug, PartialEq, Error)]
pub enum RenderError {
    /// Settings out of their bounds.
    #[error(transparent)]
    Config(#[from] ConfigFaults),
    /// A camera that is none.
    #[error(transparent)]
    Camera(#[from] BadCameraSettings),
    /// A lens that does not say what each pixel sees.
    #[error(transparent)]
    Lens(#[from] NoLineOfSight),
}

/// A path that may be shared between threads.
pub type SharedPath = Arc<dyn CameraPath + Send>;

/// A camera in a world of its own, carried along a path.
///
/// An image is a function of configuration, path, seed and its stamp: in whatever order, on however many threads, the same bits. A copy
/// shares the world and has its own room to work in.
#[derive(Clone)]
pub struct RenderedCamera {
    config: RenderConfig,
    settings: CameraSettings,
    model: CameraModel,
    body_from_cam: Isometry3<f64>,
    path: SharedPath,
    world: World,
    scene: Arc<Scene>,
    lens: Arc<Lens>,
    coarse: Arc<Lens>,
    sensor: Arc<Sensor>,
    exposure: Exposure,
    gaps: Stream,
    blur: LensBlur,
    frame: Frame,
    small: Frame,
    sum: Vec<f32>,
}

impl RenderedCamera {
    /// A camera along `path`; the world is built around it. `seed` is that of world, noise and light.
    ///
    /// # Errors
    /// Settings out of their bounds; a lens with pixels that see nothing.
    pub fn new(config: &RenderConfig, path: SharedPath, seed: u64) -> Result<Self, RenderError> {
        config.validate()?;
        let settings = config.camera_or_default();
        let model = settings.model()?;
        let stream = Stream::new(seed).named("render");
        let bounds = path.bounds();
        let body_from_cam = settings.body_from_cam()?;
        let unknown = Uncalibrated::new(config.lens.uncalibrated_px, model.size()[0], &stream);
        let coarse = COARSE.min(model.size()[0].min(model.size()[1]) as usize);
        Ok(Self {
            world: config.world.settled(&bounds),
            body_from_cam,
            scene: Arc::new(Scene::new(
                &Course::of(path.as_ref(), &body_from_cam),
                config.world,
                [config.contrast, config.bare],
                &stream,
            )),
            lens: Arc::new(Lens::new(&model, &unknown, 1)?),
            coarse: Arc::new(Lens::new(&model, &unknown, coarse)?),
            sensor: Arc::new(Sensor::new(config.sensor, &config.lens, &model, &stream)),
            exposure: Exposure::new(config.exposure, config.low_light, &stream),
            gaps: stream.named("gaps"),
            blur: LensBlur::new(config.lens.blur_px),
            frame: Frame::default(),
            small: Frame::default(),
            sum: Vec::new(),
            config: config.clone(),
            settings,
            model,
            path,
        })
    }

    /// The lens.
    pub fn model(&self) -> &CameraModel {
        &self.model
    }

    /// The camera as numbers.
    pub fn settings(&self) -> &CameraSettings {
        &self.settings
    }

    /// Room or hall.
    pub fn world(&self) -> World {
        self.world
    }

    /// Points in the camera's frame at `t` to the world's; `None` where the path is not known.
    pub fn world_from_cam(&self, t: Stamp) -> Option<Isometry3<f64>> {
        let pose = self.path.world_from_body(t.plus_seconds(self.config.ground_truth_delay_s))?;
        Some(pose * self.body_from_cam)
    }

    /// Whether there is an image of time `t`: the path is known while its lines are read out, and it is not lost.
    pub fn takes(&self, t: Stamp) -> bool {
        let half = 0.5 * self.config.readout_s;
        let known = |aside: f64| self.world_from_cam(t.plus_seconds(aside)).is_some();
        known(-half) && known(0.0) && known(half) && !self.loses(t)
    }

    /// Whether `t` lies in a gap: one in every stretch of `gaps.every_s`, its place and length drawn from the stretch's number.
    fn loses(&self, t: Stamp) -> bool {
        let GapConfig { every_s, longest_s } = self.config.gaps;
        if longest_s == 0.0 {
            return false;
        }
        let stretch_ns = (every_s * 1e9) as i64;
        let (stretch, within) = (t.ns().div_euclid(stretch_ns), t.ns().rem_euclid(stretch_ns) as f64 * 1e-9);
        let mut rng = self.gaps.index(stretch as u64).rng();
        let length = longest_s * rng.random::<f64>();
        let from = (every_s - length) * rng.random::<f64>();
        (from..from + length).contains(&within)
    }

    /// How long after an image's stamp line `y` of it is exposed \[s\].
    fn line_delay(&self, y: f64) -> f64 {
        let last = f64::from(self.model.size()[1]) - 1.0;
        self.config.readout_s * (y / last.max(1.0) - 0.5)
    }

    /// The camera `aside` seconds from `t`, or at `t` where the path is not known there.
    fn near(&self, t: Stamp, aside: f64, middle: &Isometry3<f64>) -> Isometry3<f64> {
        self.world_from_cam(t.plus_seconds(aside)).unwrap_or(*middle)
    }

    /// The light of the image taken `aside` seconds from `t`, line after line.
    fn expose(&mut self, t: Stamp, aside: f64, middle: &Isometry3<f64>) {
        let mut frame = std::mem::take(&mut self.frame);
        if self.config.readout_s == 0.0 {
            frame.render(&self.scene, &self.lens, &self.near(t, aside, middle));
        } else {
            let pose = |y: usize| self.near(t, aside + self.line_delay(y as f64), middle);
            frame.render_lines(&self.scene, &self.lens, pose);
        }
        self.frame = frame;
    }

    /// The image taken at `t`; `None` where there is none ([`takes`](Self::takes)).
    pub fn image(&mut self, t: Stamp) -> Option<GrayImage> {
        let world_from_cam = self.world_from_cam(t).filter(|_| self.takes(t))?;
        let setting = self.setting(t);
        let [width, height] = self.lens.size;
        let instants = self.instants(t, setting.time);
        self.sum.clear();
        self.sum.resize(width * height, 0.0);
        let share = 1.0 / instants.len() as f32;
        for aside in instants {
            self.expose(t, aside, &world_from_cam);
            self.sum.iter_mut().zip(&self.frame.grey).for_each(|(sum, grey)| *sum += share * grey);
        }
        self.blur.apply(&mut self.sum, width);
        let exposed = Exposed {
            factor: (setting.light * setting.time * setting.gain) as f32,
            gain: setting.gain as f32,
        };
        let mut pixels = Vec::new();
        self.sensor.take(&self.sum, exposed, t, &mut pixels);
        Some(GrayImage::new(width, height, pixels).expect("the sensor has a grey value for every pixel"))
    }

    fn setting(&mut self, t: Stamp) -> Setting {
        let Self { exposure, small, scene, coarse, path, config, body_from_cam, .. } = self;
        exposure.at(t, |t, seen| {
            let Some(pose) = path.world_from_body(t.plus_seconds(config.ground_truth_delay_s)) else {
                return false;
            };
            small.render(scene, coarse, &(pose * *body_from_cam));
            seen.extend_from_slice(&small.grey);
            true
        })
    }

    /// Times from `t` while the shutter is open, evenly about it: as many as the motion asks for \[s\].
    fn instants(&self, t: Stamp, time: f64) -> Vec<f64> {
        let open = self.config.motion_blur.exposure_s * time;
        if open <= 0.0 {
            return vec![0.0];
        }
        let at = |share: f64| self.world_from_cam(t.plus_seconds(share * open));
        let (Some(first), Some(last)) = (at(-0.5), at(0.5)) else { return vec![0.0] };
        let turn = first.rotation.angle_to(&last.rotation);
        let step = (first.translation.vector - last.translation.vector).norm() / MIDDLE_DEPTH_M;
        let motion = self.model.px_per_rad() * (turn + step);
        let count = ((motion / SHARP_PX).ceil() as usize).clamp(1, self.config.motion_blur.most_instants);
        (0..count).map(|i| open * ((i as f64 + 0.5) / count as f64 - 0.5)).collect()
    }

    /// The point of the world that pixel `px` sees at `t`, exactly; `None` where the path is not known.
    pub fn point_at(&self, t: Stamp, px: &Vector2<f64>) -> Option<Point3<f64>> {
        self.sight(t, px).map(|(_, point)| point)
    }

    /// The number of the surface that pixel `px` sees at `t`: the same where there is no edge between.
    pub fn surface_at(&self, t: Stamp, px: &Vector2<f64>) -> Option<usize> {
        self.sight(t, px).map(|(surface, _)| surface)
    }

    fn sight(&self, t: Stamp, px: &Vector2<f64>) -> Option<(usize, Point3<f64>)> {
        let world_from_cam = self.world_from_cam(t.plus_seconds(self.line_delay(px.y)))?;
        let ray = world_from_cam.rotation * self.model.normalise(px)?.push(1.0);
        let eye = world_from_cam.translation.vector;
        let (surface, way) = self.scene.hit(&eye, &ray)?;
        Some((surface, Point3::from(eye + way * ray)))
    }

    /// The pixel at which a point of the world is seen at `t`; `None` where it is not: outside the image, behind something, or at a time
    /// without a pose.
    pub fn pixel_of(&self, t: Stamp, point: &Point3<f64>) -> Option<Vector2<f64>> {
        // Which line sees the point depends on when the line is read out: the pixel moves far less in a line's time than by a line.
        let mut line = 0.5 * f64::from(self.model.size()[1]);
        let (mut in_cam, mut px) = (Point3::origin(), Vector2::zeros());
        for _ in 0..if self.config.readout_s == 0.0 { 1 } else { LINE_ROUNDS } {
            let at = t.plus_seconds(self.line_delay(line));
            in_cam = self.world_from_cam(at)?.inverse_transform_point(point);
            if in_cam.z <= 0.0 {
                return None;
            }
            px = self.model.project(&in_cam.coords).filter(|px| self.model.contains(px, 0.0))?;
            line = px.y;
        }
        let seen = self.point_at(t, &px)?;
        ((seen - point).norm() < SEEN_M * in_cam.z.max(1.0)).then_some(px)
    }
}

impl std::fmt::Debug for RenderedCamera {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("RenderedCamera")
            .field("config", &self.config)
            .field("world", &self.world)
            .field("surfaces", &self.scene.rects.len())
            .finish_non_exhaustive()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::render::{LensConfig, LowLightConfig, MotionBlurConfig};
    use crate::tracks::{AnalyticPath, Bounds};
    use crate::{Flight, FlightConfig, simulate};
    use nalgebra::{Translation3, UnitQuaternion, Vector3};

    /// EuRoC's camera at a quarter of its size.
    fn quarter() -> CameraSettings {
        CameraSettings {
            resolution: [188, 120],
            intrinsics: [114.7, 114.3, 91.8, 62.1],
            ..CameraSettings::default()
        }
    }

    fn flown(flight: Flight) -> SharedPath {
        Arc::new(AnalyticPath::of(&simulate(flight, 3, &FlightConfig::ideal()).unwrap()))
    }

    fn camera(config: &RenderConfig, seed: u64) -> RenderedCamera {
        let config = RenderConfig { camera: Some(quarter()), ..config.clone() };
        RenderedCamera::new(&config, flown(Flight::RoomWild), seed).unwrap()
    }

    fn at(camera: &RenderedCamera, seconds: f64) -> Stamp {
        camera.path.pieces()[0].0.plus_seconds(seconds)
    }

    #[test]
    fn an_image_does_not_depend_on_those_before_it_nor_on_threads_but_on_the_seed() {
        let config = RenderConfig {
            motion_blur: MotionBlurConfig { exposure_s: 0.01, ..MotionBlurConfig::default() },
            low_light: LowLightConfig { share: 0.5, length_s: 2.0, light: 0.1 },
            ..RenderConfig::default()
        };
        let camera = camera(&config, 1);
        let stamps: Vec<Stamp> = (0..12).map(|i| at(&camera, 8.0 + 0.7 * f64::from(i))).collect();
        let mut one = camera.clone();
        let forwards: Vec<_> = stamps.iter().map(|t| one.image(*t).unwrap()).collect();
        let mut backwards = std::thread::scope(|scope| {
            let threads: Vec<_> = stamps
                .iter()
                .rev()
                .map(|t| {
                    let mut own = camera.clone();
                    scope.spawn(move || own.image(*t).unwrap())
                })
                .collect();
            threads.into_iter().map(|thread| thread.join().unwrap()).collect::<Vec<_>>()
        });
        backwards.reverse();
        assert!(forwards == backwards);
        assert!(super::tests::camera(&config, 2).image(stamps[3]).unwrap() != forwards[3]);
    }

    #[test]
    fn grey_values_stay_on_the_points_that_have_them() {
        // A point seen from two places has the same grey value: noiseless, evenly lit, small steps, away from edges.
        let config = RenderConfig {
            lens: LensConfig { blur_px: 0.6, ..RenderConfig::ideal().lens },
            ..RenderConfig::ideal()
        };
        let mut camera = camera(&config, 5);
        let (t0, t1) = (at(&camera, 12.0), at(&camera, 12.08));
        let (a, b) = (camera.image(t0).unwrap(), camera.image(t1).unwrap());
        let (mut moved, mut still, mut n) = (0.0, 0.0, 0.0);
        for y in (8..112).step_by(3) {
            for x in (8..180).step_by(3) {
                let px = Vector2::new(f64::from(x), f64::from(y));
                let around = [[-2.0, 0.0], [2.0, 0.0], [0.0, 2.0], [0.0, -2.0]];
                let own = camera.surface_at(t0, &px).unwrap();
                if around.iter().any(|d| camera.surface_at(t0, &(px + Vector2::from(*d))) != Some(own)) {
                    continue;
                }
                let point = camera.point_at(t0, &px).unwrap();
                assert!((camera.pixel_of(t0, &point).unwrap() - px).norm() < 1e-8);
                let Some(to) = camera.pixel_of(t1, &point) else { continue };
                let grey = |image: &GrayImage, u: f64, v: f64| {
                    let (x, y) = (u.floor(), v.floor());
                    let at = |dx: usize, dy: usize| {
                        f64::from(
                            image.pixels()[(y as usize + dy).min(119) * 188 + (x as usize + dx).min(187)],
                        )
                    };
                    let (fx, fy) = (u - x, v - y);
                    (1.0 - fy) * ((1.0 - fx) * at(0, 0) + fx * at(1, 0))
                        + fy * ((1.0 - fx) * at(0, 1) + fx * at(1, 1))
                };
                let own = grey(&a, px.x, px.y);
                moved += (own - grey(&b, to.x, to.y)).powi(2);
                still += (own - grey(&b, px.x, px.y)).powi(2);
                n += 1.0;
            }
        }
        let (moved, still) = ((moved / n).sqrt(), (still / n).sqrt());
        assert!(n > 500.0 && moved < 3.0 && still > 2.5 * moved, "{n} {moved} {still}");
    }

    /// A body that stands still.
    struct Standing(Isometry3<f64>);

    impl CameraPath for Standing {
        fn world_from_body(&self, t: Stamp) -> Option<Isometry3<f64>> {
            (t.ns() >= 0).then_some(self.0)
        }

        fn pieces(&self) -> Vec<(Stamp, Stamp)> {
            vec![(Stamp::from_ns(0), Stamp::from_ns(i64::MAX))]
        }

        fn bounds(&self) -> Bounds {
            let place = self.0.translation.vector;
            Bounds { low: place - Vector3::repeat(1.0), high: place + Vector3::repeat(1.0) }
        }
    }

    #[test]
    fn at_rest_only_the_noise_changes_and_the_mean_is_the_target() {
        let turn = UnitQuaternion::from_euler_angles(0.0, -1.5, 0.3);
        let path: SharedPath =
            Arc::new(Standing(Isometry3::from_parts(Translation3::new(1.0, 2.0, 3.0), turn)));
        let config = RenderConfig { camera: Some(quarter()), ..RenderConfig::ideal() };
        let mut plain = RenderedCamera::new(&config, path.clone(), 1).unwrap();
        let of = |camera: &mut RenderedCamera, ms: i64| camera.image(Stamp::from_ns(ms * 1_000_000)).unwrap();
        let still = of(&mut plain, 500);
        assert!(still == of(&mut plain, 950));
        assert!(plain.image(Stamp::from_ns(-1)).is_none());
        let mean = |image: &GrayImage| {
            image.pixels().iter().map(|g| f64::from(*g)).sum::<f64>() / image.pixels().len() as f64
        };
        assert!((mean(&still) - 128.0).abs() < 12.0, "{}", mean(&still));
        let noisy = RenderConfig { sensor: RenderConfig::default().sensor, ..config };
        let mut noisy = RenderedCamera::new(&noisy, path, 1).unwrap();
        let (a, b) = (of(&mut noisy, 500), of(&mut noisy, 950));
        let squares = a.pixels().iter().zip(b.pixels()).map(|(a, b)| (f64::from(*a) - f64::from(*b)).powi(2));
        // Twice the variance of a grey near 128, with rounding.
        let variance = squares.sum::<f64>() / a.pixels().len() as f64 / 2.0;
        assert!((1.4..2.6).contains(&variance), "{variance}");
    }

    #[test]
    fn what_a_hall_has_changes_no_room() {
        let lens = LensConfig { uncalibrated_px: 0.0, ..LensConfig::default() };
        let mut camera = camera(&RenderConfig { lens, ..RenderConfig::default() }, 1);
        assert_eq!(camera.world(), World::Room);
        let image = camera.image(at(&camera, 12.0)).unwrap();
        let sum =
            image.pixels().iter().fold(0_u64, |sum, g| sum.wrapping_mul(31).wrapping_add(u64::from(*g)));
        assert_eq!(
            sum, 4_981_138_027_590_795_006,
            "the room's images are another's: closed-loop figures on rooms were made with the old ones"
        );
    }

    #[test]
    fn settings_out_of_bounds_and_lenses_that_fold_back_are_refused() {
        let path = flown(Flight::Hover);
        let refused = |config: &RenderConfig| RenderedCamera::new(config, path.clone(), 1).unwrap_err();
        let bad = RenderConfig { contrast: -1.0, ..RenderConfig::default() };
        assert!(matches!(refused(&bad), RenderError::Config(_)));
        let folding = CameraSettings { distortion: [-2.0, 0.0, 0.0, 0.0, 0.0].into(), ..quarter() };
        let folding = RenderConfig { camera: Some(folding), ..RenderConfig::default() };
        assert!(matches!(refused(&folding), RenderError::Lens(_)));
    }
}
