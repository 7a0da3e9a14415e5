//! Judging: the open loop, the closed loop, trajectories and their consistency, statistics. Numbers only: nothing here draws.
#![cfg_attr(test, allow(clippy::unwrap_used))]

pub mod closed_loop;
pub mod fleet;
pub mod injected;
pub mod metrics;
pub mod open_loop;
pub mod parallel;
pub mod published;
pub mod stats;
pub mod study;
pub mod sweeps;

/// Noise specs made into tracks.
pub use dpn_noise as noise;

/// The README's code is a test.
#[cfg(doctest)]
#[doc = include_str!("README.md")]
struct Readme;
