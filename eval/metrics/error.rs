//! Why a metric cannot be computed.

use crate::stats::StatsError;
use dpn_core::named;
use dpn_core::trajectory::StampedPose;
use thiserror::Error;

named!(
    /// Which of the two trajectories a fault is in.
    pub enum Trajectory {
        /// The ground truth.
        Truth = "ground truth",
        /// What is judged.
        Estimate = "estimate",
    }
);

/// Why a metric cannot be computed.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum MetricsError {
    /// No pose at all.
    #[error("the {trajectory} holds no pose")]
    Empty {
        /// Which one.
        trajectory: Trajectory,
    },
    /// Stamps that stand still or go back.
    #[error(
        "the {trajectory}'s stamps do not increase at pose {index} ({t_ns} ns); sort it and drop repeats"
    )]
    TimeNotIncreasing {
        /// Which one.
        trajectory: Trajectory,
        /// Index of the offending pose.
        index: usize,
        /// Its stamp.
        t_ns: i64,
    },
    /// NaN or infinity.
    #[error("the {trajectory}'s pose {index} ({t_ns} ns) holds a value that is not finite")]
    NotFinite {
        /// Which one.
        trajectory: Trajectory,
        /// Index of the offending pose.
        index: usize,
        /// Its stamp.
        t_ns: i64,
    },
    /// An option out of its range.
    #[error("`{name}` is {value}; it must be {bound}")]
    BadOption {
        /// The option.
        name: &'static str,
        /// Its value.
        value: f64,
        /// What it may be.
        bound: &'static str,
    },
    /// Fewer pairs than an alignment or a metric needs.
    #[error(
        "{found} pairs of poses; {what} needs {needed}: do the stamps of estimate and ground truth share a clock?"
    )]
    TooFewPairs {
        /// What was asked for.
        what: &'static str,
        /// How many it needs.
        needed: usize,
        /// How many there are.
        found: usize,
    },
    /// Stretches that are longer than the trajectory.
    #[error("no stretch of {spec} among {pairs} pairs of poses: take a shorter one, or a wider tolerance")]
    NoStretch {
        /// The stretches asked for.
        spec: String,
        /// How many pairs there are.
        pairs: usize,
    },
    /// The positions do not determine the rotation (a point, a straight line) or the scale.
    #[error(
        "the positions leave {what} undetermined (relative gap {gap:.1e}): a point or a straight line; align position alone"
    )]
    Degenerate {
        /// What is undetermined.
        what: &'static str,
        /// How well the best solution is told from the next, relative to the extent of the positions; 0 is not at all.
        gap: f64,
    },
    /// No covariance for a pair's pose.
    #[error("{covariances} covariances; a pair belongs to pose {index} of the estimate: give one a pose")]
    CovarianceMissing {
        /// Index of the pose in the estimate.
        index: usize,
        /// How many covariances were given.
        covariances: usize,
    },
    /// A covariance that is none.
    #[error(
        "the covariance of pose {index} ({t_ns} ns) is not positive definite; leave out poses that the gauge fixes"
    )]
    NotPositiveDefinite {
        /// Index of the pose in the estimate.
        index: usize,
        /// Its stamp.
        t_ns: i64,
    },
    /// A bound from a distribution.
    #[error(transparent)]
    Stats(#[from] StatsError),
}

/// Checks what every metric assumes of a trajectory: at least one pose, finite, in increasing time.
pub(super) fn check(poses: &[StampedPose], trajectory: Trajectory) -> Result<(), MetricsError> {
    if poses.is_empty() {
        return Err(MetricsError::Empty { trajectory });
    }
    for (index, pose) in poses.iter().enumerate() {
        let t_ns = pose.t.ns();
        let mut values =
            pose.world_from_body.translation.vector.iter().chain(pose.world_from_body.rotation.coords.iter());
        if !values.all(|v| v.is_finite()) {
            return Err(MetricsError::NotFinite { trajectory, index, t_ns });
        }
        if index > 0 && poses[index - 1].t >= pose.t {
            return Err(MetricsError::TimeNotIncreasing { trajectory, index, t_ns });
        }
    }
    Ok(())
}

/// Refuses an option that is not positive and finite.
pub(super) fn positive(name: &'static str, value: f64) -> Result<(), MetricsError> {
    if value.is_finite() && value > 0.0 {
        return Ok(());
    }
    let bound = "positive and finite";
    Err(MetricsError::BadOption { name, value, bound })
}
