//! The Allan plot of an IMU at rest: five coefficients an axis, each with an interval, and how long a log would show the others.
//!
//! * [`deviation`]: overlapping Allan variances by cumulative sums.
//! * [`model`]: the five slopes.
//! * [`covariance`]: how Allan variances scatter, exactly for the model and the length of the log.
//! * [`fit`]: nonnegative least squares, intervals, what is seen and what is not.
//! * [`rest`]: the seconds that moved.
//! * [`AllanLog`]: all of it for a log; [`report`] says it in words.
//! * [`compare`]: a configuration against it; `mix_up`: what may have been mixed up in it.

mod bridge;
mod chi;
#[cfg(feature = "formats")]
pub mod compare;
pub mod covariance;
pub mod deviation;
pub mod fit;
#[cfg(test)]
mod golden;
mod inversion;
mod log;
#[cfg(feature = "formats")]
pub(crate) mod mix_up;
pub mod model;
mod nnls;
#[cfg(feature = "formats")]
pub mod report;
pub mod rest;
#[cfg(test)]
mod simulate;

pub use fit::{Estimate, Fit, Hump, Planner, Point};
pub use log::{AllanError, AllanLog, AxisFit, LEAST_S};
pub use model::Coefficient;
