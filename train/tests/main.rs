//! A training from outside: its configurations, and that it resumes.
#![allow(clippy::unwrap_used)]

mod configs;
#[cfg(feature = "wgpu")]
mod gpu;
mod resume;
