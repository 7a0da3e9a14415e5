//! What a ProNet is made of: a typed configuration whose every key changes numbers, and its checks.

mod choices;
mod network;

pub use choices::{BlockOrder, FirstKernels, Head, Input, NormAxes, Pool};
pub use network::ProNetConfig;
