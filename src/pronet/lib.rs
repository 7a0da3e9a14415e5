//! Accel-ProNet and Gyro-ProNet: configuration, modules, weights, streaming inference.
#![cfg_attr(test, allow(clippy::unwrap_used))]

pub mod adam;
pub mod checkpoint;
pub mod config;
mod engine;
mod fused;
pub mod init;
pub mod model;
pub mod module;
pub mod predictor;
pub mod range;
pub mod shape;
pub mod store;
pub mod weights;

pub use adam::{Adam, AdamConfig};
pub use checkpoint::Checkpoint;
pub use config::ProNetConfig;
pub use model::DualProNet;
pub use module::ProNet;
pub use predictor::Predictor;
pub use store::StoreError;
pub use weights::{Card, Weights};
