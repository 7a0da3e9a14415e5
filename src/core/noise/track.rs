//! A model's output over a recording.

use super::{ImuNoise, NoiseModel};
use crate::imu::ImuRecording;
use crate::time::Stamp;
use thiserror::Error;

/// Why two series are not a noise track.
#[derive(Debug, Error, PartialEq)]
pub enum TrackError {
    /// As many stamps as noises are needed.
    #[error("{stamps} stamps but {noises} noise values")]
    Lengths {
        /// Number of stamps.
        stamps: usize,
        /// Number of noises.
        noises: usize,
    },
    /// Stamps that stand still or go back.
    #[error("stamps do not increase at entry {index}")]
    TimeNotIncreasing {
        /// Index of the offending entry.
        index: usize,
    },
}

/// The noise in force at each stamp, on the samples' own stamps, increasing.
#[derive(Debug, Clone, PartialEq)]
pub struct NoiseTrack {
    stamps: Vec<Stamp>,
    noises: Vec<ImuNoise>,
}

impl NoiseTrack {
    /// Pairs stamps with noises.
    ///
    /// # Errors
    /// Different lengths; stamps that do not increase.
    pub fn new(stamps: Vec<Stamp>, noises: Vec<ImuNoise>) -> Result<Self, TrackError> {
        if stamps.len() != noises.len() {
            return Err(TrackError::Lengths { stamps: stamps.len(), noises: noises.len() });
        }
        match stamps.windows(2).position(|w| w[0] >= w[1]) {
            Some(before) => Err(TrackError::TimeNotIncreasing { index: before + 1 }),
            None => Ok(Self { stamps, noises }),
        }
    }

    /// Feeds the whole recording to `model`, which is reset first.
    pub fn of(model: &mut dyn NoiseModel, recording: &ImuRecording) -> Self {
        model.reset();
        Self {
            stamps: recording.samples().iter().map(|s| s.t).collect(),
            noises: recording.samples().iter().map(|s| model.feed(s)).collect(),
        }
    }

    /// The same stamps with other noises.
    ///
    /// # Panics
    /// When there are not as many noises as stamps.
    #[must_use]
    pub fn with_noises(&self, noises: Vec<ImuNoise>) -> Self {
        assert_eq!(noises.len(), self.stamps.len(), "a noise for every stamp");
        Self { stamps: self.stamps.clone(), noises }
    }

    /// The stamps, increasing.
    pub fn stamps(&self) -> &[Stamp] {
        &self.stamps
    }

    /// The noise at each stamp.
    pub fn noises(&self) -> &[ImuNoise] {
        &self.noises
    }
}
