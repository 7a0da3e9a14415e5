//! Basalt's calibration (JSON below `value0`): `T_imu_cam` maps camera to IMU, `cam_time_offset_ns` is added to the camera's stamps.
//!
//! Camera types: `pinhole`, `pinhole-radtan8`, `kb4`, `ds`, `eucm`, `fov`; `ucm` is a unified lens with alpha = xi / (1 + xi) and focal lengths that much
//! smaller.

use super::CalibrationError;
use super::found::{Extrinsics, Found};
use super::keys::Keys;
use dpn_core::camera::Distortion;
use nalgebra::Vector3;

pub(super) fn read(keys: &Keys<'_>) -> Result<Found, CalibrationError> {
    let value = keys.block("value0")?;
    let camera = value.block("intrinsics")?;
    let numbers = camera.block("intrinsics")?;
    let mut intrinsics = numbers.each(["fx", "fy", "cx", "cy"])?;
    let name = camera.text("camera_type")?;
    let (lens, coefficients) = match name.as_str() {
        "pinhole" => (Distortion::None, Vec::new()),
        "pinhole-radtan8" => {
            let eight = numbers.each(["k1", "k2", "p1", "p2", "k3", "k4", "k5", "k6"])?;
            (Distortion::RadialTangential, eight.to_vec())
        }
        "kb4" => (Distortion::Equidistant, numbers.each(["k1", "k2", "k3", "k4"])?.to_vec()),
        "ds" => (Distortion::DoubleSphere, numbers.each(["xi", "alpha"])?.to_vec()),
        "eucm" => (Distortion::EnhancedUnified, numbers.each(["alpha", "beta"])?.to_vec()),
        "fov" => (Distortion::Fov, numbers.each(["w"])?.to_vec()),
        "ucm" => {
            let alpha = numbers.number("alpha")?;
            if !(0.0..1.0).contains(&alpha) {
                return Err(numbers.bad("alpha", format!("is {alpha}; it is from 0 to below 1")));
            }
            let xi = alpha / (1.0 - alpha);
            intrinsics[0] *= 1.0 + xi;
            intrinsics[1] *= 1.0 + xi;
            (Distortion::Omni, vec![xi, 0.0, 0.0, 0.0, 0.0])
        }
        other => {
            let known =
                "known are \"pinhole\", \"pinhole-radtan8\", \"kb4\", \"ds\", \"eucm\", \"fov\", \"ucm\"";
            return Err(camera.bad("camera_type", format!("is \"{}\"; {known}", crate::printable(other))));
        }
    };
    let pose = value.block("T_imu_cam")?;
    let offset = Vector3::from(pose.each(["px", "py", "pz"])?);
    let turn = pose.each(["qx", "qy", "qz", "qw"])?;
    let sizes = value.list("resolution")?;
    let size = match sizes.as_slice() {
        [width, height, ..]
            if [width, height].iter().all(|v| (1.0..=65_535.0).contains(*v) && v.fract() == 0.0) =>
        {
            [*width as u32, *height as u32]
        }
        other => {
            return Err(
                value.bad("resolution", format!("is {other:?}; width and height of each camera are needed"))
            );
        }
    };
    Ok(Found {
        size,
        intrinsics,
        lens,
        coefficients,
        at: camera.place("intrinsics"),
        pose: value.turned("T_imu_cam", turn, offset)?,
        extrinsics: Extrinsics::CamToImu("T_imu_cam"),
        offset_s: value.optional("cam_time_offset_ns")?.unwrap_or(0.0) * 1e-9,
        rate: None,
    })
}
