//! What is judged on recordings, in one executable.

#![allow(clippy::unwrap_used)]

mod ate_of_peers;
mod camera;
mod faults;
mod real_motion;
mod rendered_hall;
