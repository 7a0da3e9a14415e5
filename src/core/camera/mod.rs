//! The camera model: a lens, focal lengths and a principal point.
//!
//! A camera looks along its z axis, x to the right and y down in the image. Pixels are `(u, v)`, the centre of the first one at
//! `(0, 0)`. *Normalised* coordinates are `(x/z, y/z)`; a *bearing* is a unit vector in the camera's frame.
//!
//! * [`CameraConfig`]: a calibration as files write it. [`CameraModel`]: what projects.
//! * [`Lens`]: pinhole with radial-tangential distortion (4, 5, 8 coefficients), equidistant, unified (MEI), double sphere, field of view.

mod bad_camera;
mod config;
mod fold;
#[cfg(test)]
mod golden;
mod lens;
mod lens_model;
mod model;
mod radial;
mod radtan;
mod sphere;

pub use bad_camera::BadCamera;
pub use config::{CameraConfig, Distortion, UnknownLens};
pub use lens::Lens;
pub use model::{CameraModel, WIDEST_RAD};
pub use radial::{Equidistant, Fov};
pub use radtan::Radtan;
pub use sphere::{DoubleSphere, Omni};
