//! Degraded ground truth of simulated flights comes back, and what cannot be mended is said and left out.
#![allow(clippy::unwrap_used)]

mod against;
mod bad_input;
mod configs;
mod degrade;
mod degraded;
