//! The rendered camera through the front-end: flow that is known, scatter at rest beside a real camera's, corners beside a real picture's.

use dpn_core::camera::CameraModel;
use dpn_core::random::Stream;
use dpn_core::signal::stats::median;
use dpn_core::{GrayImage, Stamp};
use dpn_io::ImageFolder;
use dpn_io::asl::Sequence;
use dpn_sim::flight::FlightPlan;
use dpn_sim::render::SharedPath;
use dpn_sim::tracks::{AnalyticPath, Bounds, CameraPath};
use dpn_sim::{Flight, RenderConfig, RenderedCamera};
use dpn_testing::pack;
use dpn_vio::frontend::corners::{CornerConfig, Detector, Mask};
use dpn_vio::frontend::image::Plane;
use dpn_vio::frontend::{FrontEnd, FrontEndConfig};
use nalgebra::{Isometry3, Matrix3, Matrix3x2, Vector2, Vector3};
use std::collections::BTreeMap;
use std::sync::Arc;

/// A body that stands still somewhere, in a world as large as if it flew through `bounds`.
struct Standing {
    pose: Isometry3<f64>,
    bounds: Bounds,
}

impl CameraPath for Standing {
    fn world_from_body(&self, _: Stamp) -> Option<Isometry3<f64>> {
        Some(self.pose)
    }

    fn pieces(&self) -> Vec<(Stamp, Stamp)> {
        vec![(Stamp::from_ns(0), Stamp::from_ns(i64::MAX))]
    }

    fn bounds(&self) -> Bounds {
        self.bounds
    }
}

fn flown(flight: Flight) -> AnalyticPath {
    AnalyticPath::new(FlightPlan::new(flight, 1).trajectory, Stamp::from_ns(0))
}

fn at(seconds: f64) -> Stamp {
    Stamp::from_ns((seconds * 1e9) as i64)
}

fn corners(image: &GrayImage, config: CornerConfig) -> Vec<[f32; 2]> {
    let mut mask = Mask::free(image.width(), image.height());
    let found = Detector::new(config).detect(&Plane::new(image.view()), &mut mask, &[]);
    found.into_iter().map(|corner| corner.px).collect()
}

/// Errors of the front-end's tracks from one image to the next, both axes: of points whose windows see one surface, and of the others.
fn flow_errors(camera: &mut RenderedCamera, t0: Stamp, t1: Stamp) -> [Vec<f64>; 2] {
    let config = FrontEndConfig { rate_hz: 1000.0, ..FrontEndConfig::default() };
    let mut front_end = FrontEnd::new(*camera.model(), config, &Stream::new(1)).unwrap();
    let (last, cur) = (camera.world_from_cam(t0).unwrap(), camera.world_from_cam(t1).unwrap());
    let turn = cur.rotation.inverse() * last.rotation;
    let mut tracks = |t: Stamp| {
        let image = camera.image(t).unwrap();
        front_end.feed(image.view(), t, Some(&turn)).frame.unwrap().tracks
    };
    let (before, after) = (tracks(t0), tracks(t1));
    let half = (config.klt.window / 2 + 1) as f64;
    let window = [-1.0, 0.0, 1.0].map(|y| [-1.0, 0.0, 1.0].map(|x| half * Vector2::new(x, y)));
    let mut errors = [Vec::new(), Vec::new()];
    for track in before {
        let Some(found) = after.iter().find(|now| now.id == track.id) else { continue };
        let own = camera.surface_at(t0, &track.px);
        let edge = window.iter().flatten().any(|off| camera.surface_at(t0, &(track.px + off)) != own);
        let Some(truth) = camera.pixel_of(t1, &camera.point_at(t0, &track.px).unwrap()) else { continue };
        errors[usize::from(edge)].extend((found.px - truth).iter().copied());
    }
    errors
}

fn rms(values: &[f64]) -> f64 {
    (values.iter().map(|v| v * v).sum::<f64>() / values.len() as f64).sqrt()
}

#[test]
fn flow_on_rendered_pairs_is_right_within_a_twentieth_of_a_pixel() {
    let mut judged = Vec::new();
    for (flight, seed) in [(Flight::RoomSlow, 1), (Flight::HallCalm, 2), (Flight::RoomMedium, 3)] {
        let path: SharedPath = Arc::new(flown(flight));
        for (name, config) in [("noiseless", noiseless()), ("noisy", calibrated())] {
            let mut camera = RenderedCamera::new(&config, path.clone(), seed).unwrap();
            // Over 10 ms windows hardly change their shape; over 50 ms, a camera's period, perspective moves the middle of a window
            // otherwise than its corners. Of a window that sees two surfaces no one flow is right.
            for dt in [0.01, 0.05] {
                let mut errors = [Vec::new(), Vec::new()];
                for i in 0..6 {
                    let t = 12.0 + 4.0 * f64::from(i);
                    let of_pair = flow_errors(&mut camera, at(t), at(t + dt));
                    errors.iter_mut().zip(of_pair).for_each(|(all, some)| all.extend(some));
                }
                let [inside, edges] = &errors;
                eprintln!(
                    "{} {name} over {dt} s: {} flows on one surface {:.4} px RMS an axis; {} at edges {:.4}",
                    flight.name(),
                    inside.len() / 2,
                    rms(inside),
                    edges.len() / 2,
                    rms(edges)
                );
                if name == "noisy" {
                    judged.extend_from_slice(inside);
                }
            }
        }
    }
    let error = rms(&judged);
    eprintln!("noisy: {} flows on one surface, {error:.4} px RMS an axis", judged.len() / 2);
    assert!(judged.len() > 4000 && error < 0.05, "{} flows: {error} px", judged.len() / 2);
}

/// How far tracks that were followed for `least` seconds or more are from what they began on, median \[px\].
fn slide(camera: &mut RenderedCamera, from: f64, seconds: f64, least: f64, template: bool) -> f64 {
    let mut config = FrontEndConfig::default();
    config.klt.template = template;
    let mut front_end = FrontEnd::new(*camera.model(), config, &Stream::new(1)).unwrap();
    let mut began = BTreeMap::new();
    let mut slid = Vec::new();
    let mut last: Option<Isometry3<f64>> = None;
    for i in 0..(20.0 * seconds) as usize {
        let t = at(from + 0.05 * i as f64);
        let image = camera.image(t).unwrap();
        let pose = camera.world_from_cam(t).unwrap();
        let turn = last.replace(pose).map(|last| pose.rotation.inverse() * last.rotation);
        let Some(frame) = front_end.feed(image.view(), t, turn.as_ref()).frame else { continue };
        for track in frame.tracks {
            let (since, point) =
                began.entry(track.id).or_insert_with(|| (t, camera.point_at(t, &track.px).unwrap()));
            let Some(truth) = camera.pixel_of(t, point) else { continue };
            if t.seconds_since(*since) >= least {
                slid.push((track.px - truth).norm());
            }
        }
    }
    assert!(slid.len() > 200, "{} sightings of long tracks", slid.len());
    median(&slid)
}

#[test]
fn tracks_held_to_their_templates_slide_less() {
    let path: SharedPath = Arc::new(flown(Flight::HallCalm));
    let mut camera = RenderedCamera::new(&calibrated(), path, 1).unwrap();
    let [held, free] = [true, false].map(|template| slide(&mut camera, 32.0, 3.0, 1.5, template));
    eprintln!("after 1.5 s and more: held {held:.3} px, free {free:.3} px");
    assert!(held < 0.15 && held < 0.5 * free, "held {held} px, free {free} px");
}

fn noiseless() -> RenderConfig {
    RenderConfig { sensor: RenderConfig::ideal().sensor, ..calibrated() }
}

/// The flow that is true is that of the calibration.
fn calibrated() -> RenderConfig {
    let mut config = RenderConfig::default();
    config.lens.uncalibrated_px = 0.0;
    config
}

/// How far tracks step from one image to the next beside what they do in common (an affine motion of the image), each axis \[px\]: by
/// the median, so that few that slip do not count.
///
/// The real vehicle does not stand quite still: it rocks by up to a pixel, all of it in common.
fn scatter(camera: CameraModel, images: impl Iterator<Item = (Stamp, GrayImage)>) -> f64 {
    let config = FrontEndConfig { rate_hz: 20.0, ..FrontEndConfig::default() };
    let mut front_end = FrontEnd::new(camera, config, &Stream::new(1)).unwrap();
    let mut last: BTreeMap<u64, Vector2<f64>> = BTreeMap::new();
    let mut squares = Vec::new();
    for (t, image) in images {
        let frame = front_end.feed(image.view(), t, None).frame.unwrap();
        let now: BTreeMap<u64, Vector2<f64>> =
            frame.tracks.iter().map(|track| (track.id, track.px)).collect();
        let steps: Vec<_> = now.iter().filter_map(|(id, px)| Some((*px, px - last.get(id)?))).collect();
        squares.extend(beside_common(&steps));
        last = now;
    }
    squares.sort_by(f64::total_cmp);
    // The median of a chi-square of two degrees is 2 ln 2.
    (squares[squares.len() / 2] / (2.0 * std::f64::consts::LN_2)).sqrt()
}

/// Squares of what steps have beside an affine motion, fitted twice: the second time without those that are far off.
fn beside_common(steps: &[(Vector2<f64>, Vector2<f64>)]) -> Vec<f64> {
    let row = |px: &Vector2<f64>| Vector3::new(1.0, px.x / 376.0 - 1.0, px.y / 240.0 - 1.0);
    let mut squares = vec![0.0; steps.len()];
    for _ in 0..2 {
        let mut sorted = squares.clone();
        sorted.sort_by(f64::total_cmp);
        let far = sorted.get(sorted.len() * 3 / 4).map_or(f64::MAX, |v| (4.0 * v).max(1e-12));
        let (mut normal, mut side) = (Matrix3::zeros(), Matrix3x2::zeros());
        for ((px, step), _) in steps.iter().zip(&squares).filter(|(_, square)| **square <= far) {
            normal += row(px) * row(px).transpose();
            side += row(px) * step.transpose();
        }
        let Some(fit) = normal.cholesky().map(|cholesky| cholesky.solve(&side)) else { return Vec::new() };
        squares = steps.iter().map(|(px, step)| (step - fit.transpose() * row(px)).norm_squared()).collect();
    }
    squares
}

/// How many corners there are at the front-end's own settings, but for their largest number, and the share of the image's 8 x 5 cells
/// that hold one.
fn spread(image: &GrayImage) -> (usize, f64) {
    let found = corners(image, CornerConfig { most: 2000, ..CornerConfig::default() });
    let mut cells = [false; 40];
    found.iter().for_each(|px| cells[(px[1] / 96.0) as usize * 8 + (px[0] / 94.0) as usize] = true);
    (found.len(), cells.iter().filter(|cell| **cell).count() as f64 / 40.0)
}

fn real() -> Option<Sequence> {
    Some(Sequence::open(&pack("images")?.join("V1_01_easy_static")).unwrap())
}

#[test]
fn at_rest_tracks_scatter_as_on_real_images_and_corners_are_as_many() {
    let Some(sequence) = real() else { return };
    let model = CameraModel::try_from(&sequence.camera_config().unwrap().unwrap()).unwrap();
    let images: Vec<_> = ImageFolder::open(&sequence)
        .unwrap()
        .prefetch(2)
        .map(|i| i.unwrap())
        .map(|i| (i.t, i.image))
        .collect();
    let (real_corners, real_spread) = spread(&images[0].1);
    let real_scatter = scatter(model, images.into_iter());
    eprintln!("real: scatter {real_scatter:.4} px, {real_corners} corners in {real_spread:.2} of the cells");

    // A flight's poses in a room: the body stands at each for two seconds.
    let flight = flown(Flight::RoomSlow);
    let mut scatters = Vec::new();
    let mut counts = Vec::new();
    for place in 0..6 {
        let pose = flight.world_from_body(at(12.0 + 5.0 * f64::from(place))).unwrap();
        let bounds = flight.bounds();
        let path: SharedPath = Arc::new(Standing { pose, bounds });
        let seed = place as u64 % 3;
        let mut camera = RenderedCamera::new(&RenderConfig::default(), path, seed).unwrap();
        let frames =
            (0..40).map(|i| (at(0.05 * f64::from(i)), camera.image(at(0.05 * f64::from(i))).unwrap()));
        let frames: Vec<_> = frames.collect();
        let (count, share) = spread(&frames[0].1);
        let scattered = scatter(model, frames.into_iter());
        eprintln!("rendered {place}: scatter {scattered:.4} px, {count} corners in {share:.2} of the cells");
        scatters.push(scattered);
        counts.push((count, share));
    }
    let mean = scatters.iter().sum::<f64>() / scatters.len() as f64;
    eprintln!("rendered: scatter {mean:.4} px in the mean, {:.2} times the real one", mean / real_scatter);
    assert!((mean / real_scatter - 1.0).abs() < 0.25, "{scatters:?} beside {real_scatter}");
    let count = counts.iter().map(|(count, _)| *count as f64).sum::<f64>() / counts.len() as f64;
    let share = counts.iter().map(|(_, share)| share).sum::<f64>() / counts.len() as f64;
    eprintln!("rendered: {count:.0} corners in {share:.2} of the cells in the mean");
    // One real picture, of a sparse wall, says no more than the order.
    assert!((0.5..4.0).contains(&(count / real_corners as f64)), "{counts:?} beside {real_corners}");
    assert!((0.8..1.3).contains(&(share / real_spread)), "{counts:?} beside {real_spread}");
}
