//! A body's way through the world, pose after pose.

use crate::time::Stamp;
use nalgebra::Isometry3;

/// Where the body was at one instant.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StampedPose {
    /// When.
    pub t: Stamp,
    /// Points in the body frame to the world \[m\].
    pub world_from_body: Isometry3<f64>,
}
