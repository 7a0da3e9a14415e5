//! The calibration that lies beside a recording: whatever file there reads as one.

use super::{Calibration, CalibrationError, read};
use crate::printable;
use std::path::{Path, PathBuf};

/// Files of a folder that are looked into.
const MOST: usize = 64;

/// The only calibration in `dirs`, and its file; none where there is none. Several files that say the same are one.
///
/// # Errors
/// Several that differ.
pub fn find(dirs: &[PathBuf]) -> Result<Option<(PathBuf, Calibration)>, CalibrationError> {
    let mut found: Vec<(PathBuf, Calibration)> = Vec::new();
    for file in dirs.iter().flat_map(|dir| files(dir)) {
        let Ok(calibration) = read(&file) else { continue };
        if found.iter().all(|(_, other)| other.checksum() != calibration.checksum()) {
            found.push((file, calibration));
        }
    }
    match found.len() {
        0 | 1 => Ok(found.pop()),
        _ => {
            let name = |(file, _): &(PathBuf, Calibration)| printable(&file.display().to_string());
            let files: Vec<String> = found.iter().map(name).collect();
            Err(CalibrationError::Several { one: files[0].clone(), files: files.join(", ") })
        }
    }
}

/// Files of a folder that may be calibrations by their names.
fn files(dir: &Path) -> Vec<PathBuf> {
    let dir = if dir.as_os_str().is_empty() { Path::new(".") } else { dir };
    let is_one = |path: &PathBuf| {
        let is = |ends: &[&str]| {
            path.extension().is_some_and(|e| ends.iter().any(|end| e.eq_ignore_ascii_case(end)))
        };
        (is(&["yaml", "yml", "json"]) || path.ends_with("camera.txt")) && path.is_file()
    };
    let entries = std::fs::read_dir(dir).into_iter().flatten().flatten();
    let mut files: Vec<PathBuf> = entries.map(|entry| entry.path()).filter(is_one).take(MOST).collect();
    files.sort();
    files
}

#[cfg(test)]
mod tests {
    use super::*;
    use dpn_core::camera::Distortion;
    use std::fs;

    const CHAIN: &str = "cam0:\n  T_cam_imu:\n  - [1.0, 0.0, 0.0, 0.1]\n  - [0.0, 1.0, 0.0, 0.2]\n  - [0.0, 0.0, 1.0, 0.3]\n  - [0.0, 0.0, 0.0, 1.0]\n";
    const LENS: &str = "  camera_model: pinhole\n  intrinsics: [453.0, 454.0, 321.0, 176.0]\n  distortion_model: radtan\n  distortion_coeffs: [0.1, 0, 0, 0]\n  resolution: [640, 360]\n";

    #[test]
    fn the_only_one_is_found_several_are_asked_about_and_dm_vios_two_files_are_one() {
        let tmp = tempfile::tempdir().unwrap();
        let dir = tmp.path();
        let put = |name: &str, text: &str| fs::write(dir.join(name), text).unwrap();
        fs::create_dir(dir.join("cam0")).unwrap();
        let find = || find(&[dir.to_path_buf(), dir.join("cam0")]);
        put("imu.yaml", "accelerometer_noise_density: 1\n");
        assert!(find().unwrap().is_none());
        put("camchain.yaml", CHAIN);
        assert!(find().unwrap().is_none(), "extrinsics alone");
        put("cam0/camera.txt", "RadTan 453.0 454.0 321.0 176.0 0.1 0 0 0\n640 360\ncrop\n640 360\n");
        let (file, calibration) = find().unwrap().unwrap();
        assert!(file.ends_with("camchain.yaml"));
        let [x, y, z] = calibration.camera.body_from_cam.inverse().translation.vector.into();
        assert_eq!([x, y, z].map(|v: f64| (v * 1e6).round()), [1e5, 2e5, 3e5]);
        put("camchain.yaml", &format!("{CHAIN}{LENS}"));
        assert_eq!(find().unwrap().unwrap().1.checksum(), calibration.checksum());
        put("other.yaml", &format!("{CHAIN}{LENS}").replace("453.0", "500.0"));
        let error = find().unwrap_err();
        assert!(
            error.to_string().contains("camchain.yaml") && error.to_string().contains("other.yaml"),
            "{error}"
        );
        assert!(error.hint().unwrap().contains("--calib "));
    }

    #[test]
    fn dsos_lenses_are_read_by_name_by_count_and_as_shares_of_the_image() {
        let lens = |text: &str| super::super::dso::parse(text.as_bytes());
        let fov = lens("0.5 0.75 0.5 0.5 0.9\n640 480\ncrop\n").unwrap();
        assert_eq!(
            (fov.lens, fov.intrinsics, fov.coefficients),
            (Distortion::Fov, [320.0, 360.0, 319.5, 239.5], vec![0.9])
        );
        let pinhole = lens("Pinhole 300 300 320 240 0\n640 480\nnone\n").unwrap();
        assert_eq!((pinhole.lens, pinhole.coefficients.len()), (Distortion::None, 0));
        assert_eq!(
            lens("EquiDistant 190 190 254 256 .1 .2 .3 .4\n512 512\n").unwrap().lens,
            Distortion::Equidistant
        );
        for other in ["", "1 2 3\n4 5\n", "RadTan 1 2 3 4\n640 480\n", "1 2 3 4 5\n640\n", "hello\nworld\n"] {
            assert_eq!(lens(other), None, "{other}");
        }
    }
}
