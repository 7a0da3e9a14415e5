//! Lenses against OpenCV and against their definitions (`golden/lenses/make.py`), their inverses, derivatives and domains.

use super::{BadCamera, CameraModel, Distortion, Lens};
use dpn_testing::check_jacobian;
use nalgebra::{DVector, Vector2, Vector3};
use proptest::prelude::*;
use serde::Deserialize;

#[derive(Deserialize)]
struct Case {
    name: String,
    model: String,
    resolution: [u32; 2],
    intrinsics: [f64; 4],
    coefficients: Vec<f64>,
    points: Vec<[f64; 3]>,
    pixels: Vec<Option<[f64; 2]>>,
}

#[derive(Deserialize)]
struct Golden {
    cases: Vec<Case>,
}

fn golden() -> Vec<(Case, CameraModel)> {
    let text = include_str!("../../../golden/lenses/golden.json");
    let golden: Golden = serde_json::from_str(text).unwrap();
    let made = golden.cases.into_iter().map(|case| {
        let lens = Lens::new(case.model.parse().unwrap(), &case.coefficients).unwrap();
        let camera = CameraModel::new(case.resolution, case.intrinsics, lens).unwrap();
        (case, camera)
    });
    made.collect()
}

#[test]
fn pixels_are_those_of_opencv_and_of_the_definitions() {
    let cases = golden();
    assert!(cases.len() >= 12);
    for (case, camera) in cases {
        let mut seen = 0;
        for (point, px) in case.points.iter().zip(&case.pixels) {
            let found = camera.project(&Vector3::from(*point));
            match px {
                Some(px) => {
                    let error = (found.unwrap() - Vector2::from(*px)).norm();
                    assert!(error < 1e-8, "{}: {point:?} {found:?} {px:?}", case.name);
                    seen += 1;
                }
                None => assert_eq!(found, None, "{}: {point:?}", case.name),
            }
        }
        assert!(seen > 30, "{}: {seen}", case.name);
    }
}

proptest! {
    #[test]
    fn the_way_back_leads_home_and_the_derivative_is_the_derivative(
        which in 0..12_usize, x in -1.0..1.0f64, y in -1.0..1.0f64, z in -0.4..1.0f64, far in 0.3..20.0f64,
    ) {
        let cases = golden();
        let (case, camera) = &cases[which % cases.len()];
        let point = Vector3::new(x, y, z) * far;
        // Pixels of the image and some beside it: far out a radial-tangential polynomial is nobody's calibration.
        if let Some(px) = camera.project(&point).filter(|px| camera.contains(px, -100.0)) {
            let bearing = camera.bearing(&px).unwrap();
            // Far off the axis a pinhole's pixel is less and less of an angle.
            let near = point.normalize().z.abs().max(0.05);
            prop_assert!((bearing.norm() - 1.0).abs() < 1e-12);
            prop_assert!(bearing.dot(&point.normalize()) > 1.0 - 1e-9 / near, "{} {point} {bearing}", case.name);
            let (same, jacobian) = camera.project_with_jacobian(&point).unwrap();
            prop_assert!((same - px).norm() < 1e-8 * (1.0 + px.norm()));
            let step = |d: &[f64]| camera.project(&(point + far * Vector3::from_column_slice(d))).unwrap();
            if point.norm() > 0.05 * far {
                check_jacobian(&case.name, &(jacobian * far), 1e-5, |d| DVector::from_column_slice(step(d.as_slice()).as_slice()));
            }
        }
    }

    #[test]
    fn what_a_pixel_sees_is_seen_at_the_pixel(which in 0..12_usize, u in -0.2..1.2f64, v in -0.2..1.2f64) {
        let cases = golden();
        let (case, camera) = &cases[which % cases.len()];
        let px = Vector2::new(u * f64::from(case.resolution[0]), v * f64::from(case.resolution[1]));
        if let Some(bearing) = camera.bearing(&px) {
            let back = camera.project(&(bearing * 2.5));
            prop_assert!(back.is_some_and(|back| (back - px).norm() < 1e-6), "{} {px} {back:?}", case.name);
        }
    }
}

#[test]
fn what_a_lens_cannot_see_is_not_seen() {
    let tumvi = CameraModel::tumvi_cam0();
    // TUM-VI's polynomial rises to beyond the hemisphere; behind the camera it sees nothing straight on.
    assert!(tumvi.project(&Vector3::new(1.0, 0.0, -0.05)).is_some());
    assert!(tumvi.project(&Vector3::new(0.0, 0.0, -1.0)).is_none());
    assert!(tumvi.bearing(&Vector2::new(5000.0, 256.0)).is_none());
    // Its corners see something, but nothing of use.
    assert!(tumvi.sight(&Vector2::new(0.0, 0.0)).is_none() && tumvi.normalise(&Vector2::zeros()).is_none());
    assert!(!tumvi.sees_all() && CameraModel::euroc_cam0().sees_all());
    // A barrel whose polynomial folds back at r^2 = 1/3 sees nothing outside.
    let folding =
        CameraModel::radtan([752, 480], [450.0, 450.0, 376.0, 240.0], [-1.0, 0.0, 0.0, 0.0, 0.0]).unwrap();
    assert!(folding.project(&Vector3::new(0.57, 0.0, 1.0)).is_some());
    assert!(folding.project(&Vector3::new(0.58, 0.0, 1.0)).is_none());
}

#[test]
fn the_centre_of_every_lens_has_its_pixels_a_radian() {
    for (case, camera) in golden() {
        let step = 1e-5;
        let at = |x: f64, y: f64| camera.project(&Vector3::new(x, y, 1.0)).unwrap();
        let (u, v) = ((at(step, 0.0) - at(-step, 0.0)).norm(), (at(0.0, step) - at(0.0, -step)).norm());
        let measured = (u + v) / (4.0 * step);
        assert!((measured / camera.px_per_rad() - 1.0).abs() < 2e-3, "{}: {measured}", case.name);
    }
}

#[test]
fn coefficients_that_a_lens_cannot_have_are_refused() {
    let refused = |model, coefficients: &[f64]| Lens::new(model, coefficients).unwrap_err();
    assert!(matches!(refused(Distortion::Equidistant, &[0.1]), BadCamera::Coefficients { .. }));
    assert_eq!(
        refused(Distortion::RadialTangential, &[0.1; 6]).to_string(),
        "a lens that is radial-tangential with coefficients [0.1, 0.1, 0.1, 0.1, 0.1, 0.1]; it has 4 or 5 or 8 finite numbers"
    );
    for (model, bad) in [
        (Distortion::Omni, vec![-0.5, 0.0, 0.0, 0.0, 0.0]),
        (Distortion::DoubleSphere, vec![-1.5, 0.5]),
        (Distortion::DoubleSphere, vec![0.0, 1.5]),
        (Distortion::EnhancedUnified, vec![1.5, 1.0]),
        (Distortion::EnhancedUnified, vec![0.5, 0.0]),
        (Distortion::Fov, vec![3.5]),
        (Distortion::Fov, vec![f64::NAN]),
    ] {
        assert!(refused(model, &bad).to_string().contains("a lens that is"));
    }
}
