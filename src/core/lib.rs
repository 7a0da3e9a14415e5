//! The words every crate of `dpn` speaks: time, IMU samples and recordings, noise types and the noise seam,
//! signal processing, simple noise estimators, the camera model, named random streams.
//!
//! No files, no machine learning and no solver live here. Lengths are metres, angles radians, times seconds (`f64`) or
//! integer nanoseconds ([`Stamp`]). The body frame is the IMU's; the world's z axis points up and gravity is
//! `(0, 0, -9.81)`: a sensor at rest and level reads `+9.81` on z.

#![cfg_attr(test, allow(clippy::unwrap_used))]

pub mod bounds;
pub mod camera;
pub mod check;
pub mod checksum;
pub mod config;
pub mod estimate;
pub mod geometry;
mod gone;
pub mod image;
pub mod imu;
mod named;
pub mod noise;
mod plateaus;
pub mod progress;
mod quiet;
pub mod random;
mod samples;
mod settings;
mod side;
pub mod signal;
pub mod time;
pub mod tracks;
pub mod trajectory;
pub mod truth;

pub use image::{GrayImage, GrayView};
pub use imu::{ImuRecording, ImuSample, Sensor};
pub use noise::{ImuNoise, NoiseModel, NoiseTrack};
pub use quiet::{LOUD_GYRO, quiet_gyro_noise};
pub use samples::{Recorded, Samples, median_rate};
pub use side::Side;
pub use time::{SampleRate, Stamp};
pub use tracks::{Track, TrackFrame};

/// Norm of gravity that every crate assumes \[m/s^2\].
pub const GRAVITY: f64 = 9.81;

/// The README's code is a test.
#[cfg(doctest)]
#[doc = include_str!("README.md")]
struct Readme;
