//! Monocular visual-inertial odometry in a sliding window, told the inertial noise sample by sample.
//!
//! Knows no files and no networks: samples, noise and tracks are fed, poses come back. Body = IMU; the world's z axis points up,
//! gravity is `(0, 0, -9.81)`; rotations perturb on the right, `R <- R Exp(d)`; `f64` throughout.

#![cfg_attr(test, allow(clippy::unwrap_used))]

pub mod clock;
pub mod components;
pub mod diagnosis;
pub mod estimator;
pub mod factors;
pub mod frontend;
pub mod init;
pub mod lens;
pub mod preint;
pub mod state;
pub mod window;

pub use estimator::{Estimator, EstimatorConfig};
pub use state::{ImuBias, NavState};

/// The README's code is a test.
#[cfg(doctest)]
#[doc = include_str!("README.md")]
struct Readme;
