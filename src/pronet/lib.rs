//! Accel-ProNet and Gyro-ProNet: configuration, modules, weights, streaming inference.
#![cfg_attr(test, allow(clippy::unwrap_used))]

pub mod config;
mod engine;
mod fused;
pub mod init;
pub mod module;
pub mod shape;

pub use config::ProNetConfig;
pub use module::ProNet;
