//! Models in ONNX Runtime say what the networks say, by golden values. tract runs them in a workspace of its own (`golden/onnx/tract`).
#![allow(clippy::unwrap_used)]

mod golden;
mod windows;
