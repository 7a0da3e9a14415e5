//! The length of what a network sees.

/// Samples in a window: one second of EuRoC (the paper).
pub const WINDOW: usize = 200;
