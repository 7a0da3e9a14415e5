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

/// An image is taken at a size whose longer side has at least so many pixels, and less than twice as many.
const FEWEST_COLUMNS: usize = 640;

/// By how much images of `size` (width, height \[px\]) are best [reduced](dpn_core::GrayImage::reduced) before points are followed in them.
///
/// A pixel of a camera with many is small and noisy, a hand's motion is blurred over several of them, and a window of the same number of pixels sees less of the
/// world: tracks of a hand-held 1280 x 720 lived 2.6 frames, of the same images at half that size 5.9.
pub fn reduction(size: [usize; 2]) -> usize {
    (size[0].max(size[1]) / FEWEST_COLUMNS).max(1)
}

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

pub use config::FrontEndConfig;
pub use front_end::{Fed, FrontEnd};
pub(crate) use gyro_turn::GyroTurn;
pub(crate) use line_turns::{LineTurns, line_delay};
pub(crate) use predict::turn_of_camera;
pub use report::{Agreement, FrameReport, Lost, LostBy, StageTimes, Status};
pub(crate) use two_view::TwoView;
