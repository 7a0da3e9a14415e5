//! The estimator as a program uses it: feed samples and frames, take updates.
//!
//! [`Estimator::feed_imu`] and [`Estimator::feed_frame`] take what sensors give; [`Estimator::next_update`] works off frames whose
//! samples are there. Between two frames: `imu_buffer` cuts the samples, [`crate::init`] finds the first states, [`crate::window`]
//! estimates, [`health`] judges, and a failure starts again from the last good pose.

mod config;
#[allow(clippy::module_inception)]
mod estimator;
pub mod health;
mod imu_buffer;
mod ray_rates;
mod report;
mod starter;
mod update;
mod validate;

pub use config::EstimatorConfig;
pub use estimator::{Estimator, FeedError};
pub use report::{RunReport, Stage};
pub use starter::StartFrame;
pub use update::{Phase, RestartReason, Update};
