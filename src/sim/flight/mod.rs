//! Eleven flights of different character, each a function of its name and a seed: at rest, motors on, take-off,
//! figures, landing, motors on, at rest.

mod character;
mod figures;
mod name;
mod phase;
mod plan;

pub use name::{Flight, UnknownFlight};
pub use phase::{Phase, Phases};
pub use plan::FlightPlan;
