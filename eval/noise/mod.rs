//! Noise specs of the closed loop: one string names where the noise of every IMU sample comes from.
//!
//! To what [`dpn_core::estimate::NoiseSpec`] knows (constants, simple estimators) this adds:
//!
//! | spec | the noise of a sample |
//! |---|---|
//! | `dualpronet`, `dualpronet(TAG)`, `dualpronet(ACCEL,GYRO)` | what the networks say; tags are names of weight files, `sg5-s0` |
//! | `file("PATH")` | what a noise track on disk says; it must cover the IMU's samples |
//! | `oracle` | the deviation it was drawn with; simulated flights only |
//! | `shuffled(X)` | X's values, permuted in time in blocks of 1 s: the same values, not at their time |
//! | `mean(X)` | X's root mean square over the sequence, per axis: the same level, no change in time |
//! | `mean-of-train(X)` | X's root mean square over the training sequences, per axis: nothing of this sequence |
//! | `plus(X,C)` | root of the sum of squares of X's and a constant's: X for what was added, C for what is there in any case |
//!
//! Specs nest: `shuffled(dualpronet)`, `mean(x4,x1)`. `shuffled`, `mean` and `mean-of-train` are controls: they tell what of a gain is due to knowing *when*, what
//! to knowing *how much in this flight*, and what to a good constant.
//!
//! [`Noise`] is a spec parsed, [`Noise::track`] its noise on a recording; what is dear to make comes from [`Sources`], which may keep it.

mod controls;
mod error;
mod spec;
mod track;

pub use controls::{BLOCK_S, MeanSquare, shuffled};
pub use error::NoiseError;
pub use spec::{DEFAULT_TAG, Noise, parse_list};
pub use track::{Fresh, Recorded, Sources, of_recording};
pub(crate) use track::{network, raised};
