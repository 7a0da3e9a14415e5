//! Bundle adjustment over a handful of frames, with or without the IMU: unknowns, residuals, solver and what is known afterwards.
//!
//! ```text
//! unknowns   a frame each: pose 6 (position, rotation on the right), with the IMU also velocity 3; one bias 6; a point each: 3
//! cost       sum rho(|r_track|^2 / s^2) + sum |L^-1 r_imu|^2 + sum |r_prior / s|^2      all over 2, rho Cauchy's
//! ```
//! The points are eliminated by Schur complement, what remains (at most some hundred unknowns) is dense. Levenberg-Marquardt,
//! budgets in steps. One bias serves all frames: over the few seconds of an initialisation its walk is far below its uncertainty.

mod covariance;
mod inertial;
mod landmark;
mod prior;
mod problem;
mod solve;

pub(super) use covariance::Covariance;
pub(super) use inertial::InertialFactor;
pub(super) use landmark::{Camera, Landmark};
pub(super) use prior::Prior;
pub(super) use problem::{Bundle, BundleState, Layout};
