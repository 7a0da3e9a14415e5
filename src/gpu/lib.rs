//! The networks' training on a GPU: forth, back, optimiser, by kernels of this crate in CubeCL, many networks at once.
#![cfg(feature = "wgpu")]
#![cfg_attr(test, allow(clippy::unwrap_used))]

mod card;
mod engine;
mod kernels;
mod plan;
mod room;
mod source;
#[cfg(test)]
mod tests;
mod training;

pub use card::{Gpu, GpuError};
pub use kernels::draw::LevelDraw;
pub use source::{Source, Turns};
pub use training::{Examples, Loss, State, Step, Training};
