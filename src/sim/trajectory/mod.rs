//! Smooth trajectories with analytic derivatives: where the body is, how it moves and what an ideal IMU reads, at any time.

mod attitude;
mod bspline;
mod path;
mod shaking;

pub use attitude::Attitude;
pub use bspline::{Jet, ORDER, SplineError, UniformSpline};
pub use path::{State, Trajectory};
pub(crate) use shaking::Shaking;
