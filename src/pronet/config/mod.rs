//! What a ProNet is made of: a typed configuration whose every key changes numbers, and its checks.

mod choices;
mod fault;
mod network;

pub use choices::{BlockOrder, Edges, FirstKernels, Head, Input, NormAxes, Pool, Standardise};
pub use fault::{ConfigError, Fault};
pub use network::ProNetConfig;
