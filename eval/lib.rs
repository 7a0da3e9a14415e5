//! Judging: the open loop, the closed loop, trajectories and their consistency, statistics, tables and figures.
#![cfg_attr(test, allow(clippy::unwrap_used))]

pub mod closed_loop;
pub mod figures;
pub mod metrics;
pub mod noise;
pub mod open_loop;
pub mod stats;
pub mod table;
