//! What the vehicle is doing, known exactly at every instant.

use dpn_core::named;
use serde::{Deserialize, Serialize};

named!(
    /// One phase of a flight. Every flight runs through all seven, in this order.
    #[derive(PartialOrd, Ord, Serialize, Deserialize)]
    #[serde(rename_all = "kebab-case")]
    pub enum Phase {
        /// At rest, motors off, before the flight.
        RestBefore = "rest-before",
        /// Standing, motors running, before take-off.
        IdleBefore = "idle-before",
        /// From the first motion to the flight's first waypoint.
        TakeOff = "take-off",
        /// The flight proper.
        Flying = "flying",
        /// Coming down until the body stands.
        Landing = "landing",
        /// Standing, motors running, after landing.
        IdleAfter = "idle-after",
        /// At rest, motors off, after the flight.
        RestAfter = "rest-after",
    }
);

impl Phase {
    /// Whether the motors run.
    #[cfg(test)]
    pub(crate) fn motors_on(self) -> bool {
        !matches!(self, Self::RestBefore | Self::RestAfter)
    }

    /// Whether the body stands still on the ground.
    pub fn stands(self) -> bool {
        !matches!(self, Self::TakeOff | Self::Flying | Self::Landing)
    }
}

/// The instants at which a flight passes from one phase to the next \[s after its start\].
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Phases {
    ends: [f64; 7],
}

impl Phases {
    /// From the length of each phase \[s\], in the order of [`Phase::ALL`].
    pub(crate) fn from_lengths(lengths: [f64; 7]) -> Self {
        let mut end = 0.0;
        Self {
            ends: lengths.map(|length| {
                end += length;
                end
            }),
        }
    }

    /// Begin and end of `phase` \[s after the start\].
    pub(crate) fn span(&self, phase: Phase) -> (f64, f64) {
        let index = phase as usize;
        (if index == 0 { 0.0 } else { self.ends[index - 1] }, self.ends[index])
    }

    /// The phase in force `t` seconds after the start; a border belongs to the later one.
    pub(crate) fn at(&self, t: f64) -> Phase {
        let index = self.ends.iter().take_while(|&&end| t >= end).count();
        Phase::ALL[index.min(6)]
    }

    /// Length of the whole flight \[s\].
    pub fn duration(&self) -> f64 {
        self.ends[6]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_border_belongs_to_the_later_phase_and_the_ends_are_covered() {
        let phases = Phases::from_lengths([1.0, 2.0, 3.0, 4.0, 3.0, 2.0, 1.0]);
        assert_eq!(phases.at(-1.0), Phase::RestBefore);
        assert_eq!(phases.at(1.0), Phase::IdleBefore);
        assert_eq!(phases.at(2.999), Phase::IdleBefore);
        assert_eq!(phases.at(3.0), Phase::TakeOff);
        assert_eq!(phases.at(99.0), Phase::RestAfter);
        assert_eq!(phases.span(Phase::Flying), (6.0, 10.0));
        assert_eq!(phases.duration(), 16.0);
    }
}
