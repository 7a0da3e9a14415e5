//! What runs on the card. A workgroup takes one window after another through the whole network and back; its units meet at a barrier wherever one reads what another wrote.

mod conv;
pub(crate) mod draw;
mod norm;
pub(crate) mod pass;
pub(crate) mod tail;
pub(crate) mod update;
mod window;

use cubecl::prelude::*;

/// Leaky ReLU.
#[cube]
pub(crate) fn leaky(value: f32, #[comptime] leak: u32) -> f32 {
    let slope = comptime!(f32::from_bits(leak));
    select(value > 0.0, value, value * slope)
}

/// Its slope at `value`.
#[cube]
pub(crate) fn slope(value: f32, #[comptime] leak: u32) -> f32 {
    let below = comptime!(f32::from_bits(leak));
    select(value > 0.0, 1.0f32, below.runtime())
}

/// Adds to what this workgroup's windows before have given, or begins.
#[cube]
pub(crate) fn add(sums: &mut [f32], at: usize, value: f32, first: bool) {
    if first {
        sums[at] = value;
    } else {
        sums[at] += value;
    }
}
