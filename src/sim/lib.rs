//! Simulated flights and an IMU whose noise is exactly known.
//!
//! Eleven flights of different character ([`flight`]) along smooth trajectories with analytic derivatives
//! ([`trajectory`]), recorded by an IMU ([`imu`]) with white noise that changes in time, walking biases, rotor vibration
//! and quantisation. Every part is on its own named random streams and comes back beside the recording
//! ([`SimulatedFlight`]), so that an estimator can be judged against the truth, not against a label. [`tracks`]
//! puts a camera on any path, flown or recorded, [`render`] makes its images.
//!
//! World z up, gravity (0, 0, -9.81), body = IMU: at rest and level the accelerometer reads +9.81 on z. Nothing here
//! reads or writes files.
#![cfg_attr(test, allow(clippy::unwrap_used))]

pub mod config;
pub mod flight;
pub mod imu;
pub mod render;
pub mod simulate;
pub mod tracks;
pub mod trajectory;

pub use config::{FlightConfig, StampPattern};
pub use flight::{Flight, Phase, Phases};
pub use imu::{ImuSeries, ImuTruth};
pub use render::{RenderConfig, RenderedCamera};
pub use simulate::{SimulatedFlight, SimulationError, path, simulate, simulate_all};
pub use tracks::{TracksConfig, simulate_tracks};
pub use trajectory::Trajectory;

/// The README's code is a test.
#[cfg(doctest)]
#[doc = include_str!("README.md")]
struct Readme;
