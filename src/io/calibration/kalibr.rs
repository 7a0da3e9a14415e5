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
    let model = camera.text("camera_model")?;
    let distortion =
        if camera.has("distortion_model") { camera.lens("distortion_model")? } else { Distortion::None };
    let own = if camera.has("distortion_coeffs") { camera.list("distortion_coeffs")? } else { Vec::new() };
    let lens = KalibrCamera::lens(&model, distortion, &camera.list("intrinsics")?, &own);
    let (lens, intrinsics, coefficients) = lens.map_err(|(key, problem)| camera.bad(key, problem))?;
    let extrinsics = match camera.first(&["T_cam_imu", "T_imu_cam"]) {
        Some("T_imu_cam") => Extrinsics::CamToImu("T_imu_cam"),
        _ => Extrinsics::ImuToCam("T_cam_imu"),
    };
    let (Extrinsics::CamToImu(key) | Extrinsics::ImuToCam(key)) = extrinsics;
    Ok(Found {
        size: camera.size(&["resolution"])?,
        intrinsics,
        lens,
        coefficients,
        at: camera.place(if camera.has("distortion_coeffs") { "distortion_coeffs" } else { "intrinsics" }),
        pose: camera.pose(key, NO_IMU)?,
        extrinsics,
        offset_s: camera.optional("timeshift_cam_imu")?.unwrap_or(0.0),
        rate: None,
    })
}
