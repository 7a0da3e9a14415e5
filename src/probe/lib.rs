//! What a log says of its IMU: the noise of a sensor at rest ([`allan`]), the noise along the log ([`log_noise`]), whether the log can be
//! trusted ([`doctor`]), and what has changed from one log to another ([`compare`]). Needs neither an estimator nor images.
#![cfg_attr(test, allow(clippy::unwrap_used))]

pub mod allan;
#[cfg(feature = "networks")]
pub mod compare;
pub mod doctor;
mod finding;
#[cfg(feature = "networks")]
pub mod log_noise;
#[cfg(feature = "formats")]
pub mod paste;
pub mod phases;
mod rates;
pub mod rest_noise;
mod text;

pub use finding::{Finding, Weight};

/// The README's code is a test.
#[cfg(doctest)]
#[doc = include_str!("README.md")]
struct Readme;
