//! The eleven flights by name, and which of them may be trained on.

use dpn_core::config::{nearest, suggestion};
use dpn_core::{Side, named};
use serde::{Deserialize, Serialize};
use std::str::FromStr;
use thiserror::Error;

named!(
    /// A flight: its name is its character, its number its place.
    #[derive(PartialOrd, Ord, Serialize, Deserialize)]
    #[serde(rename_all = "kebab-case")]
    pub enum Flight {
        /// Slow straight lines through a hall.
        HallSlow = "f01-hall-slow",
        /// Slow circles in a hall.
        HallCalm = "f02-hall-calm",
        /// Fast lines and eights in a hall.
        HallFast = "f03-hall-fast",
        /// Brisk loops in a hall.
        HallLoops = "f04-hall-loops",
        /// Long lines in a hall, calm and fast by turns.
        HallLines = "f05-hall-lines",
        /// Slow and careful in a room.
        RoomSlow = "f06-room-slow",
        /// Medium speed in a room.
        RoomMedium = "f07-room-medium",
        /// Aggressive in a room, quick turns.
        RoomAggressive = "f08-room-aggressive",
        /// Hovering, with short moves in between.
        Hover = "f09-hover",
        /// Rising and sinking circles in a room, always turning.
        RoomSpiral = "f10-room-spiral",
        /// Aggressive eights in a room, quick turns.
        RoomWild = "f11-room-wild",
    }
);

/// A name no flight has.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[error("no flight is called `{given}`; known are {}{}", Flight::names(), meant(given))]
pub struct UnknownFlight {
    /// What was asked for.
    pub given: String,
}

fn meant(given: &str) -> String {
    let names = Flight::ALL.into_iter().flat_map(Flight::spellings);
    suggestion(nearest(given, names).and_then(|name| name.parse::<Flight>().ok()).map(Flight::name))
}

impl Flight {
    /// The full name, the name without its number, the number alone.
    fn spellings(self) -> [&'static str; 3] {
        [self.name(), &self.name()[4..], &self.name()[..3]]
    }

    /// Six to train on, five to test on, alternating in character as the paper's split of EuRoC does.
    pub fn split(self) -> Side {
        match self {
            Self::HallCalm | Self::HallLoops | Self::RoomSlow | Self::RoomAggressive | Self::RoomSpiral => {
                Side::Test
            }
            _ => Side::Train,
        }
    }
}

impl FromStr for Flight {
    type Err = UnknownFlight;

    /// The full name, the name without its number, or the number alone (`f07`).
    fn from_str(given: &str) -> Result<Self, UnknownFlight> {
        Self::ALL
            .into_iter()
            .find(|flight| flight.spellings().contains(&given))
            .ok_or_else(|| UnknownFlight { given: given.to_owned() })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn six_train_and_five_test_as_in_the_paper() {
        let train = Flight::ALL.iter().filter(|f| f.split() == Side::Train).count();
        assert_eq!((train, Flight::ALL.len() - train), (6, 5));
    }

    #[test]
    fn names_are_found_with_and_without_their_number() {
        for (i, flight) in Flight::ALL.into_iter().enumerate() {
            assert_eq!(flight.name()[1..3].parse::<usize>().unwrap(), i + 1);
            assert_eq!(flight.name().parse::<Flight>(), Ok(flight));
        }
        assert_eq!("hover".parse::<Flight>(), Ok(Flight::Hover));
        assert_eq!("f07".parse::<Flight>(), Ok(Flight::RoomMedium));
        let message = "hovr".parse::<Flight>().unwrap_err().to_string();
        assert!(message.starts_with("no flight is called `hovr`; known are f01-hall-slow, "));
        assert!(message.ends_with("f11-room-wild (did you mean `f09-hover`?)"), "{message}");
        for (given, end) in [
            ("f07-rom-medium", "(did you mean `f07-room-medium`?)"),
            ("f7", "(did you mean `f07-room-medium`?)"),
            ("a-cave-below-the-sea", ", f11-room-wild"),
        ] {
            let message = given.parse::<Flight>().unwrap_err().to_string();
            assert!(message.ends_with(end), "{message}");
        }
    }
}
