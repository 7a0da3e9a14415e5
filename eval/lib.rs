//! Judging: the open loop, its tables and figures; Allan plots of sensors at rest; the health of a log.
#![cfg_attr(test, allow(clippy::unwrap_used))]

pub mod allan;
pub mod doctor;
pub mod figures;
pub mod open_loop;
pub mod table;
