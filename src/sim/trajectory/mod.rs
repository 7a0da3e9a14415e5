//! Smooth trajectories with analytic derivatives: where the body is, how it moves and what an ideal IMU reads, at any time.

mod attitude;
mod bspline;
mod path;
mod shaking;
mod state;

pub use attitude::Attitude;
pub use bspline::{Jet, ORDER, UniformSpline};
pub use path::Trajectory;
pub(crate) use shaking::Shaking;
pub use state::State;
