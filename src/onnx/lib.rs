//! Trained networks as ONNX models, so that estimators with another runtime can ask them.
//!
//! A model is a whole: windows go in as the sensor gives them, deviations come out in the same unit, scales and means are part of the graph. What has to be
//! known besides (sensor, rate, unit, range of training, where it comes from) stands in the model's metadata, text each.
//!
//! ```
//! use dpn_pronet::{ProNetConfig, Weights, Card};
//! # let config = ProNetConfig::default();
//! # let weights = Weights::new(&config, vec![0.0; dpn_pronet::shape::parameter_count(&config)], Card::default());
//! let bytes = dpn_onnx::to_bytes(&weights)?; // input `window` [batch, 200], output `sigma` [batch]
//! assert!(bytes.len() < 400_000);
//! # Ok::<(), dpn_pronet::StoreError>(())
//! ```
#![cfg_attr(test, allow(clippy::unwrap_used))]

mod convolutions;
mod graph;
mod metadata;
mod network;
mod proto;

pub use convolutions::{Convolution, Convolutions, Metadata};
use dpn_pronet::{StoreError, Weights};
use prost::Message;
use proto::{GraphProto, ModelProto, OperatorSetIdProto, StringStringEntryProto};

/// The version of the operators that are used: the oldest in which every one takes its axes as it is given them here, so that many runtimes know it.
const OPERATORS: i64 = 13;
/// The version of the file's layout, of ONNX 1.8: the first with those operators.
const LAYOUT: i64 = 7;

/// The bytes of a network's model: the same weights are the same bytes.
///
/// # Shapes
/// Of the model: input `window`, `f32` `[batch, window]`; output `sigma`, `f32` `[batch]`, and `log_spread`, `f32` `[batch]`, of a network that says
/// how sure it is.
///
/// # Units and frames
/// Of the model: samples of one axis and their deviation, both in m/s^2 or rad/s, which its metadata say.
///
/// # Errors
/// A training summary that cannot be written as JSON.
pub fn to_bytes(weights: &Weights) -> Result<Vec<u8>, StoreError> {
    Ok(model(network::graph(weights), metadata::summary(weights), metadata::entries(weights)?))
}

fn model(graph: GraphProto, summary: String, metadata: Vec<StringStringEntryProto>) -> Vec<u8> {
    let model = ModelProto {
        ir_version: Some(LAYOUT),
        producer_name: Some("dpn".to_owned()),
        producer_version: Some(env!("CARGO_PKG_VERSION").to_owned()),
        doc_string: Some(summary),
        graph: Some(graph),
        opset_import: vec![OperatorSetIdProto { domain: Some(String::new()), version: Some(OPERATORS) }],
        metadata_props: metadata,
    };
    model.encode_to_vec()
}

/// The README's code is a test.
#[cfg(doctest)]
#[doc = include_str!("README.md")]
struct Readme;
