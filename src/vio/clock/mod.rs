//! The camera's clock against the IMU's: found from turns, before any structure is.
//!
//! ```text
//! samples -> gyro_course: the body's turn between any two instants ----.------------------.
//! two frames' tracks --------------------------------------------------+-> flow_turn -----+-> delay: what fits -> watch: what is in force
//!                                  the camera's turn, looked for near the gyroscope's, and how well it is known
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
pub(crate) use flow_turn::{FlowTurn, SharedRays};
pub(crate) use gyro_course::GyroCourse;
pub use readout::Readout;
pub(crate) use watch::SLIGHT_S;
pub use watch::{CameraClock, ClockWatch};
