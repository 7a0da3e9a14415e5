//! ORB-SLAM3's settings: `Camera1.fx` (or the older `Camera.fx`), `IMU.T_b_c1` (or `Tbc`), which maps camera to IMU.

use super::CalibrationError;
use super::found::{Extrinsics, Found};
use super::keys::Keys;
use dpn_core::camera::Distortion;

const NO_IMU: &str =
    "settings of a camera without an IMU do not say how it sits on one; add `IMU.T_b_c1` (camera to IMU)";

pub(super) fn read(keys: &Keys<'_>) -> Result<Found, CalibrationError> {
    let lens = match keys.has("Camera.type").then(|| keys.text("Camera.type")).transpose()?.as_deref() {
        Some("Rectified") => Distortion::None,
        Some(_) => keys.lens("Camera.type")?,
        None => Distortion::RadialTangential,
    };
    let new = keys.has("Camera1.fx");
    let pick = |name: &[&'static str; 2]| name[usize::from(!new)];
    let numbers = |names: &[[&'static str; 2]; 4]| keys.each([0, 1, 2, 3].map(|i| pick(&names[i])));
    let intrinsics = numbers(&[
        ["Camera1.fx", "Camera.fx"],
        ["Camera1.fy", "Camera.fy"],
        ["Camera1.cx", "Camera.cx"],
        ["Camera1.cy", "Camera.cy"],
    ])?;
    let (k1, k2, k3) =
        (["Camera1.k1", "Camera.k1"], ["Camera1.k2", "Camera.k2"], ["Camera1.k3", "Camera.k3"]);
    let coefficients = match lens {
        Distortion::None => Vec::new(),
        Distortion::Equidistant => numbers(&[k1, k2, k3, ["Camera1.k4", "Camera.k4"]])?.to_vec(),
        _ if !keys.has(pick(&k1)) => vec![0.0; 4],
        _ => {
            let four = numbers(&[k1, k2, ["Camera1.p1", "Camera.p1"], ["Camera1.p2", "Camera.p2"]])?;
            let third = keys.optional(pick(&k3))?;
            four.into_iter().chain(third).collect()
        }
    };
    let key = keys.first(&["IMU.T_b_c1", "Tbc"]).unwrap_or("IMU.T_b_c1");
    Ok(Found {
        size: keys.size(&["Camera.width", "Camera.height"])?,
        intrinsics,
        lens,
        coefficients,
        at: keys.place(pick(&["Camera1.fx", "Camera.fx"])),
        pose: keys.pose(key, NO_IMU)?,
        extrinsics: Extrinsics::CamToImu(key),
        offset_s: 0.0,
        rate: keys.rate("Camera.fps")?,
    })
}
