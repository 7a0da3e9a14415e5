//! Corners worth tracking: the smaller eigenvalue of the gradients' covariance.
//!
//! With gradients `g` by Sobel's operator and a sum over 3 x 3 pixels, the response of a pixel is the smaller eigenvalue of the mean of
//! `g g^T` \[(grey/px)^2\]. A corner is a pixel whose response is the largest among its neighbours and at least `quality` times the
//! largest of the image; the strongest are taken first, none nearer than `distance_px` to another or to a point that is tracked.
//! Source: Shi and Tomasi 1994. The same corners as OpenCV's `goodFeaturesToTrack`, but for those on the image's outermost pixels.

mod config;
mod detector;
mod mask;
mod response;

pub use config::CornerConfig;
pub use detector::{Corner, Detector};
pub use mask::Mask;
