//! The sliding window: ten key frames and the newest, what was measured between them, and a prior for what has left.
//!
//! One frame goes through `Window::add_frame`, `Window::optimise`, `Window::reject_outliers` and `Window::slide`.
//! The initialisation adjusts in windows of its own, from which nothing leaves: `Window::settle`, `Window::covariance`.
//! [`layout`] says where each unknown stands, [`normal`] solves, `linearise` gathers the measurements, `schur` takes the
//! landmarks out, `elimination` any other unknown, `marginalise` makes the prior of what leaves.

mod config;
mod elimination;
mod frame;
mod jump;
mod landmark;
mod landmark_terms;
pub mod layout;
mod linearisation;
mod linearise;
mod marginalise;
pub mod normal;
mod parallax;
mod part;
mod points;
mod prior;
mod row_sums;
mod scale;
mod schur;
mod slide;
mod solve;
#[cfg(test)]
pub(crate) mod tests;
#[allow(clippy::module_inception)]
mod window;

pub use config::{Handover, WindowConfig};
pub use frame::{Frame, Seen, Standstill};
pub use landmark::Landmark;
pub(crate) use landmark::MIN_INVERSE_DEPTH;
pub use slide::Leaving;
pub use solve::{Solved, Stop};
pub use window::Window;
