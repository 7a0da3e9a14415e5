//! Why the loop was not closed.

use super::sequence_fault::SequenceFault;
use super::sequence_name::meant;
use super::source_error::SourceError;
use crate::noise::NoiseError;
use crate::stats::StatsError;
use dpn_core::config::ConfigFault;
use dpn_io::calibration::CalibrationError;
use dpn_io::config::ConfigError;
use dpn_io::{IoError, LockError};
use dpn_logs::LogError;
use dpn_sim::SimulationError;
use std::path::PathBuf;
use thiserror::Error;

/// Why a closed loop cannot be run.
#[derive(Debug, Error)]
pub enum ClosedLoopError {
    /// Settings of the estimator out of their bounds.
    #[error("the estimator's settings: {}", .0.iter().map(ToString::to_string).collect::<Vec<_>>().join("; "))]
    Config(Vec<ConfigFault>),
    /// A file that cannot be read or written.
    #[error(transparent)]
    Io(#[from] IoError),
    /// A log that cannot be used.
    #[error(transparent)]
    Log(#[from] LogError),
    /// A file of settings.
    #[error(transparent)]
    Settings(#[from] ConfigError),
    /// A run that cannot be what was asked for.
    #[error(transparent)]
    Source(#[from] SourceError),
    /// A log with images, and nobody knows what camera took them.
    #[error("{}: no calibration of its camera: looked for sensor.yaml, cam0/sensor.yaml, mav0/cam0/sensor.yaml in its folder", path.display())]
    NoCalibration {
        /// The log.
        path: PathBuf,
    },
    /// A calibration that does not read.
    #[error(transparent)]
    Calibration(#[from] CalibrationError),
    /// The results' folder is another process's.
    #[error(transparent)]
    Locked(#[from] LockError),
    /// A noise spec that gives no noise here.
    #[error(transparent)]
    Noise(#[from] NoiseError),
    /// A simulated flight that cannot be.
    #[error(transparent)]
    Flight(#[from] SimulationError),
    /// A sequence that cannot be run.
    #[error("{sequence}: {source}")]
    Sequence {
        /// Its name.
        sequence: String,
        /// Why.
        source: SequenceFault,
    },
    /// Given tracks, and nobody knows what camera took them.
    #[error("{}: no cam0/sensor.yaml, so nobody knows what camera the tracks are from; put the camera's calibration there", dir.display())]
    NoCamera {
        /// Folder of the sequence.
        dir: PathBuf,
    },
    /// Tracks are to be made, and there is no ground truth to make them along.
    #[error("{}: no ground truth, along which camera tracks could be made; give tracks with --tracks", dir.display())]
    NoGroundTruth {
        /// Folder of the sequence.
        dir: PathBuf,
    },
    /// A name no sequence has.
    #[error("no sequence is called `{name}`; there are {}{}", known.join(", "), meant(name, known))]
    UnknownSequence {
        /// What was asked for.
        name: String,
        /// What there is.
        known: Vec<String>,
    },
    /// A name that begins several sequences' names.
    #[error("`{name}` may be any of {}; write more of it", found.join(", "))]
    AmbiguousSequence {
        /// What was asked for.
        name: String,
        /// What it may mean.
        found: Vec<String>,
    },
    /// Errors that cannot be compared.
    #[error("the noises cannot be compared: {0}")]
    Compare(#[from] StatsError),
    /// One name, several folders.
    #[error("there are two sequences called `{name}`: {} and {}; give --data one of them", first.display(), second.display())]
    SameName {
        /// The name.
        name: String,
        /// One folder.
        first: PathBuf,
        /// Another one.
        second: PathBuf,
    },
    /// The run's folder holds results of something else.
    #[error("{} holds a run with another {key}: {there} there, {here} now", dir.display())]
    OtherRun {
        /// The folder.
        dir: PathBuf,
        /// What differs.
        key: String,
        /// In the folder.
        there: String,
        /// Asked for.
        here: String,
    },
    /// A line of the results that is none.
    #[error("{}:{line}: not a row of results: {message}", path.display())]
    BadRow {
        /// The file.
        path: PathBuf,
        /// Line, from 1.
        line: usize,
        /// What is wrong.
        message: String,
    },
    /// Stopped from outside; what is finished is kept.
    #[error("stopped after {done} of {total} cells")]
    Stopped {
        /// Cells whose results are on disk.
        done: usize,
        /// Cells in all.
        total: usize,
    },
}

impl ClosedLoopError {
    /// What is wrong and what it comes from, in one line.
    pub fn in_full(&self) -> String {
        dpn_io::in_full(self)
    }

    /// What to do about it, where the message does not say it.
    pub fn hint(&self) -> Option<String> {
        match self {
            Self::Io(error) => error.hint(),
            Self::Log(error) => error.hint(),
            Self::Settings(error) => error.hint(),
            Self::Source(error) => Some(error.hint().into()),
            Self::Calibration(error) => error.hint(),
            Self::NoCalibration { .. } => {
                Some("name it with --calib, or put a cam0/sensor.yaml as EuRoC's beside the log".into())
            }
            Self::Locked(error) => error.hint(),
            Self::Noise(error) => error.hint(),
            Self::OtherRun { .. } => Some("give another folder with --out, or remove this one".into()),
            Self::BadRow { .. } => Some("remove the line; its cell is run again".into()),
            Self::Sequence { source, .. } => source.hint(),
            Self::Stopped { .. } => Some("the same command goes on where it stopped".into()),
            _ => None,
        }
    }
}

impl SequenceFault {
    /// The same of the sequence with this name.
    pub fn of(self, sequence: impl Into<String>) -> ClosedLoopError {
        ClosedLoopError::Sequence { sequence: sequence.into(), source: self }
    }
}

/// A result whose fault is a sequence's.
pub(crate) trait OfSequence<T> {
    /// The same with the sequence's name.
    ///
    /// # Errors
    /// The fault, with the name.
    fn of_sequence(self, sequence: &str) -> Result<T, ClosedLoopError>;
}

impl<T, E: Into<SequenceFault>> OfSequence<T> for Result<T, E> {
    fn of_sequence(self, sequence: &str) -> Result<T, ClosedLoopError> {
        self.map_err(|fault| fault.into().of(sequence))
    }
}
