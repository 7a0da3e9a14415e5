//! The faults.

use dpn_core::camera::{CameraModel, Lens};
use dpn_core::{GrayImage, ImuSample};
use dpn_eval::closed_loop::Recording;
use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3};

/// What begins amid a recording begins here \[s\].
pub(super) const HALF_S: f64 = 8.0;

/// An image with the fault, or none: its place, its time \[s\], itself, the last sound one.
type OfImage = fn(usize, f64, &GrayImage, Option<&GrayImage>) -> Option<GrayImage>;

/// What is done to a recording.
#[derive(Clone, Copy)]
pub(super) enum Damage {
    /// Nothing.
    None,
    /// To a sample at a time since the first image \[s\].
    Samples(fn(ImuSample, f64) -> Option<ImuSample>),
    /// To what is known of the camera.
    Calibration(fn(&mut Recording)),
    /// To the camera's stamps, in seconds since the first.
    CameraClock(fn(f64) -> f64),
    /// To images.
    Image(OfImage),
}

/// A fault by its name.
pub(super) struct Fault {
    pub name: &'static str,
    pub damage: Damage,
}

const fn samples(name: &'static str, of: fn(ImuSample, f64) -> Option<ImuSample>) -> Fault {
    Fault { name, damage: Damage::Samples(of) }
}

const fn calibration(name: &'static str, of: fn(&mut Recording)) -> Fault {
    Fault { name, damage: Damage::Calibration(of) }
}

const fn clock(name: &'static str, of: fn(f64) -> f64) -> Fault {
    Fault { name, damage: Damage::CameraClock(of) }
}

const fn image(name: &'static str, of: OfImage) -> Fault {
    Fault { name, damage: Damage::Image(of) }
}

/// No fault.
pub(super) const SOUND: Fault = Fault { name: "none", damage: Damage::None };

/// All of them.
pub(super) const FAULTS: [Fault; 50] = [
    samples("accelerometer x1.1", |s, _| accel(s, |a| a.map(|v| 1.1 * v))),
    samples("accelerometer x0.9", |s, _| accel(s, |a| a.map(|v| 0.9 * v))),
    samples("accelerometer in g", |s, _| accel(s, |a| a.map(|v| v / 9.80665))),
    samples("accelerometer negated", |s, _| accel(s, |a| a.map(|v| -v))),
    samples("accelerometer x negated", |s, _| accel(s, |[x, y, z]| [-x, y, z])),
    samples("accelerometer y negated", |s, _| accel(s, |[x, y, z]| [x, -y, z])),
    samples("accelerometer x and y swapped", |s, _| accel(s, |[x, y, z]| [y, x, z])),
    samples("accelerometer y stuck", |s, _| accel(s, |[x, _, z]| [x, 0.1, z])),
    samples("accelerometer without gravity", |s, _| {
        accel(s, |a| {
            let a = Vector3::from(a);
            (a - 9.81 * a.normalize()).into()
        })
    }),
    samples("accelerometer bias of 1 m/s^2", |s, _| accel(s, |[x, y, z]| [x + 1.0, y, z])),
    samples("accelerometer clipped at 12 m/s^2", |s, _| accel(s, |a| a.map(|v| v.clamp(-10.5, 10.5)))),
    samples("gyroscope x1.1", |s, _| gyro(s, |g| g.map(|v| 1.1 * v))),
    samples("gyroscope x0.9", |s, _| gyro(s, |g| g.map(|v| 0.9 * v))),
    samples("gyroscope in deg/s", |s, _| gyro(s, |g| g.map(f64::to_degrees))),
    samples("gyroscope z negated", |s, _| gyro(s, |[x, y, z]| [x, y, -z])),
    samples("gyroscope x and y swapped", |s, _| gyro(s, |[x, y, z]| [y, x, z])),
    samples("gyroscope x stuck", |s, _| gyro(s, |[_, y, z]| [0.0, y, z])),
    samples("gyroscope bias of 0.2 rad/s", |s, _| gyro(s, |[x, y, z]| [x + 0.2, y, z])),
    samples("gyroscope clipped at 0.5 rad/s", |s, _| gyro(s, |g| g.map(|v| v.clamp(-0.5, 0.5)))),
    samples("IMU axes turned by 90 degrees", |s, _| {
        accel(s, |[x, y, z]| [y, -x, z]).and_then(|s| gyro(s, |[x, y, z]| [y, -x, z]))
    }),
    samples("half of the samples lost", |s, t| ((t * 1e3).to_bits().count_ones() % 2 == 0).then_some(s)),
    samples("0.5 s of samples lost", |s, t| (!(HALF_S..HALF_S + 0.5).contains(&t)).then_some(s)),
    samples("samples end", |s, t| (t < HALF_S).then_some(s)),
    samples("stamps of samples jitter by 1 ms", |s, t| {
        Some(ImuSample { t: s.t.plus_seconds(0.001 * scattered(t)), ..s })
    }),
    samples("IMU clock jumps by 50 ms", |s, t| {
        Some(ImuSample { t: if t < HALF_S { s.t } else { s.t.plus_seconds(0.05) }, ..s })
    }),
    clock("camera late by 20 ms", |t| t + 0.02),
    clock("camera late by 50 ms", |t| t + 0.05),
    clock("camera late by 100 ms", |t| t + 0.1),
    clock("camera early by 50 ms", |t| t - 0.05),
    clock("camera late by 1 s", |t| t + 1.0),
    clock("camera clock 1 % fast", |t| 1.01 * t),
    clock("camera clock 0.1 % fast", |t| 1.001 * t),
    clock("camera in another epoch", |t| t + 1e6),
    clock("stamps of images jitter by 5 ms", |t| t + 0.005 * 3f64.sqrt() * (2.0 * scattered(t) - 1.0)),
    calibration("focal length x1.2", |r| lens(r, 1.2, 0.0, false)),
    calibration("focal length x0.8", |r| lens(r, 0.8, 0.0, false)),
    calibration("focal length x1.05", |r| lens(r, 1.05, 0.0, false)),
    calibration("principal point 50 px off", |r| lens(r, 1.0, 50.0, false)),
    calibration("distortion left away", |r| lens(r, 1.0, 0.0, true)),
    calibration("camera turned by 5 degrees", |r| turned(r, 5.0)),
    calibration("camera turned by 10 degrees", |r| turned(r, 10.0)),
    calibration("camera turned by 90 degrees", |r| turned(r, 90.0)),
    calibration("extrinsics inverted", |r| r.body_from_cam = r.body_from_cam.inverse()),
    calibration("camera 0.2 m off", |r| {
        r.body_from_cam = Isometry3::from_parts(
            Translation3::from(r.body_from_cam.translation.vector + Vector3::new(0.2, 0.0, 0.0)),
            r.body_from_cam.rotation,
        );
    }),
    image("images mirrored", |_, _, image, _| {
        let width = image.width();
        Some(grey(image, |x, y, of| of.row(y)[width - 1 - x]))
    }),
    image("images freeze", |_, t, image, last| Some(if t < HALF_S { image } else { last? }.clone())),
    image("images dark for 3 s", |_, t, image, _| {
        let dark = (HALF_S..HALF_S + 3.0).contains(&t);
        Some(grey(image, |x, y, of| if dark { 2 } else { of.row(y)[x] }))
    }),
    image("images lost for 0.7 s", |_, t, image, _| {
        (!(HALF_S..HALF_S + 0.7).contains(&t)).then(|| image.clone())
    }),
    image("exposure flickers", |k, _, image, _| {
        let gain = if k % 2 == 0 { 1.0 } else { 0.7 };
        Some(grey(image, |x, y, of| (gain * f64::from(of.row(y)[x])) as u8))
    }),
    image("seven of ten images dropped", |k, _, image, _| (k * 7 % 10 < 3).then(|| image.clone())),
];

/// From 0 to 1, another at each time.
fn scattered(t: f64) -> f64 {
    ((t * 12_345.6).sin() * 1e4).rem_euclid(1.0)
}

#[allow(clippy::unnecessary_wraps)]
fn accel(sample: ImuSample, of: impl Fn([f64; 3]) -> [f64; 3]) -> Option<ImuSample> {
    Some(ImuSample { accel: of(sample.accel), ..sample })
}

#[allow(clippy::unnecessary_wraps)]
fn gyro(sample: ImuSample, of: impl Fn([f64; 3]) -> [f64; 3]) -> Option<ImuSample> {
    Some(ImuSample { gyro: of(sample.gyro), ..sample })
}

fn lens(recording: &mut Recording, focal: f64, aside_px: f64, straight: bool) {
    let camera = recording.camera;
    let (f, c) = (focal * camera.focal(), camera.principal());
    let lens = if straight { Lens::radtan([0.0; 5]) } else { camera.lens() };
    recording.camera = CameraModel::new(camera.size(), [f.x, f.y, c.x + aside_px, c.y], lens).unwrap();
}

/// About the camera's own x axis.
fn turned(recording: &mut Recording, degrees: f64) {
    recording.body_from_cam.rotation *=
        UnitQuaternion::from_axis_angle(&Vector3::x_axis(), degrees.to_radians());
}

fn grey(image: &GrayImage, of: impl Fn(usize, usize, &dpn_core::GrayView<'_>) -> u8) -> GrayImage {
    let view = image.view();
    GrayImage::from_fn(image.width(), image.height(), |x, y| of(x, y, &view)).unwrap()
}
