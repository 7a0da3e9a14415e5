//! What keeps a calibration from being a camera.

use super::Distortion;
use thiserror::Error;

/// A calibration that describes no camera.
#[derive(Debug, Error, PartialEq)]
pub enum BadCamera {
    /// A focal length that is not positive, or a value that is not finite.
    #[error(
        "camera intrinsics fx {fx}, fy {fy}, cx {cx}, cy {cy}: focal lengths must be positive, all values finite"
    )]
    Intrinsics {
        /// Focal length in u \[px\].
        fx: f64,
        /// Focal length in v \[px\].
        fy: f64,
        /// Principal point, u \[px\].
        cx: f64,
        /// Principal point, v \[px\].
        cy: f64,
    },
    /// An image without pixels.
    #[error("an image of {width} x {height} px")]
    Size {
        /// Columns.
        width: u32,
        /// Rows.
        height: u32,
    },
    /// Coefficients that the lens cannot have.
    #[error(
        "a lens that is {model} with coefficients {found:?}; it has {} finite numbers{}", counts(*model), bounds(*model)
    )]
    Coefficients {
        /// The lens.
        model: Distortion,
        /// What was given.
        found: Vec<f64>,
    },
}

fn counts(model: Distortion) -> String {
    model.counts().iter().map(ToString::to_string).collect::<Vec<_>>().join(" or ")
}

fn bounds(model: Distortion) -> &'static str {
    match model {
        Distortion::Omni => ", xi first and not negative",
        Distortion::EnhancedUnified => ", alpha from 0 to 1 and beta above 0",
        Distortion::DoubleSphere => ", xi above -1 and alpha from 0 to 1",
        Distortion::Fov => ", an angle between 0 and pi",
        _ => "",
    }
}
