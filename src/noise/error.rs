//! Why there is no noise.

use dpn_core::Sensor;
use dpn_core::estimate::SpecError;
use dpn_io::IoError;
use dpn_pronet::StoreError;
use dpn_pronet::model::PairError;
use dpn_pronet::network::UnknownNetwork;
use std::path::PathBuf;
use thiserror::Error;

/// Least and largest deviation that a noise may say, in the sensor's unit: far beyond any IMU's, and far from where squares and their inverses end.
pub(super) const LEAST: f64 = 1e-9;
pub(super) const MOST: f64 = 1e9;

/// Why a spec says nothing of samples as they come.
#[derive(Debug, Error)]
pub enum CausalError {
    /// Parameters of the spec.
    #[error(transparent)]
    Spec(#[from] SpecError),
    /// A network nobody has.
    #[error("`{spec}`: {source}")]
    NoNetwork {
        /// The spec.
        spec: String,
        /// What was asked for, and what there is.
        source: UnknownNetwork,
    },
    /// Two networks that are no pair.
    #[error(transparent)]
    Pair(#[from] PairError),
    /// A spec that needs more than the samples so far.
    #[error("`{spec}` is not causal: it needs more than the samples so far")]
    NotCausal {
        /// The spec.
        spec: String,
    },
    /// Networks of a higher rate than the log's.
    #[error(
        "the log has {found_hz:.1} Hz; the networks of `{spec}` were trained at {trained_hz:.1} Hz and count samples, not time"
    )]
    Rate {
        /// The spec.
        spec: String,
        /// The log's rate \[Hz\].
        found_hz: f64,
        /// The networks' \[Hz\].
        trained_hz: f64,
    },
}

impl CausalError {
    /// What to do about it.
    pub fn hint(&self) -> Option<String> {
        match self {
            Self::NotCausal { .. } => {
                Some("give networks (dualpronet), a simple estimator (diff2, sg(11,2)) or constants".into())
            }
            Self::Rate { found_hz, trained_hz, .. } => Some(format!(
                "faster logs are averaged to {trained_hz:.0} Hz by themselves, a slower one has too few samples: train networks of its rate (dpn train --rate {found_hz:.0}), let the odometry find its noise (dpn run --noise self), or give a simple estimator (--noise diff2)"
            )),
            Self::Spec(_) | Self::NoNetwork { .. } | Self::Pair(_) => None,
        }
    }
}

/// Why a noise spec gives no noise for a recording.
#[derive(Debug, Error)]
pub enum NoiseError {
    /// The spec says nothing of this recording's samples.
    #[error("{recording}: {source}")]
    Causal {
        /// Name of the recording.
        recording: String,
        /// Why.
        source: CausalError,
    },
    /// The spec says nothing of any.
    #[error(transparent)]
    Spec(#[from] CausalError),
    /// A network whose weights have no checksum.
    #[error(transparent)]
    Weights(#[from] StoreError),
    /// A noise track that cannot be read.
    #[error(transparent)]
    Read(#[from] IoError),
    /// A noise track that begins too late or ends too early.
    #[error(
        "{}: the noise track goes from {from_ns} to {to_ns} ns, but {recording}'s samples from {imu_from_ns} to {imu_to_ns} ns; make the track from this recording, or cut the recording",
        path.display()
    )]
    NotCovered {
        /// The file.
        path: PathBuf,
        /// First stamp of the track.
        from_ns: i64,
        /// Last stamp of the track.
        to_ns: i64,
        /// Name of the recording.
        recording: String,
        /// Its first sample.
        imu_from_ns: i64,
        /// Its last sample.
        imu_to_ns: i64,
    },
    /// A noise track with a hole.
    #[error("{}: no noise from {from_ns} to {to_ns} ns, where {recording} has samples; make the track from this recording", path.display())]
    Hole {
        /// The file.
        path: PathBuf,
        /// Last stamp before the hole.
        from_ns: i64,
        /// First stamp after it.
        to_ns: i64,
        /// Name of the recording.
        recording: String,
    },
    /// A zero in a noise track: infinite information.
    #[error(
        "`{spec}` says a deviation of 0 for {recording} at {t_ns} ns; an IMU without noise cannot be weighed, give a value above 0"
    )]
    Zero {
        /// The spec.
        spec: String,
        /// Name of the recording.
        recording: String,
        /// The sample.
        t_ns: i64,
    },
    /// A deviation whose square, or its inverse, is no number to compute with.
    #[error(
        "`{spec}` says a deviation of {value:e} {}: no IMU's is below {LEAST:e} or above {MOST:e}; give deviations of an IMU", sensor.unit()
    )]
    Absurd {
        /// The spec.
        spec: String,
        /// Whose deviation.
        sensor: Sensor,
        /// What it says.
        value: f64,
    },
    /// True noise of a real recording.
    #[error(
        "{recording}: `oracle` is known for simulated flights alone; nobody knows the true noise of a recording"
    )]
    NoOracle {
        /// Name of the recording.
        recording: String,
    },
    /// A mean of squares, or a sum of two, beyond all numbers.
    #[error(
        "`{spec}`: the squares of its deviations add up to more than any number; give deviations of an IMU"
    )]
    TooLarge {
        /// The spec.
        spec: String,
    },
    /// Levels that no run has learned yet.
    #[error(
        "`{spec}` is learned by a run of the odometry, and there is none here; `dpn eval --closed-loop` makes that run first, or give what `dpn run --noise self` wrote: mean(file(\"noise_learned.csv\"))"
    )]
    NotLearned {
        /// The spec.
        spec: String,
    },
    /// No sequences to take a mean over.
    #[error(
        "`{spec}` needs training sequences to take the mean over, and there are none here; give constants instead: const(ACCEL,GYRO)"
    )]
    NoTraining {
        /// The spec.
        spec: String,
    },
}

impl NoiseError {
    /// What to do about it.
    pub fn hint(&self) -> Option<String> {
        match self {
            Self::Causal { source, .. } | Self::Spec(source) => source.hint(),
            Self::Read(error) => error.hint(),
            _ => None,
        }
    }
}
