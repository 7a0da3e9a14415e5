//! A published ground truth reconciled with the IMU beside it: one smooth motion that both agree with as far as each is to be believed.
#![cfg_attr(test, allow(clippy::unwrap_used))]

mod adjust;
mod align;
mod chain;
mod components;
mod config;
mod dense;
mod error;
mod layout;
mod near;
mod problem;
mod published;
mod reconcile;
mod report;
mod screen;
mod start;

pub use components::Levels;
pub use config::TruthConfig;
pub use error::TruthError;
pub use reconcile::{Reconciled, reconcile};
pub use report::{Estimated, HeldOut, Report, Span, Trust};
