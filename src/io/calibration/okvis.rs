//! OKVIS' and OKVIS2's configuration: a list `cameras`, whose `T_SC` maps camera to IMU; `image_delay` is taken off the camera's stamps.

use super::CalibrationError;
use super::found::{Extrinsics, Found};
use super::keys::Keys;

pub(super) fn read(keys: &Keys<'_>) -> Result<Found, CalibrationError> {
    let camera = keys.block("cameras")?;
    let [fx, fy] = camera.numbers("focal_length")?;
    let [cx, cy] = camera.numbers("principal_point")?;
    let common = keys.below("camera_parameters").or_else(|| keys.below("camera_params"));
    let (delay, rate) = match &common {
        Some(common) => (common.optional("image_delay")?.unwrap_or(0.0), common.rate("camera_rate")?),
        None => (0.0, None),
    };
    Ok(Found {
        size: camera.size(&["image_dimension"])?,
        intrinsics: [fx, fy, cx, cy],
        lens: camera.lens("distortion_type")?,
        coefficients: camera.list("distortion_coefficients")?,
        at: camera.place("distortion_coefficients"),
        pose: camera.pose("T_SC", "OKVIS writes where the camera sits as `T_SC` (camera to IMU)")?,
        extrinsics: Extrinsics::CamToImu("T_SC"),
        offset_s: -delay,
        rate,
    })
}
