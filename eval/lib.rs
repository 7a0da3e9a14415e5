//! Judging: the open loop, its tables and figures.
#![cfg_attr(test, allow(clippy::unwrap_used))]

pub mod figures;
pub mod open_loop;
pub mod table;
