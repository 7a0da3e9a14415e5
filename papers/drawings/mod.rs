//! The figures, each from results and configuration; nothing is drawn by hand.

mod architecture;
mod charts;
mod flights;

pub(super) use architecture::{OdometryDrawing, WindowDrawing};
pub use charts::loop_curve;
pub(super) use charts::{has_curve, injected_sweep, rmse, sweep};
pub(super) use flights::{errors, sigma_over_flight, step_response, trajectories};
