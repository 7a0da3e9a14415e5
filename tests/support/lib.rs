//! What the tests of several crates share. It knows no crate of this workspace, so that every one of them can use it.
//!
//! * [`pack`]: one of the unpacked data packs; tests that need it are skipped, loudly, where it is not there.
//! * [`golden`]: expected values by other people's programs, `golden/NAME/golden.json`.
//! * [`files()`]: everything in a folder, to be compared byte by byte; [`cut_asl`]: a part of a recording.
//! * [`written_out()`]: a configuration file that says every key of its type.
//! * [`forged`]: files that nobody should have to read.
//! * [`SensorFaults`]: what happens to the messages of running sensors.
//! * [`check_jacobian`]: a derivative against central differences.
#![allow(clippy::unwrap_used)]

mod configs;
mod data;
mod files;
pub mod forged;
mod golden;
mod jacobian;
mod sensors;

pub use configs::written_out;
pub use data::{pack, packs, repository};
pub use files::{cut_asl, files};
pub use golden::golden;
pub use jacobian::check_jacobian;
pub use sensors::{Disturbed, SensorFaults};
