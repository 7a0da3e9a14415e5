//! Rotations, poses and the sphere of directions, with the derivatives that estimators need.
//!
//! Everything perturbs on the right: `R <- R Exp(d)`, with `d` in the frame that `R` maps from.

pub mod nearest;
pub mod rigid;
pub mod so3;
pub mod sphere;
