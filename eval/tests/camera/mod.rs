//! What a camera's images are like to the front-end, for the comparison of rendered with real ones: the test of the hall, and `compare_cameras`, which prints the book's table.

#![allow(dead_code, unused_imports)]

mod figures;
mod lens_error;

pub(crate) use figures::{CameraFigures, matches};
pub(crate) use lens_error::lens_error;
