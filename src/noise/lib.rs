//! Noise specs ([`dpn_core::estimate::NoiseSpec`]) made into the deviation in force at every sample, for whoever asks: a log, the odometry, a sweep.
//!
//! * [`Causal`]: a spec that needs the samples so far alone, resolved for samples of one rate; its [`Feed`] says the noise sample by sample.
//! * [`track`](track()): any spec on a whole recording. What is dear to make comes from [`Sources`], which may keep it.
//! * [`doubts`], [`Feed::doubts`]: what the spectrum has against what is said.
//! * [`shuffled`], [`MeanSquare`]: the controls' arithmetic.
//! * [`content`](content()): what a spec is a function of, with checksums in place of paths.
//!
//! Networks count samples, not time. Of those of one name that were trained at several rates the fastest that the log reaches is asked, and sees means over
//! blocks of a faster log ([`dpn_core::signal::Blocks`]); a log slower than all of them is refused.
#![cfg_attr(test, allow(clippy::unwrap_used))]

mod causal;
mod content;
mod controls;
mod error;
mod track;

pub use causal::{Causal, Feed, Judged};
pub use content::content;
pub use controls::{BLOCK_S, MeanSquare, shuffled};
pub use error::{CausalError, NoiseError};
pub use track::{AfterRun, Fresh, Recorded, Sources, check_range, doubts, live, of_recording, track};

/// The README's code is a test.
#[cfg(doctest)]
#[doc = include_str!("README.md")]
struct Readme;
