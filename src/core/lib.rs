//! The words every crate of `dpn` speaks: time, IMU samples and recordings, noise types and the noise seam,
//! signal processing, simple noise estimators, the camera model, named random streams.
//!
//! No files, no machine learning and no solver live here. Lengths are metres, angles radians, times seconds (`f64`) or
//! integer nanoseconds ([`Stamp`]). The body frame is the IMU's; the world's z axis points up and gravity is
//! `(0, 0, -9.81)`: a sensor at rest and level reads `+9.81` on z.
//!
//! Without the feature `full` there are time, samples, noise, checked configurations and checksums alone: what a program needs that asks a
//! trained network.

#![cfg_attr(test, allow(clippy::unwrap_used))]

pub mod bounds;
#[cfg(feature = "full")]
pub mod camera;
#[cfg(feature = "full")]
pub mod check;
pub mod checksum;
pub mod config;
#[cfg(feature = "full")]
pub mod estimate;
#[cfg(feature = "full")]
pub mod geometry;
mod gone;
#[cfg(feature = "full")]
pub mod image;
pub mod imu;
mod named;
pub mod noise;
#[cfg(feature = "full")]
mod plateaus;
#[cfg(feature = "full")]
pub mod progress;
#[cfg(feature = "full")]
mod quiet;
#[cfg(feature = "full")]
pub mod random;
#[cfg(feature = "full")]
mod samples;
mod side;
#[cfg(feature = "full")]
pub mod signal;
pub mod time;
#[cfg(feature = "full")]
pub mod tracks;
#[cfg(feature = "full")]
pub mod trajectory;
#[cfg(feature = "full")]
pub mod truth;

#[cfg(feature = "full")]
pub use image::{GrayImage, GrayView};
pub use imu::{ImuRecording, ImuSample, Sensor};
pub use noise::{ImuNoise, NoiseModel, NoiseTrack};
#[cfg(feature = "full")]
pub use quiet::{LOUD_GYRO, quiet_gyro_noise};
#[cfg(feature = "full")]
pub use samples::{Recorded, Samples, median_rate};
pub use side::Side;
pub use time::{SampleRate, Stamp};
#[cfg(feature = "full")]
pub use tracks::{Track, TrackFrame};

/// Norm of gravity that every crate assumes \[m/s^2\].
pub const GRAVITY: f64 = 9.81;

/// The README's code is a test.
#[cfg(doctest)]
#[doc = include_str!("README.md")]
struct Readme;
