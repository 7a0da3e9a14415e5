//! Against OpenCV, on a crop of a real image and the same scene warped (`golden/opencv_frontend`).

use super::super::corners::{CornerConfig, Detector, Mask};
use super::super::image::{Plane, Pyramid, pyr_down};
use super::super::klt::{Klt, KltConfig, Shift, track_in_steady_light};
use dpn_core::GrayImage;
use serde::Deserialize;
use std::path::PathBuf;

fn folder() -> PathBuf {
    PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/../../golden/opencv_frontend"))
}

fn pgm(name: &str) -> GrayImage {
    let bytes = std::fs::read(folder().join(name)).unwrap();
    let mut parts = bytes.splitn(4, u8::is_ascii_whitespace);
    assert_eq!(parts.next(), Some(&b"P5"[..]));
    let mut number = || std::str::from_utf8(parts.next().unwrap()).unwrap().parse::<usize>().unwrap();
    let (width, height) = (number(), number());
    let pixels = parts.next().unwrap().splitn(2, |byte| *byte == b'\n').nth(1).unwrap().to_vec();
    GrayImage::new(width, height, pixels).unwrap()
}

#[derive(Deserialize)]
struct Corners {
    most: usize,
    quality: f64,
    distance: f64,
    px: Vec<[f32; 2]>,
    free_columns: Option<usize>,
}

#[derive(Deserialize)]
struct Flow {
    levels: usize,
    window: usize,
    to: Vec<[f32; 2]>,
    status: Vec<u8>,
}

#[derive(Deserialize)]
struct Samples {
    size: [usize; 2],
    at: Vec<[usize; 2]>,
    grey: Vec<u8>,
}

#[derive(Deserialize)]
struct Golden {
    edge: usize,
    corners: Corners,
    few: Corners,
    masked: Corners,
    truth: Vec<[f32; 2]>,
    flows: Vec<Flow>,
    pyramid: Vec<Samples>,
}

fn golden() -> Golden {
    serde_json::from_slice(&std::fs::read(folder().join("golden.json")).unwrap()).unwrap()
}

fn apart(a: [f32; 2], b: [f32; 2]) -> f32 {
    (a[0] - b[0]).hypot(a[1] - b[1])
}

#[test]
fn corners_are_opencvs() {
    let golden = golden();
    let image = pgm("first.pgm");
    let plane = Plane::new(image.view());
    for case in [&golden.corners, &golden.few, &golden.masked] {
        let config = CornerConfig {
            most: case.most,
            quality: case.quality,
            least: 0.0,
            distance_px: case.distance,
            edge_px: golden.edge,
            cells: 0,
        };
        let (width, height) = (image.width(), image.height());
        let columns = golden.edge..case.free_columns.unwrap_or(width - golden.edge);
        let rows = golden.edge..height - golden.edge;
        let free = |x, y| u8::from(columns.contains(&x) && rows.contains(&y));
        let mut mask = Mask::default();
        mask.reset(width, height, Some(GrayImage::from_fn(width, height, free).unwrap().view()));
        let ours: Vec<[f32; 2]> =
            Detector::new(config).detect(&plane, &mut mask, &[]).iter().map(|corner| corner.px).collect();
        assert_eq!(ours.len(), case.px.len());
        for (i, theirs) in case.px.iter().enumerate() {
            assert!(apart(ours[i], *theirs) < 0.1, "corner {i}: {:?}, OpenCV's {theirs:?}", ours[i]);
        }
    }
}

#[test]
fn flow_is_opencvs_and_the_true_one() {
    let golden = golden();
    let pyramids = ["first.pgm", "second.pgm"].map(|name| Pyramid::new(pgm(name).view(), 4));
    let shifts: Vec<Shift> = golden.corners.px.iter().map(|px| Shift { from: *px, guess: *px }).collect();
    let base = &pyramids[0].planes()[0];
    let (width, height) = (base.width() as f32, base.height() as f32);
    for flow in &golden.flows {
        let shifted = KltConfig { window: flow.window, affine: false, ..KltConfig::default() };
        let track = |config| Klt::new(config).track(&pyramids[0], &pyramids[1], &shifts, flow.levels);
        let turned = track(KltConfig { affine: true, ..shifted });
        let steady = track_in_steady_light(shifted, [&pyramids[0], &pyramids[1]], &shifts, flow.levels);
        // OpenCV takes light as constant; a fit that also lets it change may differ a little more.
        for (ours, allowed, lit) in [(steady, 0.0, false), (track(shifted), 0.2, true)] {
            let (mut squares, mut theirs_squares, mut compared, mut far) = (0.0, 0.0, 0, Vec::new());
            let mut turned_squares = 0.0;
            for (i, (ours, truth)) in ours.iter().zip(&golden.truth).enumerate() {
                let half = flow.window as f32 / 2.0 + 2.0;
                let inside = (half..width - half).contains(&truth[0])
                    && (half..height - half).contains(&truth[1])
                    && (half..width - half).contains(&shifts[i].from[0])
                    && (half..height - half).contains(&shifts[i].from[1]);
                if !inside || flow.status[i] == 0 || apart(flow.to[i], *truth) > 0.5 {
                    continue;
                }
                let ours = ours.unwrap();
                compared += 1;
                squares += apart(ours, *truth).powi(2);
                turned_squares += apart(turned[i].unwrap(), *truth).powi(2);
                theirs_squares += apart(flow.to[i], *truth).powi(2);
                if apart(ours, flow.to[i]) > 0.05 {
                    far.push((i, ours, flow.to[i], *truth));
                }
            }
            let per_axis = |squares: f32| (squares / (2.0 * compared as f32)).sqrt();
            let (ours, theirs) = (per_axis(squares), per_axis(theirs_squares));
            let turned = per_axis(turned_squares);
            eprintln!(
                "window {}, {} levels: {compared} points, RMS {ours:.4} px, OpenCV's {theirs:.4}, affine {turned:.4}",
                flow.window, flow.levels
            );
            assert!(compared > 25, "{compared}");
            assert!(far.len() as f32 <= allowed * compared as f32, "window {}: {far:?}", flow.window);
            // The scene turns by half a degree, which a wide window's shift cannot follow, ours no more than theirs.
            assert!(
                (ours < 0.05 || flow.window > 21) && ours < 1.1 * theirs,
                "{ours} px RMS a side, OpenCV's {theirs}"
            );
            // A window that may turn can; it too lets the light change.
            assert!(
                turned < 0.05 && (!lit || turned < 1.02 * ours),
                "{turned} px RMS a side, {ours} by shifts"
            );
        }
    }
}

fn check(plane: &Plane, samples: &Samples) {
    assert_eq!([plane.width(), plane.height()], samples.size);
    for (at, grey) in samples.at.iter().zip(&samples.grey) {
        assert_eq!(plane.row(at[1])[at[0]], *grey, "at {at:?}");
    }
}

#[test]
fn pyramid_levels_are_opencvs_to_the_bit() {
    let half = pyr_down(&Plane::new(pgm("first.pgm").view()));
    let quarter = pyr_down(&half);
    let samples = golden().pyramid;
    check(&half, &samples[0]);
    check(&quarter, &samples[1]);
}
