//! Learned corrections of a gyroscope against a trajectory, their simple rivals, and what their errors are worth.
//!
//! 1. `course`: a recording with the true rotation at its samples; what a truth must be to score anything.
//! 2. `affine`: one matrix and one bias, by robust least squares, with intervals: the simple rival, and what a network starts from.
//! 3. `network`: a causal convolution over 2.5 s of six axes (at 200 Hz) that says what is to be added to the rate; forth and back.
//! 4. `loss`: Huber's on products of increments over spans of samples, as a tree.
//! 5. `training`, `model`: from courses and a configuration to a file; `running`: asked beside running samples; `onnx`: for other runtimes.
//! 6. `gravity`: the bias that gravity tells beside it, where a body stays slow; `choice`: whether that helps, by leaving out recordings.
//! 7. `score`, `spans`: the field's figures by the names of who defined them, and the likelihood of what is said of the errors.
//!
//! Rotations are `world_from_body`; rates are of the body, in its frame \[rad/s\]. No files here.

#![cfg_attr(test, allow(clippy::unwrap_used))]

mod affine;
mod choice;
mod config;
mod course;
mod gravity;
mod loss;
mod model;
mod network;
mod onnx;
mod running;
mod score;
mod spans;
mod training;

pub use affine::{Affine, Fitted, Unknown, fit};
pub use choice::chosen_speed;
pub use config::InertialConfig;
pub use course::{Course, CourseError};
pub use model::Model;
pub use running::{Correction, Running};
pub use score::{Score, SlowBias, Source, TURNS_S, Turn, sources};
pub use spans::{Levels, Residuals, SPANS_S, Said, SpanScore};
pub use training::{Training, TrainingError, same_rate};
