//! Models in ONNX Runtime say what the networks say, by golden values: shipped networks, some of the study, every choice of a configuration.
#![allow(clippy::unwrap_used)]

mod golden;
mod models;
mod windows;
