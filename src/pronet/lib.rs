//! Accel-ProNet and Gyro-ProNet: configuration, modules, weights, streaming inference.
//!
//! A ProNet takes a window of one axis of one inertial sensor (200 samples, one second) and says the standard deviation of the white noise in
//! it: three blocks of convolution, layer normalisation and leaky ReLU, pooling over time, four linear layers
//! (VIO-DualProNet, arXiv 2308.11228). Every choice the paper leaves open is a key of [`ProNetConfig`].
//!
//! * [`Trainable`]: a loss and its gradient, by kernels of this crate; with the feature `burn` on any of its devices, of the network as a burn
//!   module (`ProNet`).
//! * [`Adam`], [`Checkpoint`]: the optimiser over the flat parameters, and a training's state in a file, to the bit.
//! * [`Weights`]: a trained network in a safetensors file that PyTorch reads by name.
//! * [`Predictor`], [`DualProNet`]: inference without burn, for windows at hand and for a stream of samples.
//!
//! On the processor, in training and in inference, the numbers come from kernels of this crate: one
//! pass a window, vectors by [`pulp`], the backward pass by hand. All parallel work is split by the batch's size alone and
//! summed in order, so that one thread and many give the same bits on one machine; machines with other vectors round differently.
//!
//! ```
//! use dpn_core::{Sensor, random::Stream};
//! use dpn_pronet::{Adam, AdamConfig, Card, Device, Predictor, ProNetConfig, Trainable, Weights, init::initial_parameters};
//!
//! let config = ProNetConfig { window: 20, channels: vec![4, 4, 4], ..ProNetConfig::for_sensor(Sensor::Gyro) };
//! let network = Trainable::new(&config, &Device::Cpu)?;
//! let mut parameters = initial_parameters(&config, &Stream::new(1).named("init"));
//! let windows = [[0.01; 20], [0.02; 20]].concat(); // [batch, window]
//! let target = [0.004, 0.008]; // [batch]
//!
//! // One step of training.
//! let (_loss, gradient) = network.gradient(&parameters, &windows, |sigma| {
//!     let error = [sigma[0] - target[0], sigma[1] - target[1]];
//!     (f64::from(error[0].powi(2) + error[1].powi(2)) / 2.0, error.to_vec())
//! });
//! let mut adam = Adam::new(AdamConfig::default(), parameters.len());
//! adam.step(&mut parameters, &gradient, 1e-3);
//!
//! // The trained network on three axes at once.
//! let weights = Weights::new(&config, parameters, Card::default());
//! let mut sigma = [0.0; 3];
//! Predictor::new(&weights).predict(&[0.01; 60], &mut sigma);
//! assert!(sigma.iter().all(|s| *s > 0.0));
//! # Ok::<(), dpn_core::config::ConfigFaults>(())
//! ```
#![cfg_attr(test, allow(clippy::unwrap_used))]

pub mod adam;
#[cfg(feature = "init")]
mod band_pass;
pub mod checkpoint;
pub mod config;
pub mod definition;
// Inference uses the forward half alone.
#[cfg_attr(not(feature = "train"), allow(dead_code))]
mod engine;
#[cfg(feature = "init")]
pub mod init;
pub mod model;
#[cfg(feature = "burn")]
mod module;
pub mod network;
#[cfg(feature = "burn")]
mod plain;
pub mod predictor;
mod processor;
pub mod range;
pub mod shape;
pub mod store;
pub mod stream;
#[cfg(feature = "train")]
mod trainable;
pub mod weights;

pub use adam::{Adam, AdamConfig};
pub use checkpoint::Checkpoint;
pub use config::ProNetConfig;
pub use model::DualProNet;
#[cfg(feature = "burn")]
pub use module::ProNet;
pub use predictor::Predictor;
pub use processor::processor;
pub use store::StoreError;
pub use stream::{Gate, SampleStream, StreamError, StreamSigma};
#[cfg(feature = "train")]
pub use trainable::{Device, Trainable};
pub use weights::{Card, Weights};

/// The crate's README, whose example is a test.
#[cfg(doctest)]
#[doc = include_str!("README.md")]
struct Readme;
