//! A camera's calibration as other programs write it: Kalibr, OpenVINS, VINS, ORB-SLAM3, Basalt, OKVIS, ASL, DSO, XRSLAM.
//!
//! * [`read`]: file to [`Calibration`], the program known by the file's keys.
//! * One file a format, each from keys to what it says; `keys` reads values with their lines, `found` holds them to what a camera can be.
//!
//! Only the first camera is read. Extrinsics become `body_from_cam` whichever way they are written, time offsets what is added to the camera's
//! stamps. Noise figures are read by [`noise_formats`] from the same file or the one beside it. A configuration may name
//! another (`cam0_calib`, `relative_config_imucam`): that is looked for in its own folder.

mod basalt;
pub mod beside;
mod dso;
mod error;
mod found;
mod kalibr;
mod keys;
mod okvis;
mod orbslam;
mod vins;
mod xrslam;

pub use error::CalibrationError;
pub use found::{Calibration, CalibrationFormat, Extrinsics};

use crate::asl::camera::parse_config;
use crate::noise_formats::kalibr_results;
use crate::noise_formats::tree::Tree;
use crate::noise_formats::{self, Format, FormatError, Given, NoiseCalibration};
use crate::small::read_config;
use found::Found;
use keys::Keys;
use std::path::{Path, PathBuf};

/// Reads the calibration at `path`.
///
/// # Errors
/// A file that cannot be read or is no YAML or JSON, of no known kind, without a key, with a lens that is none, a number of coefficients that
/// it cannot have, or extrinsics that are no rigid motion.
pub fn read(path: &Path) -> Result<Calibration, CalibrationError> {
    parse(&read_config(path)?, path)
}

/// As [`read`], of bytes; `path` is for messages, and where files that a configuration names are looked for.
///
/// # Errors
/// As [`read`].
pub fn parse(bytes: &[u8], path: &Path) -> Result<Calibration, CalibrationError> {
    if kalibr_results::as_yaml(bytes).is_some() {
        // Written beside it, under the same name but for the kind.
        let name = path.file_name().unwrap_or_default().to_string_lossy().replace("results-", "camchain-");
        let chain = path.with_file_name(name).with_extension("yaml");
        return if chain.is_file() {
            read(&chain)
        } else {
            Err(CalibrationError::Missing {
                path: path.to_path_buf(),
                key: "resolution".to_owned(),
                remedy: "Kalibr's text does not say how large an image is; give the camchain-imucam.yaml that it writes beside it",
            })
        };
    }
    if dso::parse(bytes).is_some() {
        let chain = dso::chain(path).ok_or_else(|| CalibrationError::Missing {
            path: path.to_path_buf(),
            key: "T_cam_imu".to_owned(),
            remedy: "a camera.txt does not say how the camera sits on the IMU; put Kalibr's camchain.yaml with `cam0: T_cam_imu` beside it",
        })?;
        let tree = Tree::parse(&read_config(&chain)?, &chain)?;
        return kalibr::read(&Keys::new(&chain, &tree), dso::lens_at(bytes, path))?
            .checked(CalibrationFormat::Dso);
    }
    let tree = Tree::parse(bytes, path)?;
    let keys = Keys::new(path, &tree);
    let format = format_of(&keys).ok_or_else(|| CalibrationError::Unknown { path: path.to_path_buf() })?;
    let found = match format {
        CalibrationFormat::Asl => {
            let own = parse_config(bytes, path)?;
            let extrinsics = Extrinsics::CamToImu("T_BS");
            return Ok(Calibration {
                format,
                rate: Some(own.rate),
                camera: own,
                extrinsics,
                offset_s: 0.0,
                imu: None,
            });
        }
        CalibrationFormat::Kalibr | CalibrationFormat::Dso | CalibrationFormat::CameraInfo => {
            kalibr::read(&keys, None)?
        }
        CalibrationFormat::OpenVins => open_vins(&keys)?,
        CalibrationFormat::Vins => vins::read(&keys)?,
        CalibrationFormat::OrbSlam3 => orbslam::read(&keys)?,
        CalibrationFormat::Basalt => basalt::read(&keys)?,
        CalibrationFormat::Okvis => okvis::read(&keys)?,
        CalibrationFormat::Xrslam => xrslam::read(&keys)?,
    };
    let mut calibration = found.checked(format)?;
    calibration.imu = noise_of(path, bytes, &keys);
    Ok(calibration)
}

/// The program that writes such keys.
fn format_of(keys: &Keys<'_>) -> Option<CalibrationFormat> {
    let any = |names: &[&str]| names.iter().any(|name| keys.has(name));
    if any(&["relative_config_imucam"]) {
        return Some(CalibrationFormat::OpenVins);
    }
    if xrslam::is(keys) {
        return Some(CalibrationFormat::Xrslam);
    }
    if let Some(camera) = keys.below("cam0") {
        let open_vins = camera.has("T_imu_cam");
        return Some(if open_vins { CalibrationFormat::OpenVins } else { CalibrationFormat::Kalibr });
    }
    if keys.below("value0").is_some_and(|inner| inner.has("intrinsics")) {
        return Some(CalibrationFormat::Basalt);
    }
    if any(&["cameras"]) {
        return Some(CalibrationFormat::Okvis);
    }
    if any(&["Camera.type", "Camera1.fx", "Camera.fx"]) {
        return Some(CalibrationFormat::OrbSlam3);
    }
    if any(&["model_type", "cam0_calib", "extrinsicRotation", "body_T_cam0"]) {
        return Some(CalibrationFormat::Vins);
    }
    any(&["T_BS"]).then_some(CalibrationFormat::Asl).filter(|_| any(&["intrinsics"]))
}

/// `estimator_config.yaml` names the file of the camera; that file has Kalibr's keys.
fn open_vins(keys: &Keys<'_>) -> Result<Found, CalibrationError> {
    if !keys.has("relative_config_imucam") {
        return kalibr::read(keys, None);
    }
    let path = keys.beside("relative_config_imucam")?;
    let tree = Tree::parse(&read_config(&path)?, &path)?;
    kalibr::read(&Keys::new(&path, &tree), None)
}

/// Whose keys of the IMU's noise there are, and in which file: in this one, else the one it names, else one beside it by its usual name. What cannot
/// be read is `dpn noise`'s business.
fn noise_of(path: &Path, bytes: &[u8], keys: &Keys<'_>) -> Option<(PathBuf, Format)> {
    let given = Given { keep_zeros: true, ..Given::default() };
    let format = |read: Result<NoiseCalibration, FormatError>| match read {
        Ok(noise) => Some(noise.format),
        // Figures per sample, and a file that does not say how many there are in a second.
        Err(FormatError::NeedsRate { format, .. }) => Some(format),
        Err(_) => None,
    };
    if let Some(own) = format(noise_formats::parse(bytes, path, None, &given)) {
        return Some((path.to_path_buf(), own));
    }
    let named = keys.has("relative_config_imu").then(|| keys.beside("relative_config_imu").ok()).flatten();
    let usual = ["imu.yaml", "kalibr_imu_chain.yaml", "imu0.yaml"].map(|name| path.with_file_name(name));
    let mut files = named.into_iter().chain(usual).filter(|file| file.is_file());
    files.find_map(|file| Some((file.clone(), format(noise_formats::read(&file, None, &given))?)))
}

#[cfg(test)]
mod tests;
