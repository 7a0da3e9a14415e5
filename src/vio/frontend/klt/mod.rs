//! Pyramidal Lucas-Kanade tracking: where the patch around a point of one image is in the next.
//!
//! On every level, coarsest first, the shift `d` minimises `sum (J(x + d) - I(x))^2` over a square window by Gauss-Newton:
//!
//! ```text
//! A = sum g g^T,   b = sum (J(x + d) - I(x)) g,   d <- d - A^-1 b,   g = gradient of I
//! ```
//!
//! Positions are sub-pixel in both images, by bilinear interpolation. Gradients are Scharr's, taken of the interpolated patch, which
//! is the same as interpolating the image's. Against changes of light the window may be fitted up to a gain and an offset,
//! `J = (1 + a) I + o`: gradients are made orthogonal to the patch and to a constant, so that neither moves `b`
//! ("project-out", Baker and Matthews 2004, sec. 4.2; Hager and Belhumeur 1998), at the cost of the plain fit.
//!
//! Over many images the errors of searches add up; tracks are held to the windows they began with (`template`).
//!
//! A search that ended is believed where the window's grey values correlate with those it found.
//!
//! Source: Lucas and Kanade 1981; Bouguet 2000. Not here: forward-backward checks (the front-end's).

mod affine;
mod between;
mod config;
mod lanes;
mod likeness;
mod patch;
mod search;
mod template;
mod tracker;

pub use config::KltConfig;
pub(super) use template::Template;
#[cfg(test)]
pub(super) use tracker::tests::track_in_steady_light;
pub use tracker::{Klt, Shift};
