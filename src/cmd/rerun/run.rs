//! `dpn run --rerun`: trajectory beside truth, camera with tracks, landmarks, noise, biases, levels, ellipsoids.

use super::log::{ESTIMATED, RerunLog, TRUE, quaternion, single, transform};
use crate::cmd::foxglove::is_due;
use anyhow::Result;
use dpn_core::camera::CameraModel;
use dpn_core::{GrayImage, Sensor, Stamp, TrackFrame};
use dpn_eval::closed_loop::{JudgedRun, Recording};
use dpn_vio::estimator::{FrontEndObserver, Update};
use dpn_vio::frontend::Fed;
use dpn_vio::window::Window;
use nalgebra::{Isometry3, Matrix3, Rotation3, SymmetricEigen, UnitQuaternion, Vector3};
use re_sdk_types::archetypes::{Ellipsoids3D, Pinhole};
use std::cell::RefCell;
use std::path::Path;
use std::rc::Rc;

/// Images are kept so often \[s\]: each has some hundred kilobytes.
const IMAGE_EVERY_S: f64 = 0.25;
/// Noise is shown so often \[s\].
const NOISE_EVERY_S: f64 = 0.05;
/// Ellipsoids stand so far apart \[s\].
const ELLIPSOID_EVERY_S: f64 = 1.0;
const IMAGE: &str = "estimate/body/camera/image";
const LEVELS: [&str; 7] = ["accel x", "accel y", "accel z", "gyro x", "gyro y", "gyro z", "pixel"];
/// Apart: their factors are a hundred times as large.
const WALKS: [&str; 2] = ["accel walk", "gyro walk"];

/// What a run shows while it runs and afterwards. Those who look on share it.
#[derive(Clone)]
pub(in crate::cmd) struct RunScene(Rc<RefCell<Scene>>);

struct Scene {
    log: RerunLog,
    /// When the last image and the last ellipsoid were kept.
    image: Option<Stamp>,
    ellipsoid: Option<Stamp>,
    /// The first that could not be logged; after it nothing is.
    fault: Option<anyhow::Error>,
}

impl RunScene {
    /// Of a run over `recording`.
    pub(in crate::cmd) fn new(recording: &Recording) -> Result<Self> {
        let log = RerunLog::new(&recording.name, recording.imu.samples()[0].t)?;
        for entity in ["noise/accel", "noise/gyro", "bias/accel", "bias/gyro", "sample/accel", "sample/gyro"]
        {
            log.axes(entity)?;
        }
        log.always("estimate/body/camera", &transform(&recording.body_from_cam))?;
        log.always(IMAGE, &pinhole(&recording.camera))?;
        Ok(Self(Rc::new(RefCell::new(Scene { log, image: None, ellipsoid: None, fault: None }))))
    }

    fn take(&self, what: impl FnOnce(&mut Scene) -> Result<()>) {
        let scene = &mut *self.0.borrow_mut();
        if scene.fault.is_none() {
            scene.fault = what(scene).err();
        }
    }

    /// Tracks that were given or made: there are no images.
    pub(in crate::cmd) fn tracks(&self, frames: &[TrackFrame]) {
        self.take(|scene| frames.iter().try_for_each(|frame| scene.tracks(frame)));
    }

    pub(in crate::cmd) fn update(&self, update: &Update, window: &Window) {
        self.take(|scene| scene.update(update, window));
    }

    /// What is known at the end, and the file; `truth_from_world` is where the estimate's world lies in the truth's.
    pub(in crate::cmd) fn finish(
        self,
        path: &Path,
        recording: &Recording,
        done: &JudgedRun,
        truth_from_world: Option<&Isometry3<f64>>,
    ) -> Result<()> {
        self.take(|scene| scene.whole(recording, done, truth_from_world));
        let scene = Rc::try_unwrap(self.0).map_err(|_| ()).expect("nobody looks on any more").into_inner();
        match scene.fault {
            Some(fault) => Err(fault),
            None => scene.log.finish(path),
        }
    }
}

impl FrontEndObserver for RunScene {
    fn end(&mut self, image: &GrayImage, fed: &Fed) {
        self.take(|scene| {
            let t = fed.report.t;
            if is_due(&mut scene.image, t, IMAGE_EVERY_S) {
                scene.log.at(t);
                scene.log.image(IMAGE, image)?;
            }
            fed.frame.as_ref().map_or(Ok(()), |frame| scene.tracks(frame))
        });
    }
}

impl Scene {
    fn tracks(&self, frame: &TrackFrame) -> Result<()> {
        self.log.at(frame.t);
        self.log.pixels(&format!("{IMAGE}/tracks"), frame.tracks.iter().map(|track| track.px))
    }

    fn update(&mut self, update: &Update, window: &Window) -> Result<()> {
        let log = &self.log;
        log.at(update.t);
        if let Some(levels) = &update.levels {
            let [samples @ .., accel_walk, gyro_walk] = levels.inertial.0;
            log.numbers("level/sample", &[&samples[..], &[levels.pixel]].concat())?;
            log.numbers("level/walk", &[accel_walk, gyro_walk])?;
        }
        let Some(state) = &update.state else { return Ok(()) };
        log.pose("estimate/body", &state.world_from_body)?;
        log.numbers("bias/accel", state.bias.accel.as_slice())?;
        log.numbers("bias/gyro", state.bias.gyro.as_slice())?;
        let points: Vec<_> = window.points_in_world().into_iter().map(|(_, point)| point).collect();
        log.points("estimate/landmarks", &points)?;
        if let Some(covariance) = &update.covariance {
            log.numbers("position_std", &[0, 1, 2].map(|k| covariance[(k, k)].max(0.0).sqrt()))?;
            if is_due(&mut self.ellipsoid, update.t, ELLIPSOID_EVERY_S) {
                let place = &state.world_from_body.translation.vector;
                let position = covariance.fixed_view::<3, 3>(0, 0).into_owned();
                self.log.put("estimate/three_sigma", &ellipsoid(place, position))?;
            }
        }
        Ok(())
    }

    fn whole(
        &self,
        recording: &Recording,
        done: &JudgedRun,
        truth_from_world: Option<&Isometry3<f64>>,
    ) -> Result<()> {
        let log = &self.log;
        if let Some(pose) = truth_from_world {
            log.always("estimate", &transform(pose))?;
        }
        let poses = done.output.poses();
        let places: Vec<_> = poses.iter().map(|pose| pose.world_from_body.translation.vector).collect();
        log.path("estimate/path", &places, ESTIMATED)?;
        let span = done.output.frames.first().zip(done.output.frames.last());
        let within = |t: Stamp| span.is_some_and(|(first, last)| (*first..=*last).contains(&t));
        let truth: Vec<_> = recording.truth.iter().flatten().filter(|pose| within(pose.t)).collect();
        let places: Vec<_> = truth.iter().map(|pose| pose.world_from_body.translation.vector).collect();
        log.path("truth/path", &places, TRUE)?;
        let mut last = None;
        for pose in truth {
            if is_due(&mut last, pose.t, NOISE_EVERY_S) {
                log.at(pose.t);
                log.pose("truth/body", &pose.world_from_body)?;
            }
        }
        if done.output.updates.iter().any(|update| update.levels.is_some()) {
            log.lines("level/sample", LEVELS)?;
            log.lines("level/walk", WALKS)?;
        }
        if done.output.updates.iter().any(|update| update.covariance.is_some()) {
            log.axes("position_std")?;
        }
        let mut last = None;
        let noises = done.noise.stamps().iter().zip(done.noise.noises());
        for ((t, noise), sample) in noises.zip(recording.imu.samples()) {
            if within(*t) && is_due(&mut last, *t, NOISE_EVERY_S) {
                log.at(*t);
                for sensor in Sensor::ALL {
                    log.numbers(&format!("noise/{sensor}"), &noise.of(sensor))?;
                    log.numbers(&format!("sample/{sensor}"), &sample.of(sensor))?;
                }
            }
        }
        Ok(())
    }
}

/// The lens without its distortion, which the viewer does not know.
fn pinhole(camera: &CameraModel) -> Pinhole {
    let ([width, height], focal, principal) = (camera.size(), camera.focal(), camera.principal());
    let focal = [focal.x as f32, focal.y as f32];
    Pinhole::from_focal_length_and_resolution(focal, [width as f32, height as f32])
        .with_principal_point([principal.x as f32, principal.y as f32])
        .with_image_plane_distance(0.3_f32)
}

/// Three deviations about a place.
fn ellipsoid(place: &Vector3<f64>, covariance: Matrix3<f64>) -> Ellipsoids3D {
    let eigen = SymmetricEigen::new(covariance);
    let mut axes = eigen.eigenvectors;
    if axes.determinant() < 0.0 {
        axes.column_mut(2).neg_mut();
    }
    let half = eigen.eigenvalues.map(|variance| 3.0 * variance.max(0.0).sqrt());
    let turned = UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(axes));
    Ellipsoids3D::from_centers_and_half_sizes([single(place)], [single(&half)])
        .with_quaternions([quaternion(&Isometry3::from_parts(Vector3::zeros().into(), turned))])
        .with_colors([ESTIMATED])
}
