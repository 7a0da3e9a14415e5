use super::*;
use dpn_core::camera::{CameraConfig, CameraModel, Distortion};
use dpn_core::time::SampleRate;
use nalgebra::{Isometry3, Quaternion, Translation3, UnitQuaternion};
use std::path::PathBuf;

/// Every file of the one rig (`golden/calibrations/make.py`), who writes it, whether it has a time offset.
const FILES: [(&str, CalibrationFormat, bool); 10] = [
    ("kalibr/camchain-imucam.yaml", CalibrationFormat::Kalibr, true),
    ("openvins/kalibr_imucam_chain.yaml", CalibrationFormat::OpenVins, true),
    ("openvins/estimator_config.yaml", CalibrationFormat::OpenVins, true),
    ("vins.yaml", CalibrationFormat::Vins, true),
    ("vins_fusion/config.yaml", CalibrationFormat::Vins, true),
    ("orbslam3.yaml", CalibrationFormat::OrbSlam3, false),
    ("orbslam3_old.yaml", CalibrationFormat::OrbSlam3, false),
    ("basalt.json", CalibrationFormat::Basalt, true),
    ("okvis2.yaml", CalibrationFormat::Okvis, true),
    ("asl.yaml", CalibrationFormat::Asl, false),
];

fn golden(file: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../golden/calibrations").join(file)
}

fn rig() -> CameraConfig {
    let tumvi = CameraModel::tumvi_cam0();
    let (focal, principal) = (tumvi.focal(), tumvi.principal());
    let turn = UnitQuaternion::from_quaternion(Quaternion::new(0.55, -0.45, 0.5, 0.5));
    CameraConfig {
        rate: SampleRate::from_hz(20.0).unwrap(),
        resolution: tumvi.size(),
        intrinsics: [focal.x, focal.y, principal.x, principal.y],
        distortion: Distortion::Equidistant,
        coefficients: tumvi.lens().coefficients(),
        body_from_cam: Isometry3::from_parts(Translation3::new(0.0458, -0.0716, -0.0446), turn),
    }
}

#[test]
fn one_rig_in_ten_files_is_one_rig() {
    let rig = rig();
    for (file, format, offset) in FILES {
        let read = read(&golden(file)).unwrap_or_else(|error| panic!("{file}: {error}"));
        assert_eq!(read.format, format, "{file}");
        let off = (read.camera.body_from_cam.to_matrix() - rig.body_from_cam.to_matrix()).amax();
        assert!(off < 1e-12, "{file}: {off}");
        assert_eq!(CameraConfig { body_from_cam: rig.body_from_cam, ..read.camera.clone() }, rig, "{file}");
        let expected = if offset { 0.00125 } else { 0.0 };
        assert!((read.offset_s - expected).abs() < 1e-12, "{file}: {}", read.offset_s);
        // ASL has its noise in another folder.
        assert_eq!(read.imu.is_some(), format != CalibrationFormat::Asl, "{file}");
    }
}

#[test]
fn what_was_read_is_said_in_one_line() {
    let said = read(&golden("vins.yaml")).unwrap().to_string();
    let path = golden("vins.yaml");
    assert_eq!(
        said,
        format!(
            "VINS: 512 x 512 px, equidistant lens (4 coefficients), focal lengths 191.0 and 191.0 px; `extrinsicRotation` maps camera to IMU; \
             camera's stamps +0.0013 s; IMU noise as vins in {}",
            path.display()
        )
    );
    let said = read(&golden("kalibr/camchain-imucam.yaml")).unwrap().to_string();
    assert!(
        said.contains("`T_cam_imu` maps IMU to camera (inverted here)") && said.contains("kalibr/imu.yaml"),
        "{said}"
    );
}

/// Reads golden `file` with `from` replaced by `to`; the error and its hint.
fn spoilt(file: &str, from: &str, to: &str) -> (String, String) {
    let dir = tempfile::tempdir().unwrap();
    let text = std::fs::read_to_string(golden(file)).unwrap();
    assert!(text.contains(from), "{file}: {from}");
    let path = dir.path().join("rig.yaml");
    std::fs::write(&path, text.replacen(from, to, 1)).unwrap();
    let error = read(&path).unwrap_err();
    let said = error.to_string().replace(&format!("{}/", dir.path().display()), "");
    (said, error.hint().unwrap_or_default())
}

#[test]
fn what_is_wrong_is_named_with_its_place() {
    let kalibr = "kalibr/camchain-imucam.yaml";
    let said = |from, to| spoilt(kalibr, from, to).0;
    assert_eq!(
        said("equidistant", "kb9"),
        "rig.yaml:10: `cam0.distortion_model` is \"kb9\": there is no lens `kb9`; known are none, radial-tangential, equidistant, omni, \
         enhanced-unified, double-sphere, fov"
    );
    assert!(said("pinhole", "ucm").starts_with("rig.yaml:8: `cam0.camera_model` is \"ucm\"; known are"));
    assert!(
        said("[0.0034823894022493434, ", "[").starts_with(
            "rig.yaml:11: `cam0.distortion_coeffs` a lens that is equidistant with coefficients ["
        )
    );
    assert!(said("[512, 512]", "[512, 0]").contains("`cam0.resolution` makes an image of 512 x 0 px"));
    let focal = said("190.97847715128717", "-1.0");
    assert!(
        focal.contains("`cam0` camera intrinsics fx -1") && focal.contains("focal lengths must be positive"),
        "{focal}"
    );
    assert!(
        said("190.97847715128717", "wide")
            .contains("`cam0.intrinsics` is a list of 4; finite numbers are needed")
    );
    assert!(
        said("shift_cam_imu: 0.00125", "shift_cam_imu: 1250000")
            .contains("moves the camera's stamps by 1250000 s")
    );
    assert!(spoilt("okvis2.yaml", "T_SC: [", "T_SC: [7").0.contains("`cameras[0].T_SC` holds no rotation"));
    assert!(
        spoilt("basalt.json", "\"qw\": 0.5", "\"qw\": 1.5")
            .0
            .contains("`value0.T_imu_cam` holds no rotation: its quaternion has length")
    );
    assert!(spoilt("orbslam3.yaml", "KannalaBrandt8", "Panorama").0.contains("there is no lens `Panorama`"));
    assert!(spoilt("vins.yaml", "KANNALA_BRANDT", "SCARAMUZZA").0.contains("`model_type` is \"SCARAMUZZA\""));
    // A file of the cameras alone.
    let error = read(&golden("kalibr/camchain.yaml")).unwrap_err();
    assert!(error.to_string().ends_with("camchain.yaml: no `cam0.T_cam_imu`"), "{error}");
    assert!(error.hint().unwrap().contains("camchain-imucam.yaml"));
    let error = read(&golden("kalibr/imu.yaml")).unwrap_err();
    assert!(
        error.to_string().ends_with("imu.yaml: no camera calibration of a known kind")
            && error.hint().is_some()
    );
    // A name that leaves the folder.
    assert!(
        spoilt("vins_fusion/config.yaml", "\"cam0.yaml\"", "\"../cam0.yaml\"")
            .0
            .contains("a file of the same folder is needed")
    );
}

#[test]
fn other_lenses_of_each_program_are_read() {
    let lens = |file: &str, changes: &[(&str, &str)]| {
        let dir = tempfile::tempdir().unwrap();
        let mut text = std::fs::read_to_string(golden(file)).unwrap();
        for (from, to) in changes {
            assert!(text.contains(from), "{file}: {from}");
            text = text.replacen(from, to, 1);
        }
        let path = dir.path().join("rig");
        std::fs::write(&path, text).unwrap();
        let camera = read(&path).unwrap_or_else(|error| panic!("{file}: {error}")).camera;
        (camera.distortion, camera.coefficients)
    };
    let kalibr = "kalibr/camchain-imucam.yaml";
    let omni = [("pinhole", "omni"), ("intrinsics: [", "intrinsics: [1.1, "), ("equidistant", "radtan")];
    assert_eq!(lens(kalibr, &omni).0, Distortion::Omni);
    assert_eq!(lens(kalibr, &omni).1.len(), 5);
    let sphere = [
        ("pinhole", "ds"),
        ("intrinsics: [", "intrinsics: [-0.2, 0.6, "),
        ("equidistant", "none"),
        ("distortion_coeffs", "other"),
    ];
    assert_eq!(lens(kalibr, &sphere), (Distortion::DoubleSphere, vec![-0.2, 0.6]));
    let ellipsoid = [
        ("pinhole", "eucm"),
        ("intrinsics: [", "intrinsics: [0.6, 1.1, "),
        ("equidistant", "none"),
        ("distortion_coeffs", "other"),
    ];
    assert_eq!(lens(kalibr, &ellipsoid), (Distortion::EnhancedUnified, vec![0.6, 1.1]));
    assert_eq!(
        lens("basalt.json", &[("kb4", "eucm"), ("\"k1\"", "\"alpha\": 0.6, \"beta\": 1.1, \"k1\"")]),
        (Distortion::EnhancedUnified, vec![0.6, 1.1])
    );
    assert_eq!(
        lens("basalt.json", &[("kb4", "ds"), ("\"k1\"", "\"xi\": -0.2, \"alpha\": 0.6, \"k1\"")]),
        (Distortion::DoubleSphere, vec![-0.2, 0.6])
    );
    assert_eq!(
        lens("basalt.json", &[("kb4", "fov"), ("\"k1\"", "\"w\": 0.9, \"k1\"")]),
        (Distortion::Fov, vec![0.9])
    );
    let mei = [
        ("KANNALA_BRANDT", "MEI"),
        (
            "projection_parameters",
            "mirror_parameters:\n   xi: 1.2\ndistortion_parameters: {k1: -0.1, k2: 0.01, p1: 0, p2: 0}\nprojection_parameters",
        ),
        ("   mu", "   gamma1"),
        ("   mv", "   gamma2"),
    ];
    assert_eq!(lens("vins.yaml", &mei), (Distortion::Omni, vec![1.2, -0.1, 0.01, 0.0, 0.0]));
    assert_eq!(lens("orbslam3.yaml", &[("KannalaBrandt8", "Rectified")]).0, Distortion::None);
    let eight = [
        ("equidistant", "radialtangential8"),
        ("distortion_coefficients: [", "distortion_coefficients: [0.1, 0.1, 0.1, 0.1, "),
    ];
    assert_eq!(lens("okvis2.yaml", &eight).1.len(), 8);
}

#[test]
fn xrslams_camera_and_imu_both_sit_on_a_body() {
    use crate::noise_formats::xrslam::tests::DEVICE;
    let of = |text: &str| parse(text.as_bytes(), Path::new("device.yaml")).unwrap();
    let read = of(DEVICE);
    assert_eq!((read.format, read.offset_s), (CalibrationFormat::Xrslam, 0.01));
    let pose = read.camera.body_from_cam;
    assert!((pose.translation.vector - nalgebra::Vector3::new(0.02, 0.07, 0.0)).norm() < 1e-12, "{pose}");
    assert!((pose.rotation.angle() - std::f64::consts::FRAC_PI_2).abs() < 1e-6, "{pose}");
    assert_eq!(read.camera.coefficients, [0.1, -0.2, 0.001, 0.002]);
    assert!(read.imu.is_some());
    let straight = of(&DEVICE.replace("camera_distortion_flag: 1", "camera_distortion_flag: 0"));
    assert_eq!(straight.camera.distortion, Distortion::None);
}
