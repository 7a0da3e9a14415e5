//! Judging: the open loop, the closed loop, trajectories and their consistency, statistics, tables and figures; Allan plots of sensors
//! at rest; the noise along a log, and its health.
#![cfg_attr(test, allow(clippy::unwrap_used))]

pub mod allan;
pub mod closed_loop;
pub mod doctor;
pub mod figures;
pub mod injected;
pub mod log_noise;
pub mod metrics;
pub mod noise;
pub mod open_loop;
pub mod paper;
#[cfg(test)]
mod recordings;
pub mod stats;
pub mod table;
