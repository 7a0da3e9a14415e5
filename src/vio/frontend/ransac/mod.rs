//! Which tracks agree on one motion of the camera.
//!
//! Two bearings of a point that stands still lie in a plane with the camera's path: `cur^T E prev = 0` for `E = hat(t) R`, with
//! `R = cur_from_prev` and `t` the earlier camera's place in the later one's frame. A track that does not is taken out. Its distance
//! is Sampson's, as an angle: `|cur^T E prev| / sqrt(|E prev|^2 + |E^T cur|^2)`.
//!
//! * [`Geometry::TwoPoint`]: the gyroscope says `R`; two tracks give `t` (Kneip, Chli and Siegwart 2011). A few trials suffice. Tracks that
//!   go the wrong way along their plane are taken out too.
//! * [`Geometry::Fundamental`]: seven tracks give a matrix without the condition that it be a rotation's, refitted to all that agree by
//!   the eight-point method, both on whitened coordinates (Hartley 1997). This is the paper's, and needs no gyroscope.
//!
//! The number of trials adapts to the share of tracks that agree (Fischler and Bolles 1981); trials are scored by truncated squares
//! (Torr and Zisserman 2000). Chance is a named stream's.

mod config;
mod consensus;
mod fundamental;
mod pair;
mod seven;
mod two_point;

pub use config::{Geometry, RansacConfig};
pub(crate) use consensus::DOUBT_SHARE;
pub use consensus::{Consensus, agree};
pub use pair::Pair;
