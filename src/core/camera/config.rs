//! A camera as its calibration describes it.

use crate::named;
use crate::time::SampleRate;
use nalgebra::Isometry3;
use serde::{Deserialize, Serialize};
use std::str::FromStr;

named!(
    /// How a lens bends the image.
    #[derive(Default, Serialize, Deserialize)]
    #[serde(rename_all = "kebab-case")]
    pub enum Distortion {
        /// Not at all.
        None = "none",
        /// Radial and tangential: k1, k2, p1, p2; k3; k4, k5, k6 of OpenCV's rational lens.
        #[default]
        RadialTangential = "radial-tangential",
        /// Equidistant (fish-eye, Kannala-Brandt): k1 to k4.
        Equidistant = "equidistant",
        /// Unified (MEI, omnidirectional): xi, then k1, k2, p1, p2.
        Omni = "omni",
        /// Enhanced unified: alpha, beta.
        EnhancedUnified = "enhanced-unified",
        /// Double sphere: xi, alpha.
        DoubleSphere = "double-sphere",
        /// Field of view (ATAN): w \[rad\].
        Fov = "fov",
    }
);

/// A name that is no lens.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("there is no lens `{0}`; known are {known}", known = Distortion::names())]
pub struct UnknownLens(pub String);

impl Distortion {
    /// How many coefficients it may have.
    pub fn counts(self) -> &'static [usize] {
        match self {
            Self::None => &[0],
            Self::RadialTangential => &[4, 5, 8],
            Self::Equidistant => &[4],
            Self::Omni => &[5],
            Self::EnhancedUnified | Self::DoubleSphere => &[2],
            Self::Fov => &[1],
        }
    }
}

impl FromStr for Distortion {
    type Err = UnknownLens;

    /// Names as calibration programs write them; those of whole cameras (`KANNALA_BRANDT`, `ds`) too.
    fn from_str(text: &str) -> Result<Self, UnknownLens> {
        let plain: String =
            text.chars().filter(char::is_ascii_alphanumeric).collect::<String>().to_ascii_lowercase();
        match plain.as_str() {
            "none" | "" => Ok(Self::None),
            "radialtangential" | "radtan" | "plumbbob" | "radialtangential8" | "radtan8"
            | "rationalpolynomial" | "pinhole" => Ok(Self::RadialTangential),
            "equidistant" | "equi" | "fisheye" | "kb4" | "kb" | "kannalabrandt" | "kannalabrandt8" => {
                Ok(Self::Equidistant)
            }
            "omni" | "mei" | "unified" => Ok(Self::Omni),
            "enhancedunified" | "eucm" => Ok(Self::EnhancedUnified),
            "doublesphere" | "ds" => Ok(Self::DoubleSphere),
            "fov" | "atan" | "fieldofview" => Ok(Self::Fov),
            _ => Err(UnknownLens(text.to_owned())),
        }
    }
}

/// A camera as its calibration describes it.
#[derive(Debug, Clone, PartialEq)]
pub struct CameraConfig {
    /// Images a second.
    pub rate: SampleRate,
    /// Width and height \[px\].
    pub resolution: [u32; 2],
    /// Focal lengths and principal point: fu, fv, cu, cv \[px\].
    pub intrinsics: [f64; 4],
    /// The lens' model.
    pub distortion: Distortion,
    /// Its coefficients, in the model's order.
    pub coefficients: Vec<f64>,
    /// `T_BS`: points in the camera's frame to the body's (= IMU's).
    pub body_from_cam: Isometry3<f64>,
}
