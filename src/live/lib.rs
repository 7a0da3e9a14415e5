//! The odometry beside running sensors: samples, images or tracks as they come, poses as soon as they can be had. What a pipe, C, C++ and Python feed.
//!
//! * [`Odometry`]: what other programs hold; made from an [`OdometryConfig`], a TOML text. Stamps are as the sensors have them.
//! * [`LiveRun`]: an estimator and what tells it the noise, on one clock.
//! * [`LiveClocks`]: two sensors' stamps held against each other before.
//! * [`Watched`]: both together, and words on whatever keeps poses from coming.
//!
//! Poses have the bits of a run over the recording of the same samples and images.
#![cfg_attr(test, allow(clippy::unwrap_used))]

mod clocks;
mod config;
mod error;
mod gravity;
mod mounting;
mod odometry;
#[cfg(test)]
mod odometry_tests;
mod run;
mod setup;
mod still;
mod watched;

pub use clocks::{LiveClocks, LiveSensor};
pub use config::OdometryConfig;
pub use error::LiveError;
pub use gravity::gravity_warning;
pub use odometry::{NoiseInForce, Odometry};
pub use run::LiveRun;
pub use setup::{Fed, pass_over_spikes, settings_for};
pub use watched::{Listener, Seen, Totals, Watched};

/// The README's code is a test.
#[cfg(doctest)]
#[doc = include_str!("README.md")]
struct Readme;
