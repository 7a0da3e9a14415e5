//! Teaching: windows cut from recordings, noise injected into them, labels, the split, the trainer, and regressors on
//! window features that a network has to beat.
#![cfg_attr(test, allow(clippy::unwrap_used, clippy::expect_used))]

pub mod asl;
pub mod base;
pub mod calibration;
#[cfg(feature = "wgpu")]
mod card;
pub mod clean;
pub mod config;
pub mod corpus;
mod device;
pub mod draw;
pub mod examples;
pub mod features;
mod flight;
pub mod label;
pub mod levels;
mod loss;
pub mod own;
pub mod rate;
pub mod regress;
pub mod run;
pub mod schedule;
pub mod sensor;
pub mod split;
pub mod state;
pub mod trainer;
pub mod vibration;
mod window;
pub mod windows;

pub use device::Device;

/// The README's code is a test.
#[cfg(doctest)]
#[doc = include_str!("README.md")]
struct Readme;
