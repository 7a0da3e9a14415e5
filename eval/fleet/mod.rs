//! The fleet: noises on many platforms, each held against that platform's own best constant.
//!
//! A constant that suits one vehicle is wrong on the next, and nobody knows the right one beforehand. So a noise is scored by its error over that of the platform's
//! best constant, found by sweep on the very sequences that are judged: a score of 1 is as good as knowing it. Over platforms the geometric mean counts. The rival is
//! what a careful user could do: the single constant with the best score on all *other* platforms.
//!
//! 1. [`FleetPlan`]: the platforms, each an [`Experiment`](crate::closed_loop::Experiment), and the noises.
//! 2. [`FleetScore`]: the table; `dpn fleet` prints it.

mod plan;
mod score;

pub use plan::{FleetPlan, Platform};
pub use score::{FleetScore, NoiseOnPlatform, NoiseScore, PlatformScore};
