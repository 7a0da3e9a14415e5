//! The camera: images of a world along a path, and the truth about them.

use super::config::RenderConfig;
use super::exposure::{Exposure, Setting};
use super::lens_blur::LensBlur;
use super::raster::{Frame, Lens, NoLineOfSight};
use super::scene::Scene;
use super::sensor::{Exposed, Sensor};
use crate::tracks::{BadCameraSettings, CameraPath, CameraSettings, World};
use dpn_core::camera::PinholeRadtan;
use dpn_core::config::{ConfigFault, Validate};
use dpn_core::random::Stream;
use dpn_core::{GrayImage, Stamp};
use nalgebra::{Isometry3, Point3, Vector2};
use std::sync::Arc;
use thiserror::Error;

/// The exposure is settled on an image as many times smaller a side.
const COARSE: usize = 16;

/// A point is seen where the line of sight ends as near to it as this \[m\].
const SEEN_M: f64 = 1e-3;

/// Motion that an image without blur may hold \[px\].
const SHARP_PX: f64 = 0.7;

/// Depth that motion is judged at \[m\].
const MIDDLE_DEPTH_M: f64 = 3.0;

/// Why nothing is rendered.
#[derive(Debug, PartialEq, Error)]
pub enum RenderError {
    /// Settings out of their bounds.
    #[error("{}", .0.iter().map(ToString::to_string).collect::<Vec<_>>().join("; "))]
    Config(Vec<ConfigFault>),
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
    model: PinholeRadtan,
    body_from_cam: Isometry3<f64>,
    path: SharedPath,
    world: World,
    scene: Arc<Scene>,
    lens: Arc<Lens>,
    coarse: Arc<Lens>,
    sensor: Arc<Sensor>,
    exposure: Exposure,
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
        let faults = config.faults();
        if !faults.is_empty() {
            return Err(RenderError::Config(faults));
        }
        let settings = config.camera_or_default();
        let model = settings.model()?;
        let stream = Stream::new(seed).named("render");
        let bounds = path.bounds();
        let coarse = COARSE.min(model.size().map(|side| side as usize).into_iter().min().unwrap_or(1));
        Ok(Self {
            world: config.world.settled(&bounds),
            body_from_cam: settings.body_from_cam()?,
            scene: Arc::new(Scene::new(&bounds, config.world, config.contrast, &stream)),
            lens: Arc::new(Lens::new(&model, 1)?),
            coarse: Arc::new(Lens::new(&model, coarse)?),
            sensor: Arc::new(Sensor::new(config.sensor, &config.lens, &model, &stream)),
            exposure: Exposure::new(config.exposure, config.low_light, &stream),
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
    pub fn model(&self) -> &PinholeRadtan {
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

    /// The image taken at `t`; `None` where the path is not known.
    pub fn image(&mut self, t: Stamp) -> Option<GrayImage> {
        let world_from_cam = self.world_from_cam(t)?;
        let setting = self.setting(t);
        let instants = self.instants(t, setting.time, &world_from_cam);
        match instants.as_slice() {
            [] | [_] => {
                self.frame.render(&self.scene, &self.lens, &world_from_cam);
                self.sum.clear();
                self.sum.extend_from_slice(&self.frame.grey);
            }
            several => {
                self.sum.clear();
                self.sum.resize(self.lens.size[0] * self.lens.size[1], 0.0);
                let share = 1.0 / several.len() as f32;
                for pose in several {
                    self.frame.render(&self.scene, &self.lens, pose);
                    self.sum.iter_mut().zip(&self.frame.grey).for_each(|(sum, grey)| *sum += share * grey);
                }
            }
        }
        let [width, height] = self.lens.size;
        self.blur.apply(&mut self.sum, width);
        let exposed = Exposed {
            factor: (setting.light * setting.time * setting.gain) as f32,
            gain: setting.gain as f32,
        };
        let mut pixels = Vec::new();
        self.sensor.take(&self.sum, exposed, t, &mut pixels);
        GrayImage::new(width, height, pixels).ok()
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

    /// Poses while the shutter is open, evenly about `t`: as many as the motion asks for.
    fn instants(&self, t: Stamp, time: f64, middle: &Isometry3<f64>) -> Vec<Isometry3<f64>> {
        let open = self.config.motion_blur.exposure_s * time;
        if open <= 0.0 {
            return Vec::new();
        }
        let at = |share: f64| self.world_from_cam(t.plus_seconds(share * open));
        let (Some(first), Some(last)) = (at(-0.5), at(0.5)) else { return vec![*middle] };
        let turn = first.rotation.angle_to(&last.rotation);
        let step = (first.translation.vector - last.translation.vector).norm() / MIDDLE_DEPTH_M;
        let motion = self.model.focal().mean() * (turn + step);
        let count = ((motion / SHARP_PX).ceil() as usize).clamp(1, self.config.motion_blur.most_instants);
        (0..count).filter_map(|i| at((i as f64 + 0.5) / count as f64 - 0.5)).collect()
    }

    /// The point of the world that pixel `px` sees at `t`, exactly; `None` where the path is not known.
    pub fn point_at(&self, t: Stamp, px: &Vector2<f64>) -> Option<Point3<f64>> {
        let world_from_cam = self.world_from_cam(t)?;
        let ray = world_from_cam.rotation * self.model.normalise(px)?.push(1.0);
        let eye = world_from_cam.translation.vector;
        let hits = self.scene.rects.iter().filter_map(|rect| rect.hit(&eye, &ray));
        let way = hits.min_by(f64::total_cmp)?;
        Some(Point3::from(eye + way * ray))
    }

    /// The pixel at which a point of the world is seen at `t`; `None` where it is not: outside the image, behind something, or at a time
    /// without a pose.
    pub fn pixel_of(&self, t: Stamp, point: &Point3<f64>) -> Option<Vector2<f64>> {
        let in_cam = self.world_from_cam(t)?.inverse_transform_point(point);
        // Far beside the image the distortion's polynomial folds back into it.
        if in_cam.z <= 0.0 || in_cam.xy().coords.norm() > 2.0 * in_cam.z {
            return None;
        }
        let px = self.model.project(&in_cam.coords).filter(|px| self.model.contains(px, 0.0))?;
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
