//! Noise specs ([`dpn_core::estimate::NoiseSpec`]) made into the deviation in force at every sample, for whoever asks: a log, the odometry, a sweep.
//!
//! * [`Causal`]: a spec that needs the samples so far alone, resolved for samples of one rate; its [`Feed`] says the noise sample by sample.
//! * [`track`](track()): any spec on a whole recording. What is dear to make comes from [`Sources`], which may keep it.
//! * [`shuffled`], [`MeanSquare`]: the controls' arithmetic.
//! * [`content`](content()): what a spec is a function of, with checksums in place of paths.
//!
//! Networks count samples, not time: they see every k-th sample of a log of k times their rate, which leaves the deviation of a sample as it is,
//! as long as its noise is white; any other rate more than 5 % off is refused.
#![cfg_attr(test, allow(clippy::unwrap_used))]

mod blocks;
mod causal;
mod content;
mod controls;
mod error;
mod track;

pub use causal::{Causal, Feed, Judged};
pub use content::content;
pub use controls::{BLOCK_S, MeanSquare, shuffled};
pub use error::{CausalError, NoiseError};
pub use track::{AfterRun, Fresh, Recorded, Sources, check_range, live, of_recording, track};

/// The README's code is a test.
#[cfg(doctest)]
#[doc = include_str!("README.md")]
struct Readme;
