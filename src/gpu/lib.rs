//! The networks of `dpn_pronet` learning on a GPU, by kernels in CubeCL over Vulkan, Metal and DirectX: forth and back in one workgroup a window, Adam over the flat
//! parameters, examples drawn on the card, trainings of one shape together in one launch.
//!
//! * `Gpu`: a card. `Training`: one network's steps and answers on it, from any thread.
//! * `Source`, `Examples`: what is learned from, given or drawn there.
//!
//! Numbers are the processor's but for rounding, and checkpoints go from one to the other; gradients are summed in a fixed order. Without the feature `wgpu` the crate is
//! empty.
#![cfg(feature = "wgpu")]
#![cfg_attr(test, allow(clippy::unwrap_used))]

mod card;
mod engine;
mod error;
mod kernels;
mod plan;
mod room;
mod source;
mod state;
#[cfg(test)]
mod tests;
mod training;

pub use card::Gpu;
pub use error::GpuError;
pub use kernels::draw::LevelDraw;
pub use kernels::tail::Loss;
pub use source::{Source, Turns};
pub use state::{Examples, State, Step};
pub use training::Training;
