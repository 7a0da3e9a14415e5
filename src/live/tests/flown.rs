//! A walk around the middle of a room that comes back to where it began after [`PERIOD_S`] seconds: what sensors say on it goes on for as long as one likes.

use dpn_core::{GRAVITY, GrayImage, ImuSample, Stamp};
use dpn_io::calibration::Calibration;
use dpn_live::OdometryConfig;
use dpn_sim::render::{RenderConfig, RenderedCamera};
use dpn_sim::tracks::{Bounds, CameraPath, CameraSettings};
use dpn_testing::forged::Draw;
use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3};
use std::f64::consts::TAU;
use std::sync::Arc;

/// Seconds of a round.
pub(crate) const PERIOD_S: f64 = 20.0;
/// The beginning.
pub(crate) const BEGIN: Stamp = Stamp::from_ns(1_700_000_000_000_000_000);
/// A quarter of EuRoC's a side.
const SIZE: [u32; 2] = [188, 120];
const INTRINSICS: [f64; 4] = [114.66, 114.32, 91.8, 62.1];

/// Sums of few sines, so that everything has its derivatives.
struct Round;

impl Round {
    fn position(s: f64) -> Vector3<f64> {
        let w = TAU / PERIOD_S;
        Vector3::new(
            1.5 * (w * s).cos() + 0.2 * (4.0 * w * s).sin(),
            1.5 * (w * s).sin() + 0.2 * (5.0 * w * s).cos(),
            1.2 + 0.3 * (3.0 * w * s).sin() + 0.1 * (7.0 * w * s).cos(),
        )
    }

    fn attitude(s: f64) -> UnitQuaternion<f64> {
        let w = TAU / PERIOD_S;
        let yaw = w * s + 0.3 * (2.0 * w * s).sin();
        UnitQuaternion::from_euler_angles(0.15 * (5.0 * w * s).sin(), 0.15 * (3.0 * w * s).cos(), yaw)
    }

    /// What an IMU without noise reads.
    fn sample(s: f64) -> [[f64; 3]; 2] {
        const STEP_S: f64 = 1e-4;
        let [before, now, after] = [-STEP_S, 0.0, STEP_S].map(|step| Self::position(s + step));
        let accel_in_world = (before - 2.0 * now + after) / (STEP_S * STEP_S);
        let body_from_world = Self::attitude(s).inverse();
        let force = body_from_world * (accel_in_world + GRAVITY * Vector3::z());
        let [before, after] = [-STEP_S, STEP_S].map(|step| Self::attitude(s + step));
        let turn = (before.inverse() * after).scaled_axis() / (2.0 * STEP_S);
        [turn.into(), force.into()]
    }
}

impl CameraPath for Round {
    fn world_from_body(&self, t: Stamp) -> Option<Isometry3<f64>> {
        let s = t.seconds_since(BEGIN);
        Some(Isometry3::from_parts(Translation3::from(Self::position(s)), Self::attitude(s)))
    }

    fn pieces(&self) -> Vec<(Stamp, Stamp)> {
        vec![(BEGIN, BEGIN.plus_seconds(PERIOD_S))]
    }

    fn bounds(&self) -> Bounds {
        Bounds { low: Vector3::new(-1.7, -1.7, 0.8), high: Vector3::new(1.7, 1.7, 1.6) }
    }
}

/// One round: what an IMU without noise reads, and images.
pub(crate) struct Flown {
    readings: Vec<[[f64; 3]; 2]>,
    images: Vec<GrayImage>,
    rates_hz: [f64; 2],
}

impl Flown {
    /// At so many samples and images a second.
    pub(crate) fn new(rates_hz: [f64; 2]) -> Self {
        let camera = CameraSettings { resolution: SIZE, intrinsics: INTRINSICS, ..CameraSettings::default() };
        let config = RenderConfig { camera: Some(camera), ..RenderConfig::ideal() };
        let mut rendered = RenderedCamera::new(&config, Arc::new(Round), 1).unwrap();
        let [samples, frames] = rates_hz.map(|hz| (PERIOD_S * hz).round() as usize);
        let at = |k: usize| BEGIN.plus_seconds(k as f64 / rates_hz[1]);
        Self {
            readings: (0..samples).map(|k| Round::sample(k as f64 / rates_hz[0])).collect(),
            images: (0..frames).map(|k| rendered.image(at(k)).unwrap()).collect(),
            rates_hz,
        }
    }

    /// The camera, as its calibration says.
    pub(crate) fn calibration() -> Calibration {
        let rows = CameraSettings::default().body_from_cam;
        let data: Vec<f64> = rows.into_iter().flatten().chain([0.0, 0.0, 0.0, 1.0]).collect();
        let coefficients = CameraSettings::default().distortion;
        let text = format!(
            "[calibration]\nresolution = {SIZE:?}\nrate_hz = 20\ncamera_model = \"pinhole\"\nintrinsics = {INTRINSICS:?}\n\
             distortion_model = \"radial-tangential\"\ndistortion_coefficients = {:?}\n\
             T_BS = {{ rows = 4, cols = 4, data = {data:?} }}\n",
            &coefficients[..4]
        );
        OdometryConfig::parse(&text).unwrap().calibration().unwrap()
    }

    /// What the sensors say from `from_s` on for so long, each with the seconds since then and whether it is an image.
    pub(crate) fn said(&self, from_s: f64, for_s: f64) -> impl Iterator<Item = (f64, bool, usize)> {
        let [samples, frames] = self.rates_hz.map(|hz| (from_s * hz).ceil() as usize);
        let [sample_s, frame_s] = self.rates_hz.map(|hz| move |k: usize| k as f64 / hz - from_s);
        let (mut sample, mut frame) = (samples, frames);
        std::iter::from_fn(move || {
            // An image is there 3 ms after it was taken.
            let is_image = frame_s(frame) + 0.003 < sample_s(sample);
            let next = if is_image { &mut frame } else { &mut sample };
            let place = std::mem::replace(next, *next + 1);
            Some((if is_image { frame_s(place) + 0.003 } else { sample_s(place) }, is_image, place))
        })
        .take_while(move |(at, ..)| *at < for_s)
    }

    /// The sample of a place, its noise that of the place.
    pub(crate) fn sample(&self, place: usize) -> ImuSample {
        let [gyro, accel] = self.readings[place % self.readings.len()];
        let mut draw = Draw::new(place as u64, "noise");
        // The sum of twelve: nearly normal, of deviation 1.
        let mut normal = || (0..12).map(|_| draw.share()).sum::<f64>() - 6.0;
        ImuSample {
            t: BEGIN.plus_seconds(place as f64 / self.rates_hz[0]),
            gyro: gyro.map(|value| value + 0.002 * normal()),
            accel: accel.map(|value| value + 0.02 * normal()),
        }
    }

    /// The image of a place.
    pub(crate) fn image(&self, place: usize) -> (Stamp, &GrayImage) {
        (BEGIN.plus_seconds(place as f64 / self.rates_hz[1]), &self.images[place % self.images.len()])
    }
}
