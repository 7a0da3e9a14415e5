//! XRSLAM's configuration of a device: `cam0.extrinsic` maps camera to body and `imu.extrinsic` IMU to body, quaternions x y z w; `time_offset` is added to the
//! camera's stamps.

use super::CalibrationError;
use super::found::{Extrinsics, Found};
use super::keys::Keys;
use dpn_core::camera::Distortion;
use nalgebra::{Isometry3, Vector3};

/// Whether it is such a file.
pub(super) fn is(keys: &Keys<'_>) -> bool {
    keys.below("cam0").and_then(|camera| camera.below("extrinsic")).is_some_and(|place| place.has("q_bc"))
}

pub(super) fn read(keys: &Keys<'_>) -> Result<Found, CalibrationError> {
    let camera = keys.block("cam0")?;
    let place = camera.block("extrinsic")?;
    let body_from_cam =
        place.turned("q_bc", place.numbers("q_bc")?, Vector3::from(place.numbers::<3>("p_bc")?))?;
    let body_from_imu = match keys.below("imu").and_then(|imu| imu.below("extrinsic")) {
        Some(imu) => imu.turned("q_bi", imu.numbers("q_bi")?, Vector3::from(imu.numbers::<3>("p_bi")?))?,
        None => Isometry3::identity(),
    };
    let is_bent = camera.optional("camera_distortion_flag")? != Some(0.0);
    Ok(Found {
        size: camera.size(&["resolution"])?,
        intrinsics: camera.numbers("intrinsics")?,
        lens: if is_bent { camera.lens("distortion_model")? } else { Distortion::None },
        coefficients: if is_bent { camera.list("distortion")? } else { Vec::new() },
        at: camera.place(if is_bent { "distortion" } else { "intrinsics" }),
        pose: body_from_imu.inverse() * body_from_cam,
        extrinsics: Extrinsics::CamToImu("q_bc, p_bc"),
        offset_s: camera.optional("time_offset")?.unwrap_or(0.0),
        rate: None,
    })
}
