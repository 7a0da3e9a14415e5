//! Kalibr's `camchain-imucam.yaml`, and OpenVINS' `kalibr_imucam_chain.yaml` with the same keys.
//!
//! `T_cam_imu` maps IMU to camera (Kalibr's wiki, "Yaml formats"); OpenVINS writes `T_imu_cam`, camera to IMU, as well. With
//! `timeshift_cam_imu`, t_imu = t_cam + shift.

use super::CalibrationError;
use super::found::{Extrinsics, Found};
use super::keys::Keys;
use crate::kalibr_cameras::KalibrCamera;
use dpn_core::camera::Distortion;

const NO_IMU: &str = "a camchain.yaml of the cameras alone does not say how they sit on the IMU: take camchain-imucam.yaml, which \
                      kalibr_calibrate_imu_camera writes";

pub(super) fn read(keys: &Keys<'_>) -> Result<Found, CalibrationError> {
    let camera = keys.block("cam0")?;
    // What a sphere needs stands before the focal lengths.
    let model = camera.text("camera_model")?;
    let kind = KalibrCamera::named(&model).map_err(|problem| camera.bad("camera_model", problem))?;
    let (sphere, leading) = (kind.lens, kind.leading.len());
    let distortion =
        if camera.has("distortion_model") { camera.lens("distortion_model")? } else { Distortion::None };
    if kind.distortion.is_some_and(|only| distortion != only && distortion != Distortion::None) {
        return Err(camera.bad(
            "distortion_model",
            format!("is \"{distortion}\"; a camera that is \"{model}\" goes with no such"),
        ));
    }
    let mut numbers = camera.list("intrinsics")?;
    if numbers.len() != 4 + leading {
        let problem =
            format!("has {} numbers; a camera that is \"{model}\" has {}", numbers.len(), 4 + leading);
        return Err(camera.bad("intrinsics", problem));
    }
    let four = numbers.split_off(leading);
    let mut coefficients = numbers;
    let own = if camera.has("distortion_coeffs") { camera.list("distortion_coeffs")? } else { Vec::new() };
    match (sphere, distortion) {
        (Some(Distortion::Omni), Distortion::None) => coefficients.extend([0.0; 4]),
        // A sphere without distortion may have zeros in its place.
        (Some(Distortion::DoubleSphere | Distortion::EnhancedUnified), _) | (None, Distortion::None)
            if own.iter().all(|v| *v == 0.0) => {}
        _ => coefficients.extend(own),
    }
    let extrinsics = match camera.first(&["T_cam_imu", "T_imu_cam"]) {
        Some("T_imu_cam") => Extrinsics::CamToImu("T_imu_cam"),
        _ => Extrinsics::ImuToCam("T_cam_imu"),
    };
    let (Extrinsics::CamToImu(key) | Extrinsics::ImuToCam(key)) = extrinsics;
    Ok(Found {
        size: camera.size(&["resolution"])?,
        intrinsics: [four[0], four[1], four[2], four[3]],
        lens: sphere.unwrap_or(distortion),
        coefficients,
        at: camera.place(if camera.has("distortion_coeffs") { "distortion_coeffs" } else { "intrinsics" }),
        pose: camera.pose(key, NO_IMU)?,
        extrinsics,
        offset_s: camera.optional("timeshift_cam_imu")?.unwrap_or(0.0),
        rate: None,
    })
}
