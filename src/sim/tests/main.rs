//! Simulated tracks against laws and against the given ones.
#![allow(clippy::unwrap_used)]

mod given_tracks;
mod low_frequencies;
mod reprojection;
mod summary;
mod tracks;
