//! Why a published ground truth cannot be reconciled.

use dpn_core::config::ConfigFaults;
use dpn_core::trajectory::StampedPose;
use dpn_core::{ImuSample, Stamp};
use thiserror::Error;

/// Why there is no reconciled ground truth.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum TruthError {
    /// Settings out of their bounds.
    #[error(transparent)]
    Config(#[from] ConfigFaults),
    /// Too little of one or the other.
    #[error(
        "{poses} published poses and {samples} samples lie within each other's time; at least {least} of each are needed"
    )]
    TooShort {
        /// Poses.
        poses: usize,
        /// Samples.
        samples: usize,
        /// The fewest.
        least: usize,
    },
    /// No pose close to a sample.
    #[error(
        "the poses go from {} to {} ns and the samples from {} to {}: no pose lies within their time; shift the poses' stamps to the samples' clock",
        poses_ns[0], poses_ns[1], samples_ns[0], samples_ns[1]
    )]
    NoOverlap {
        /// First and last stamp of the poses.
        poses_ns: [i64; 2],
        /// First and last stamp of the samples.
        samples_ns: [i64; 2],
    },
    /// The rates do not agree, whatever the delay.
    #[error(
        "the published poses do not turn as the gyro does: their rates correlate by {correlation:.2} at best, with clocks up to \
        {longest_delay_s} s apart; it is another clock, another flight, or the rotation is none that was measured"
    )]
    RatesDisagree {
        /// The largest correlation.
        correlation: f64,
        /// The largest delay tried \[s\].
        longest_delay_s: f64,
    },
    /// The absolute rates agree, their directions do not.
    #[error(
        "no turn of the body's frame takes the published rates to the gyro's: {:.0} % of them is explained; are the quaternions \
        world from body, w first?", 100.0 * share
    )]
    AxesDisagree {
        /// The share of the gyro's square that is explained.
        share: f64,
    },
    /// The mean specific force is not gravity.
    #[error(
        "the accelerometer reads {found:.2} m/s^2 on average through the published attitude, gravity is 9.81; check units and frames"
    )]
    NotGravity {
        /// What it reads.
        found: f64,
    },
    /// A trajectory whose unit is none of length.
    #[error(
        "the trajectory is {scale:.2} times as large as the accelerometer says; where it is not in metres, as of one camera alone, multiply the positions by {:.3}; where it is, its quaternions \
        are not world from body in the order of its format (TUM: x y z w)", 1.0 / scale
    )]
    NotMetric {
        /// Its scale.
        scale: f64,
    },
    /// The adjustment broke down.
    #[error("the adjustment is singular {}; published poses and samples have nothing in common there", at(*.seconds))]
    Singular {
        /// Seconds after the first sample; `None` for the frames.
        seconds: Option<f64>,
    },
    /// Nothing is good enough.
    #[error(
        "nowhere is the reconciled pose known to {position_limit_m} m and {rotation_limit_deg} deg (at best {best_m:.4} m, {best_deg:.3} deg); \
        published poses and samples disagree, or raise the limits"
    )]
    NothingTrusted {
        /// The limit.
        position_limit_m: f64,
        /// The limit.
        rotation_limit_deg: f64,
        /// The least deviation of position.
        best_m: f64,
        /// The least deviation of rotation.
        best_deg: f64,
    },
}

impl TruthError {
    pub(crate) fn no_overlap(poses: &[StampedPose], samples: &[ImuSample]) -> Self {
        let ends = |first: Option<Stamp>, last: Option<Stamp>| [first, last].map(|t| t.map_or(0, Stamp::ns));
        Self::NoOverlap {
            poses_ns: ends(poses.first().map(|p| p.t), poses.last().map(|p| p.t)),
            samples_ns: ends(samples.first().map(|s| s.t), samples.last().map(|s| s.t)),
        }
    }
}

fn at(seconds: Option<f64>) -> String {
    seconds.map_or_else(|| "in its frames".to_owned(), |s| format!("at {s:.1} s"))
}
