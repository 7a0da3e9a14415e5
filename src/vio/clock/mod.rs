//! The camera's clock against the IMU's: found from turns, before any structure is.
//!
//! ```text
//! two frames' tracks -> flow_turn: the camera's turn and how well it is known --.
//! samples -> gyro_course: the body's turn between any two instants -------------+-> delay: what fits -> watch: what is in force
//! ```
//!
//! Not here: the offset as an unknown of the window (`window.estimate_time_offset`), which needs structure and is of first order.

mod delay;
mod flow_turn;
mod gyro_course;
mod readout;
mod watch;

pub use delay::REACH_S;
pub(crate) use delay::{ALIKE_PAIRS, weight};
pub(crate) use flow_turn::FlowTurn;
pub(crate) use gyro_course::GyroCourse;
pub use readout::Readout;
pub(crate) use watch::SLIGHT_S;
pub use watch::{CameraClock, ClockWatch};
