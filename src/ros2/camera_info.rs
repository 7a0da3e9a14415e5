//! A calibration from what ROS says of a camera.

use crate::incoming::CameraInfo;
use dpn_core::camera::{BadCamera, CameraConfig, CameraModel, Distortion, UnknownLens};
use dpn_core::time::SampleRate;
use dpn_io::calibration::{Calibration, CalibrationFormat, Extrinsics};
use nalgebra::Isometry3;

/// Rate of a camera that does not say one \[Hz\].
const USUAL_HZ: f64 = 20.0;

/// A `CameraInfo` that is no calibration.
#[derive(Debug, PartialEq, thiserror::Error)]
pub enum BadCameraInfo {
    /// Its matrix is empty, as a camera's is that was never calibrated.
    #[error("its matrix K is zero: the camera is not calibrated")]
    Uncalibrated,
    /// Its lens has a name that is not known.
    #[error(transparent)]
    Lens(#[from] UnknownLens),
    /// Its numbers are no camera's.
    #[error(transparent)]
    Camera(#[from] BadCamera),
}

/// The calibration of a camera that stands at `body_from_cam` on its IMU.
///
/// # Errors
/// A matrix that is zero, a lens that is not known, coefficients that are too many or no numbers.
pub fn calibration_of(
    info: &CameraInfo,
    body_from_cam: Isometry3<f64>,
) -> Result<Calibration, BadCameraInfo> {
    let k = info.k;
    if k[0] == 0.0 {
        return Err(BadCameraInfo::Uncalibrated);
    }
    let lens: Distortion = info.model.parse()?;
    let distortion = if info.coefficients.is_empty() { Distortion::None } else { lens };
    let camera = CameraConfig {
        rate: SampleRate::from_hz(USUAL_HZ).expect("20 Hz is a rate"),
        resolution: info.size,
        intrinsics: [k[0], k[4], k[2], k[5]],
        distortion,
        coefficients: info.coefficients.clone(),
        body_from_cam,
    };
    CameraModel::try_from(&camera)?;
    Ok(Calibration {
        format: CalibrationFormat::CameraInfo,
        camera,
        rate: None,
        extrinsics: Extrinsics::CamToImu("/tf_static"),
        offset_s: 0.0,
        imu: None,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn info(model: &str, coefficients: &[f64], focal: f64) -> CameraInfo {
        CameraInfo {
            frame_id: "cam".to_owned(),
            size: [752, 480],
            model: model.to_owned(),
            coefficients: coefficients.to_vec(),
            k: [focal, 0.0, 367.0, 0.0, 457.0, 248.0, 0.0, 0.0, 1.0],
        }
    }

    #[test]
    fn lenses_of_ros_are_known_and_what_is_no_camera_is_refused() {
        let of = |info: &CameraInfo| calibration_of(info, Isometry3::identity());
        let plain = of(&info("plumb_bob", &[-0.28, 0.07, 0.0001, 0.00002, 0.0], 458.0)).unwrap();
        assert_eq!(plain.camera.intrinsics, [458.0, 457.0, 367.0, 248.0]);
        assert_eq!(plain.camera.distortion, Distortion::RadialTangential);
        let text = plain.to_string();
        assert!(text.starts_with("ROS CameraInfo: 752 x 480 px") && text.contains("/tf_static"), "{text}");
        assert!(of(&info("equidistant", &[0.0034, 0.0007, -0.002, 0.0002], 190.0)).is_ok());
        assert!(of(&info("rational_polynomial", &[0.0; 8], 458.0)).is_ok());
        assert_eq!(of(&info("", &[], 458.0)).unwrap().camera.distortion, Distortion::None);
        assert_eq!(of(&info("plumb_bob", &[0.0; 5], 0.0)), Err(BadCameraInfo::Uncalibrated));
        assert!(matches!(of(&info("thin_prism", &[0.0; 5], 458.0)), Err(BadCameraInfo::Lens(_))));
        assert!(matches!(of(&info("plumb_bob", &[0.0; 3], 458.0)), Err(BadCameraInfo::Camera(_))));
    }
}
