//! A camera as its calibration describes it.

use crate::time::SampleRate;
use nalgebra::Isometry3;

/// How a lens bends the image.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Distortion {
    /// Not at all.
    None,
    /// Radial and tangential: k1, k2, p1, p2 and, where given, k3.
    RadialTangential,
    /// Equidistant (fish-eye, Kannala-Brandt): k1 to k4.
    Equidistant,
}

/// A pinhole camera as its `sensor.yaml` describes it.
#[derive(Debug, Clone, PartialEq)]
pub struct CameraConfig {
    /// Images a second.
    pub rate: SampleRate,
    /// Width and height \[px\].
    pub resolution: [u32; 2],
    /// Focal lengths and principal point: fu, fv, cu, cv \[px\].
    pub intrinsics: [f64; 4],
    /// The distortion's model.
    pub distortion: Distortion,
    /// Its coefficients, in the model's order.
    pub coefficients: Vec<f64>,
    /// `T_BS`: points in the camera's frame to the body's (= IMU's).
    pub body_from_cam: Isometry3<f64>,
}
