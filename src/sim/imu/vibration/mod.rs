//! Rotor vibration: comes with the motors, drifts with thrust, is known exactly afterwards.
//!
//! Its parts are the rotors' tones (`rotors`), which the IMU samples too slowly, so that they are noise, and a line near 27 Hz and a
//! broad band, which are motion of the frame (`frame`), each on random streams of its own; the motors' speed is a
//! function of the trajectory (`motors`). `hover` has the tones without a flight.

mod config;
mod frame;
mod hover;
mod motors;
mod rotors;
mod sum;

pub use config::VibrationConfig;
pub(crate) use frame::shaking;
pub use hover::HoverTones;
pub(crate) use motors::motor_speed;
pub(crate) use sum::draw;
