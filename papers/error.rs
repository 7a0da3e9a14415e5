//! Why the paper could not be made.

use dpn_core::estimate::SpecError;
use dpn_eval::closed_loop::ClosedLoopError;
use dpn_eval::noise::NoiseError;
use dpn_eval::open_loop::OpenLoopError;
use dpn_eval::stats::StatsError;
use dpn_figures::FigureError;
use dpn_io::{IoError, LockError};
use dpn_pronet::StoreError;
use dpn_train::base::UnknownBase;
use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, Ordering};
use thiserror::Error;

/// Why a stage could not be finished. What earlier stages left stays, and the same command goes on from there.
#[derive(Debug, Error)]
pub enum PaperError {
    /// A closed loop, injected or not.
    #[error(transparent)]
    ClosedLoop(#[from] ClosedLoopError),
    /// A configuration that a plan names.
    #[error(transparent)]
    Config(#[from] dpn_io::config::ConfigError),
    /// Stopped from outside, between two steps of a stage; what is finished is kept.
    #[error("stopped")]
    Stopped,
    /// The open loop.
    #[error(transparent)]
    OpenLoop(#[from] OpenLoopError),
    /// A figure.
    #[error(transparent)]
    Figure(#[from] FigureError),
    /// A noise of the plan.
    #[error(transparent)]
    Noise(#[from] NoiseError),
    /// A noise of the plan that is no spec.
    #[error("the plan: {0}")]
    Spec(#[from] SpecError),
    /// A base of the plan that is none.
    #[error("the plan: {0}")]
    Base(#[from] UnknownBase),
    /// Figures that cannot be tested.
    #[error(transparent)]
    Stats(#[from] StatsError),
    /// A network.
    #[error(transparent)]
    Network(#[from] StoreError),
    /// A file.
    #[error(transparent)]
    Io(#[from] IoError),
    /// A folder that another process writes to.
    #[error(transparent)]
    Locked(#[from] LockError),
    /// A file of an earlier run that does not read.
    #[error("{}: {message}; remove it, and it is made again", path.display())]
    Stale {
        /// The file.
        path: PathBuf,
        /// What is wrong with it.
        message: String,
    },
    /// Another program's runs are to be taken, and it has not made them all.
    #[error("{what}: not there as made by {program}")]
    NotMeasured {
        /// What is missing.
        what: String,
        /// The program.
        program: String,
    },
    /// No sequence at all can be used.
    #[error("no sequence can be used: {}", reasons.join("; "))]
    Nothing {
        /// Why, one a sequence.
        reasons: Vec<String>,
    },
    /// A camera that no sequence has.
    #[error("--camera {camera}: {reason}")]
    NoCamera {
        /// What was asked for.
        camera: String,
        /// Why not.
        reason: String,
    },
}

/// An error where a stop was asked for.
pub(super) fn stopped(stop: &AtomicBool) -> Result<(), PaperError> {
    if stop.load(Ordering::Relaxed) { Err(PaperError::Stopped) } else { Ok(()) }
}

impl PaperError {
    /// Whether it is no fault but a stop that was asked for.
    pub fn is_stop(&self) -> bool {
        matches!(
            self,
            Self::Stopped
                | Self::ClosedLoop(ClosedLoopError::Stopped { .. })
                | Self::OpenLoop(OpenLoopError::Stopped { .. })
        )
    }

    /// What to do about it, where the message does not say it.
    pub fn hint(&self) -> Option<String> {
        match self {
            Self::ClosedLoop(error) => error.hint(),
            Self::Io(error) => error.hint(),
            Self::Config(error) => error.hint(),
            Self::Locked(error) => error.hint(),
            Self::NoCamera { .. } => Some("--camera auto takes the best that every sequence has".into()),
            Self::NotMeasured { .. } => Some(
                "give --measured-by the checksum that tables and run.json name, with the plan, data and settings of that run; or leave it out, and it is run"
                    .into(),
            ),
            Self::Nothing { .. } => Some(
                "give --data a folder with EuRoC's sequences, or leave it out for the simulated flights"
                    .into(),
            ),
            _ => None,
        }
    }
}
