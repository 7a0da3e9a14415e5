//! The front-end as a whole: against OpenCV, on a wall seen by a moving camera, and on images nobody wants.

mod bad_input;
mod golden;
mod real;
pub(crate) mod wall;
mod wall_tests;
