//! The estimator as a program uses it: feed samples and frames, take updates.
//!
//! [`Estimator::feed_imu`] and [`Estimator::feed_image`] take what sensors give, in any order between the two;
//! [`Estimator::next_update`] works off images whose samples are there. Who has tracks already gives them to
//! [`Estimator::feed_frame`] instead. Between two frames: `imu_buffer` cuts the samples, [`crate::init`] finds the first states, [`crate::window`]
//! estimates, [`health`] judges, and a failure starts again from the last good pose.

mod config;
mod delayed;
#[allow(clippy::module_inception)]
mod estimator;
mod feed_error;
pub mod health;
mod history;
mod image_tracker;
mod imu_buffer;
mod jump;
#[cfg(test)]
mod line_tests;
#[cfg(test)]
mod live_tests;
mod ray_rates;
mod report;
mod spike;
mod starter;
mod suspects;
mod trust;
mod update;
mod validate;

pub use config::{EstimatorConfig, FedTracks};
pub use delayed::DelayedConfig;
pub use estimator::Estimator;
pub use feed_error::FeedError;
pub use image_tracker::{FrontEndObserver, ImageTracker};
pub use jump::BiasJump;
pub use report::{RunReport, Stage};
pub use starter::StartFrame;
pub use suspects::Suspect;
pub use trust::{Doubt, doubts, doubts_warning};
pub use update::{Phase, RestartReason, Update};
