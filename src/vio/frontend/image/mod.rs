//! Images as the kernels want them: padded planes, pyramids, and figures about an image as a whole.

mod plane;
mod pyramid;
mod stats;

pub use plane::Plane;
pub use pyramid::Pyramid;
#[cfg(test)]
pub(crate) use pyramid::pyr_down;
pub use stats::ImageStats;
