//! From images to tracks: the visual front-end.
//!
//! ```text
//! image -> figures -> pyramid -> tracked from the last image, from where the gyroscope says, and back
//!                                  |  every so often (`rate_hz`)
//!                                  v
//!        consensus with the last frame handed over -> thinned out -> new corners -> TrackFrame
//! ```
//!
//! Where the gyroscope says is its turn less a bias that the tracks have shown (`gyro_bias`): nobody has told it yet.
//! Every image is tracked, so that windows move little; a frame is handed over at a chosen rate. A frame's tracks are distorted pixels
//! under numbers that are never used twice. What an image was like and what became of each track is in its [`FrameReport`].
//!
//! Knows no files: images are borrowed bytes. The kernels ([`image`], [`klt`], [`corners`]) are loops over whole vectors in safe code,
//! compiled for the machine's vector units by `pulp` and chosen at run time; each sum is taken in one order, so that every machine
//! gets the same tracks. Parameters and their defaults are VINS-Mono's where the paper says nothing. Not here: loop closure, relocation,
//! stereo, a camera's own calibration.

mod config;
pub mod corners;
mod front_end;
mod gyro_bias;
mod gyro_turn;
pub mod image;
pub mod klt;
mod line_turns;
mod predict;
pub mod ransac;
mod report;
mod schedule;
#[cfg(test)]
pub(crate) mod tests;
pub(crate) mod two_view;
mod working_size;

pub use config::FrontEndConfig;
pub use front_end::{Fed, FrontEnd};
pub(crate) use gyro_turn::GyroTurn;
pub(crate) use line_turns::{LineTurns, line_delay};
pub(crate) use predict::turn_of_camera;
pub use report::{Agreement, FrameReport, Lost, LostBy, StageTimes, Status};
pub(crate) use two_view::TwoView;
pub use working_size::{camera_at_working_size, image_at_working_size};
