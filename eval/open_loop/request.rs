//! What an open loop is asked for, and what comes of it.

use dpn_core::Sensor;
use dpn_core::estimate::EstimatorError;
use dpn_core::signal::FilterError;
use dpn_io::IoError;
use dpn_pronet::StoreError;
use dpn_pronet::network::Network;
use dpn_train::base::Base;
use dpn_train::corpus::Corpus;
use dpn_train::features::FeatureError;
use dpn_train::regress::RegressError;
use thiserror::Error;

/// What to judge, and by what.
pub struct Request<'a> {
    /// Recordings.
    pub corpora: &'a [Corpus],
    /// Sensors.
    pub sensors: &'a [Sensor],
    /// Bases of collections that are not raw.
    pub bases: &'a [Base],
    /// Trained networks.
    pub networks: &'a [Network],
    /// Seed of the injected noise.
    pub seed: u64,
    /// Version and checksum of the program.
    pub program: &'a str,
}

/// Why the open loop cannot be run.
#[derive(Debug, Error)]
pub enum OpenLoopError {
    /// A base's filter cannot be.
    #[error(transparent)]
    Filter(#[from] FilterError),
    /// A simple estimator cannot be.
    #[error(transparent)]
    Estimator(#[from] EstimatorError),
    /// Features of a regressor.
    #[error(transparent)]
    Features(#[from] FeatureError),
    /// A regressor cannot be fitted.
    #[error(transparent)]
    Regress(#[from] RegressError),
    /// Networks that have no checksum.
    #[error(transparent)]
    Weights(#[from] StoreError),
    /// A set of windows that cannot be kept.
    #[error(transparent)]
    Io(#[from] IoError),
    /// Stopped from outside; what is finished is kept.
    #[error("stopped after {done} of {total} sets of windows")]
    Stopped {
        /// Sets whose rows are on disk.
        done: usize,
        /// Sets in all.
        total: usize,
    },
    /// Nothing to judge on.
    #[error("no windows to judge on in {0}; give longer recordings")]
    NoWindows(String),
}
