//! Degraded ground truth of simulated flights comes back, and what cannot be mended is said and left out.
#![allow(clippy::unwrap_used)]

mod bad_input;
mod degrade;
mod degraded;
