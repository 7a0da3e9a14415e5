//! A published ground truth reconciled with the IMU beside it: one smooth motion that both agree with as far as each is to be believed.
//!
//! 1. `align`: how late the published poses are, how their body is mounted and where up is, roughly, from absolute rates, rates and gravity.
//! 2. `start`: keys every .1 s along the samples. Between two of them the samples are pre-integrated (`dpn_vio::preint`): in a sum over an interval an
//!    oscillation of the rotors is lost.
//! 3. `problem`, `published`: least squares over poses, velocities and biases of all keys, the published poses' slow errors, and constants: delay, mount, lever,
//!    tilt, blur. The poses beside a key count as one, their mean; a far one pulls less (Huber).
//! 4. `components`: between the steps the levels of all noises, by their variance components; the IMU's are bounded by what its spectrum
//!    allows (`ceiling`). No weight is set by hand.
//! 5. `reconcile`: constants that chance explains are held at zero. Poses that do not belong to the rest are left out (`screen`).
//! 6. `dense`, `report`: states at every sample where their covariance is small enough, and what was found.
//!
//! [`against`] goes on from 5: the IMU's levels axis by axis, scale and misalignment (`intrinsics`), for a trajectory in metres (`metric`).
//!
//! Published poses keep their weight: above the corner of their errors the motion is the IMU's, below it theirs. No files here.

#![cfg_attr(test, allow(clippy::unwrap_used))]

mod adjust;
mod against;
mod align;
mod ceiling;
mod chain;
mod clock;
mod components;
mod config;
mod dense;
mod error;
mod intrinsics;
mod layout;
mod metric;
mod near;
mod problem;
mod published;
mod reconcile;
mod report;
mod screen;
mod start;

pub use against::{Against, BiasAt, Found, Known, SensorAgainst, against};
pub use align::interpolated;
pub use clock::WindowDelay;
pub use components::Levels;
pub use config::TruthConfig;
pub use error::TruthError;
pub use reconcile::{Reconciled, reconcile};
pub use report::{Estimated, HeldOut, Report, Span, Trust};

/// The README's code is a test.
#[cfg(doctest)]
#[doc = include_str!("README.md")]
struct Readme;
