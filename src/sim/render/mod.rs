//! A rendered camera: images of a textured world along any trajectory, so that a pipeline that begins at pixels runs where no image
//! can be had.
//!
//! ```text
//! path, stamp -> pose -> nearest surface at every pixel -> texture, light -> lens blur -> vignetting, exposure, noise -> bytes
//! ```
//!
//! * The world is the room or hall of [`crate::tracks`] around the flight, of textured rectangles: walls in relief, posters, windows, boxes,
//!   mats, beams. Things hide each other; nothing stands where the body flies.
//! * Every pixel's line of sight is that of the calibrated lens, and meets the world exactly: no interpolation of geometry, so that the flow
//!   between two images is known to rounding ([`RenderedCamera::point_at`], [`RenderedCamera::pixel_of`]).
//! * Textures are painted once and looked up at the size of a pixel's footprint, several times along its long axis where a surface is seen
//!   aslant; pixels at edges are averages over eight lines. So pictures do not shimmer.
//! * Shot noise, vignetting, an exposure control with its lag, random changes, dark phases, blur by motion, lines read out one after the other, lost
//!   images: [`RenderConfig`].
//!
//! An image is a function of configuration, path, seed and stamp; every draw is named. Source of the perspective: Heckbert 1989, the
//! rational linear map of a plane; of the levels: Williams 1983.
//!
//! Not here: shadows, gloss, moving things, dust on the lens.

mod camera;
mod config;
mod exposure;
mod lens_blur;
mod raster;
mod scene;
mod sensor;
mod texture;

pub use camera::{RenderError, RenderedCamera, SharedPath};
pub use config::{
    ExposureConfig, GapConfig, LensConfig, LowLightConfig, MotionBlurConfig, RenderConfig, SensorConfig,
};
pub use raster::NoLineOfSight;
