//! Why input is not taken.

use dpn_core::Stamp;
use dpn_core::imu::Sensor;
use thiserror::Error;

/// Input that cannot be taken.
#[derive(Debug, Error, Clone, Copy, PartialEq)]
pub enum FeedError {
    /// A sample that is not later than the last.
    #[error("an IMU sample at {t} after one at {last}; samples must come in increasing time")]
    SampleOutOfOrder {
        /// Its stamp.
        t: Stamp,
        /// The newest before it.
        last: Stamp,
    },
    /// A frame that is not later than the last.
    #[error("a frame at {t} after one at {last}; frames must come in increasing time")]
    FrameOutOfOrder {
        /// Its stamp.
        t: Stamp,
        /// The newest before it.
        last: Stamp,
    },
    /// An image that is not later than the last.
    #[error("an image at {t} after one at {last}; images must come in increasing time")]
    ImageOutOfOrder {
        /// Its stamp.
        t: Stamp,
        /// The newest before it.
        last: Stamp,
    },
    /// An image of another size than the camera's.
    #[error(
        "an image of {} x {} px at {t}; the camera's calibration is for {} x {}",
        found[0], found[1], camera[0], camera[1]
    )]
    ImageSize {
        /// Its stamp.
        t: Stamp,
        /// Its width and height \[px\].
        found: [usize; 2],
        /// The camera's.
        camera: [usize; 2],
    },
    /// Too many images wait for samples.
    #[error(
        "an image at {t} while {waiting} wait for samples since {first}; is the IMU silent, or its clock another?"
    )]
    ImuBehind {
        /// Its stamp.
        t: Stamp,
        /// The first that waits.
        first: Stamp,
        /// How many wait.
        waiting: usize,
    },
    /// A sample that is not a number.
    #[error("an IMU sample at {t} holds a value that is not finite")]
    NotFinite {
        /// Its stamp.
        t: Stamp,
    },
    /// A reading that no sensor gives, alone or with two more at most.
    #[error("an IMU sample at {t} reads {reading} {}, more than any {sensor} measures", sensor.unit())]
    Spike {
        /// Its stamp.
        t: Stamp,
        /// Which sensor.
        sensor: Sensor,
        /// One of its axes, in the sensor's unit.
        reading: f64,
    },
}
