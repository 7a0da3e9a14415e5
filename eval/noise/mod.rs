//! Noise specs made into tracks: the deviation in force at every sample of a recording.
//!
//! [`track`] makes the track of a spec ([`dpn_core::estimate::NoiseSpec`]) on a recording; what is dear to make comes from [`Sources`], which may keep it. [`content`] says what a spec
//! is a function of, with checksums in place of paths.

mod content;
mod controls;
mod error;
mod track;

pub use content::content;
pub use controls::{BLOCK_S, MeanSquare, shuffled};
pub use error::NoiseError;
pub(crate) use track::AfterRun;
pub use track::{Fresh, Recorded, Sources, check_range, live, of_recording, track};
