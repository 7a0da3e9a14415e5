//! Rotor vibration: comes with the motors, drifts with thrust, is known exactly afterwards.
//!
//! Its parts are the rotors' tones ([`mod@self`]'s `rotors`), a line near 27 Hz and a broad band (`frame`), each
//! on random streams of its own; the motors' speed is a function of the trajectory (`motors`).

mod config;
mod frame;
mod motors;
mod rotors;
mod shaking;
mod sum;

pub use config::{AxisVibration, VibrationConfig};
pub(crate) use motors::motor_speed;
pub(crate) use sum::draw;
