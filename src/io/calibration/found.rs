//! What a calibration says, and what a file said before it was held to what a camera can be.

use super::CalibrationError;
use super::keys::Place;
use crate::noise_formats::Format;
use dpn_core::camera::{BadCamera, CameraConfig, CameraModel, Distortion};
use dpn_core::checksum::of_bytes;
use dpn_core::named;
use dpn_core::time::{SampleRate, Stamp};
use nalgebra::Isometry3;
use std::fmt;
use std::path::PathBuf;

/// Rate of a camera whose calibration does not say: EuRoC's \[Hz\].
const USUAL_HZ: f64 = 20.0;

/// Stamps are not moved farther \[s\].
const LONGEST_OFFSET_S: f64 = 1.0;

named!(
    /// Who writes such a file.
    pub enum CalibrationFormat {
        /// ASL's and EuRoC's `cam0/sensor.yaml`.
        Asl = "ASL sensor.yaml",
        /// Kalibr's `camchain-imucam.yaml`.
        Kalibr = "Kalibr",
        /// OpenVINS' `kalibr_imucam_chain.yaml`, or the `estimator_config.yaml` that names it.
        OpenVins = "OpenVINS",
        /// VINS-Mono's and VINS-Fusion's configuration.
        Vins = "VINS",
        /// ORB-SLAM3's settings.
        OrbSlam3 = "ORB-SLAM3",
        /// Basalt's calibration.
        Basalt = "Basalt",
        /// OKVIS' and OKVIS2's configuration.
        Okvis = "OKVIS",
        /// DSO's and DM-VIO's `camera.txt`, with Kalibr's extrinsics.
        Dso = "DSO camera.txt",
        /// XRSLAM's configuration of a device.
        Xrslam = "XRSLAM",
        /// What ROS says of a camera while it runs; no file.
        CameraInfo = "ROS CameraInfo",
    }
);

/// The key of the extrinsics, and which way it maps.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Extrinsics {
    /// Points in the camera's frame to the IMU's: taken as it is.
    CamToImu(&'static str),
    /// Points in the IMU's frame to the camera's: inverted.
    ImuToCam(&'static str),
}

impl fmt::Display for Extrinsics {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::CamToImu(key) => write!(f, "`{key}` maps camera to IMU"),
            Self::ImuToCam(key) => write!(f, "`{key}` maps IMU to camera (inverted here)"),
        }
    }
}

/// A camera's calibration.
#[derive(Debug, Clone, PartialEq)]
pub struct Calibration {
    /// Who wrote it.
    pub format: CalibrationFormat,
    /// The camera; its rate is 20 Hz where the file says none.
    pub camera: CameraConfig,
    /// The rate that the file says.
    pub rate: Option<SampleRate>,
    /// How the extrinsics were written.
    pub extrinsics: Extrinsics,
    /// What is added to the camera's stamps to have them on the IMU's clock \[s\].
    pub offset_s: f64,
    /// The file of the IMU's noise and whose keys it has, where there is any: `dpn noise` reads it.
    pub imu: Option<(PathBuf, Format)>,
}

impl Calibration {
    /// A stamp of the camera's on the IMU's clock.
    pub fn on_imu_clock(&self, t: Stamp) -> Stamp {
        Stamp::from_ns(t.ns().saturating_add((1e9 * self.offset_s).round() as i64))
    }

    /// SHA-256 of all that a result depends on.
    pub fn checksum(&self) -> String {
        let CameraConfig { resolution, intrinsics, distortion, coefficients, body_from_cam, .. } =
            &self.camera;
        let place = body_from_cam.to_matrix();
        let text = format!(
            "{resolution:?} {intrinsics:?} {distortion} {coefficients:?} {:?} {:?}",
            place.as_slice(),
            self.offset_s
        );
        of_bytes(text.as_bytes())
    }
}

impl fmt::Display for Calibration {
    /// What was read, in one line.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { format, camera, extrinsics, offset_s, imu, .. } = self;
        let [width, height] = camera.resolution;
        let [fx, fy, ..] = camera.intrinsics;
        write!(
            f,
            "{format}: {width} x {height} px, {} lens ({} coefficients), focal lengths {fx:.1} and {fy:.1} px; {extrinsics}; camera's stamps {:+.4} s",
            camera.distortion,
            camera.coefficients.len(),
            offset_s
        )?;
        match imu {
            Some((path, format)) => write!(f, "; IMU noise as {format} in {}", path.display()),
            None => f.write_str("; no IMU noise"),
        }
    }
}

/// What a file says.
pub(super) struct Found {
    pub(super) size: [u32; 2],
    pub(super) intrinsics: [f64; 4],
    pub(super) lens: Distortion,
    pub(super) coefficients: Vec<f64>,
    /// Where the lens stands.
    pub(super) at: Place,
    pub(super) pose: Isometry3<f64>,
    pub(super) extrinsics: Extrinsics,
    pub(super) offset_s: f64,
    pub(super) rate: Option<SampleRate>,
}

impl Found {
    /// The calibration, where a camera can be so.
    pub(super) fn checked(self, format: CalibrationFormat) -> Result<Calibration, CalibrationError> {
        let body_from_cam = match self.extrinsics {
            Extrinsics::CamToImu(_) => self.pose,
            Extrinsics::ImuToCam(_) => self.pose.inverse(),
        };
        let camera = CameraConfig {
            rate: self.rate.or(SampleRate::from_hz(USUAL_HZ)).expect("20 Hz is a rate"),
            resolution: self.size,
            intrinsics: self.intrinsics,
            distortion: self.lens,
            coefficients: self.coefficients,
            body_from_cam,
        };
        CameraModel::try_from(&camera).map_err(|problem| match problem {
            BadCamera::Coefficients { .. } => self.at.error(problem.to_string()),
            _ => self.at.block().error(problem.to_string()),
        })?;
        if self.offset_s.abs() > LONGEST_OFFSET_S {
            let problem =
                format!("moves the camera's stamps by {} s; at most {LONGEST_OFFSET_S} s are", self.offset_s);
            return Err(self.at.block().error(problem));
        }
        let (rate, extrinsics, offset_s) = (self.rate, self.extrinsics, self.offset_s);
        Ok(Calibration { format, camera, rate, extrinsics, offset_s, imu: None })
    }
}
