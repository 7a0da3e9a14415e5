//! The length of what a network sees.

/// Samples in a window at the paper's rate: one second of EuRoC.
pub const WINDOW: usize = 200;
