//! The camera model: pinhole with radial-tangential distortion.
//!
//! A camera looks along its z axis, x to the right and y down in the image. Pixels are `(u, v)`, the centre of the first one at
//! `(0, 0)`. *Normalised* coordinates are `(x/z, y/z)`; a *bearing* is a unit vector in the camera's frame.

mod config;
mod pinhole;

pub use config::{CameraConfig, Distortion};
pub use pinhole::{BadCamera, PinholeRadtan};
