//! Kalibr's `camchain-imucam.yaml`, and OpenVINS' `kalibr_imucam_chain.yaml` with the same keys.
//!
//! `T_cam_imu` maps IMU to camera (Kalibr's wiki, "Yaml formats"); OpenVINS writes `T_imu_cam`, camera to IMU, as well. With
//! `timeshift_cam_imu`, t_imu = t_cam + shift. A file with the extrinsics alone, as DM-VIO has it, takes its lens from the `camera.txt` beside it ([`dso`]).

use super::CalibrationError;
use super::dso::{self, Lens};
use super::found::{Extrinsics, Found};
use super::keys::{Keys, Place};
use crate::kalibr_cameras::KalibrCamera;
use dpn_core::camera::Distortion;

const NO_IMU: &str = "a camchain.yaml of the cameras alone does not say how they sit on the IMU: take camchain-imucam.yaml, which \
                      kalibr_calibrate_imu_camera writes";

/// Reads them; `lens` is that of a `camera.txt`, which is looked for beside the file too where that has the extrinsics alone.
pub(super) fn read(keys: &Keys<'_>, lens: Option<(Lens, Place)>) -> Result<Found, CalibrationError> {
    let camera = keys.block("cam0")?;
    let lens = match lens {
        _ if camera.has("intrinsics") => None,
        Some(lens) => Some(lens),
        None => dso::beside(keys.path())?,
    };
    let (Lens { size, intrinsics, lens, coefficients }, at) = lens.map_or_else(|| own_lens(&camera), Ok)?;
    let extrinsics = match camera.first(&["T_cam_imu", "T_imu_cam"]) {
        Some("T_imu_cam") => Extrinsics::CamToImu("T_imu_cam"),
        _ => Extrinsics::ImuToCam("T_cam_imu"),
    };
    let (Extrinsics::CamToImu(key) | Extrinsics::ImuToCam(key)) = extrinsics;
    Ok(Found {
        size,
        intrinsics,
        lens,
        coefficients,
        at,
        pose: camera.pose(key, NO_IMU)?,
        extrinsics,
        offset_s: camera.optional("timeshift_cam_imu")?.unwrap_or(0.0),
        rate: None,
    })
}

fn own_lens(camera: &Keys<'_>) -> Result<(Lens, Place), CalibrationError> {
    let model = camera.text("camera_model")?;
    let distortion =
        if camera.has("distortion_model") { camera.lens("distortion_model")? } else { Distortion::None };
    let own = if camera.has("distortion_coeffs") { camera.list("distortion_coeffs")? } else { Vec::new() };
    let lens = KalibrCamera::lens(&model, distortion, &camera.list("intrinsics")?, &own);
    let (lens, intrinsics, coefficients) = lens.map_err(|(key, problem)| camera.bad(key, problem))?;
    let at = camera.place(if camera.has("distortion_coeffs") { "distortion_coeffs" } else { "intrinsics" });
    Ok((Lens { size: camera.size(&["resolution"])?, intrinsics, lens, coefficients }, at))
}
