//! Why a run cannot be what was asked for.

use dpn_sim::flight::UnknownFlight;
use thiserror::Error;

/// Why a run cannot be what was asked for. Arguments have the names of [`RunSource`](super::RunSource)'s fields, which are those of flags and of Python.
#[derive(Debug, Error)]
pub enum SourceError {
    /// A log with images, and another camera.
    #[error("{source_name} is a log with images: its camera is its own")]
    OwnCamera {
        /// The log.
        source_name: String,
    },
    /// A topic of what has none.
    #[error("`{argument}` is for logs with images; `{source_name}` is none")]
    Topic {
        /// Which one.
        argument: &'static str,
        /// What was named.
        source_name: String,
    },
    /// Tracks, and a camera that needs none.
    #[error("`tracks` and `camera` images or rendered ask for two things")]
    TwoCameras,
    /// Several seeds of what has none.
    #[error("given tracks have no seed, and `seeds` asks for several")]
    Unseeded,
    /// Neither a folder nor a flight.
    #[error("there is no folder `{source_name}`, and {unknown}")]
    Unknown {
        /// What was named.
        source_name: String,
        /// What the flights say.
        unknown: UnknownFlight,
    },
    /// A file that is no log with images.
    #[error("`{source_name}` holds no images, and no ground truth along which tracks could be made")]
    NoImages {
        /// The file.
        source_name: String,
    },
    /// Images of a flight.
    #[error("a flight has no folder of images")]
    FlightImages,
    /// Truth of a flight.
    #[error("`truth` is for a recording; a flight's ground truth is exact")]
    FlightTruth,
    /// Tracks of a flight.
    #[error("`tracks` is for a folder; a flight's tracks are made with it")]
    FlightTracks,
}

impl SourceError {
    /// What to do about it.
    pub fn hint(&self) -> &'static str {
        match self {
            Self::OwnCamera { .. } => "say `camera` images or nothing, and leave `tracks` away",
            Self::Unseeded => "leave `tracks` away, and tracks are made from the seed",
            Self::Topic { .. } => {
                "give a rosbag1, MCAP, rosbag2 or a folder with times.txt, or leave it away"
            }
            Self::TwoCameras => "leave one of them away",
            Self::Unknown { .. } => {
                "name a folder with an ASL sequence, or a flight of `dpn simulate flight --list`"
            }
            Self::NoImages { .. } => {
                "name a bag with images or a folder that they lie in; `dpn check` and `dpn noise` take a log of an IMU alone"
            }
            Self::FlightImages => "leave `camera` away, render some with `camera` rendered, or name a folder",
            Self::FlightTruth => "leave `truth` away",
            Self::FlightTracks => "write it with `dpn simulate flight` and name the folder",
        }
    }
}
